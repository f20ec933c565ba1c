#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "tumble/core/tables/document.hpp"
#include "tumble/core/tables/section.hpp"
#include "tumble/exchange/certificate_number.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/confinement.hpp"
#include "tumble/report/image.hpp"
#include "tumble/report/utf8.hpp"
#include "tumble/tasks/certificate.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {
namespace {

using tables::FileProblems;
using tables::Section;

std::optional<Date> date_of(const toml::node& node) {
  if (const auto* date = node.as_date()) {
    const Date day{std::chrono::year(date->get().year), std::chrono::month(date->get().month),
                   std::chrono::day(date->get().day)};
    return day.ok() ? std::optional(day) : std::nullopt;
  }
  const auto* string = node.as_string();
  if (!string || string->get().size() != 10) return std::nullopt;
  const std::string& text = string->get();
  const auto number = [&](std::size_t begin, std::size_t size) {
    int value = -1;
    const auto [end, fault] = std::from_chars(text.data() + begin, text.data() + begin + size, value);
    return fault == std::errc{} && end == text.data() + begin + size ? value : -1;
  };
  const int year = number(0, 4), month = number(5, 2), day = number(8, 2);
  if (text[4] != '-' || text[7] != '-' || year < 0 || month < 0 || day < 0) return std::nullopt;
  const Date date{std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
                  std::chrono::day(static_cast<unsigned>(day))};
  return date.ok() ? std::optional(date) : std::nullopt;
}

/// Text as it is printed, with the blanks at its ends removed: the schema of the DCC refuses them.
std::string printed(std::string_view raw) { return std::string(trimmed(printable(raw), " ")); }

std::string text_in(Section& section, std::string_view key) { return printed(section.text(key).value_or("")); }

std::optional<Date> date_in(Section& section, std::string_view key) {
  const auto* node = section.find(key);
  if (!node) return std::nullopt;
  const auto date = date_of(*node);
  if (!date) section.problem_at(key, "a date is expected, such as 2026-11-02");
  return date;
}

bool flag_in(Section& section, std::string_view key) {
  const auto* node = section.find(key);
  if (!node) return false;
  if (const auto* flag = node->as_boolean()) return flag->get();
  section.problem_at(key, "true or false is expected");
  return false;
}

/// A number with its unit; absent, with a problem, where it is none.
std::optional<Quantity> quantity_in(Section& section, std::string_view key) {
  const auto text = section.text(key);
  if (!text) return std::nullopt;
  try {
    return parse_quantity(*text);
  } catch (const Error& error) {
    for (const auto& problem : error.problems) section.problem_at(key, problem);
    return std::nullopt;
  }
}

Contact contact_of(Section& section) {
  return {text_in(section, "name"),  text_in(section, "street"), text_in(section, "post_code"),
          text_in(section, "city"),  text_in(section, "state"),  text_in(section, "country"),
          text_in(section, "email"), text_in(section, "phone"),  text_in(section, "link")};
}

Laboratory laboratory_of(Section& section, const std::string& folder) {
  Laboratory laboratory{contact_of(section), text_in(section, "code"), {}};
  const auto logo = text_in(section, "logo");
  if (logo.empty()) return laboratory;
  try {
    laboratory.logo = data_uri_of_image_file(file_named_in(folder, logo));
  } catch (const Error& error) {
    for (const auto& problem : error.problems) section.problem_at("logo", problem);
  }
  return laboratory;
}

Person person_of(Section& section) {
  return {text_in(section, "name"), text_in(section, "role"), flag_in(section, "signs")};
}

Equipment equipment_of(Section& section) {
  Equipment one{text_in(section, "name"),
                text_in(section, "manufacturer"),
                text_in(section, "model"),
                text_in(section, "serial"),
                text_in(section, "certificate"),
                date_in(section, "due"),
                text_in(section, "traceable_to"),
                text_in(section, "certificate_sha256"),
                text_in(section, "accepted_out_of_date")};
  if (one.name.empty()) section.missing("name", "\"dividing head\"");
  const auto& hash = one.certificate_sha256;
  if (!hash.empty() && (hash.size() != 64 || !is_hex(hash)))
    section.problem_at("certificate_sha256", "64 digits of 0 to 9 and a to f are expected");
  return one;
}

Condition condition_of(Section& section) {
  Condition condition{.name = text_in(section, "name"), .value = 0.0, .uncertainty = {}, .unit = {}};
  if (condition.name.empty()) section.missing("name", "\"temperature\"");
  const auto value = quantity_in(section, "value"), uncertainty = quantity_in(section, "uncertainty");
  if (!value && section.find("value") == nullptr) section.missing("value", "\"23.0 degC\"");
  if (!value) return condition;
  condition.unit = value->unit;
  condition.value = value->unit.to_si(value->value);
  if (!uncertainty) return condition;
  if (uncertainty->unit.dimension() != value->unit.dimension() || !(uncertainty->value > 0.0))
    section.problem_at("uncertainty", "a positive quantity in the unit of the value is expected");
  condition.uncertainty = uncertainty->unit.difference_to_si(uncertainty->value);
  return condition;
}

KnownPopulation population_of(Section& section) {
  KnownPopulation known{.parameter = text_in(section, "parameter"), .population = {}, .unit = {}};
  if (known.parameter.empty()) section.missing("parameter", "\"bias\"");
  const auto mean = quantity_in(section, "mean"), sd = quantity_in(section, "sd");
  if (!mean && section.find("mean") == nullptr) section.missing("mean", "\"0 deg/h\"");
  if (!sd && section.find("sd") == nullptr) section.missing("sd", "\"0.01 deg/h\"");
  if (!mean || !sd) return known;
  if (mean->unit.dimension() != sd->unit.dimension() || !(sd->value > 0.0))
    section.problem_at("sd", "a positive quantity in the unit of the mean is expected");
  known.unit = mean->unit;
  known.population = {mean->unit.to_si(mean->value), sd->unit.difference_to_si(sd->value)};
  return known;
}

void read_certificate(Section& section, CertificateDetails& details) {
  details.number = text_in(section, "number");
  if (const auto problem = problem_of_certificate_number(details.number); !problem.empty())
    section.problem_at("number", problem);
  details.received = date_in(section, "received"), details.begun = date_in(section, "begun");
  details.ended = date_in(section, "ended"), details.issued = date_in(section, "issued");
  details.place = text_in(section, "place"), details.traceability = text_in(section, "traceability");
  details.norm = text_in(section, "norm");
  details.replaces = text_in(section, "replaces"), details.replaces_reason = text_in(section, "replaces_reason");
  details.rule_agreed_with = text_in(section, "rule_agreed_with");
  for (const auto& remark : section.texts("remarks"))
    if (auto text = printed(remark); !text.empty()) details.remarks.push_back(std::move(text));
  const auto place = text_in(section, "signatures");
  if (!place.empty() && place != "archive" && place != "hand")
    section.problem_at("signatures", say("'{}' is not known: archive or hand is expected", place));
  details.signed_in_archive = place == "archive";
  if (const auto rule = section.text("rule")) try {
      details.rule = parse_decision_rule(*rule);
    } catch (const Error& error) {
      for (const auto& problem : error.problems) section.problem_at("rule", problem);
    }
  const std::string language = section.text("language").value_or("en");
  const auto& codes = language_codes();
  const auto found = std::ranges::find(codes, language);
  if (found == codes.end())
    section.problem_at("language", say("'{}' is not known: en or zh is expected", language));
  else
    details.language = static_cast<Language>(found - codes.begin());
}

/// The values of the command line in place of those of the file.
void override_values(toml::table& document, const Sets& sets, FileProblems& problems) {
  for (const auto& [key, value] : sets) {
    const auto dot = key.find('.');
    const std::string section = key.substr(0, dot);
    if (dot == std::string::npos ||
        (section != "laboratory" && section != "customer" && section != "item" && section != "certificate")) {
      problems.all.push_back(
          say("--set {}: laboratory.KEY, customer.KEY, item.KEY or certificate.KEY is expected", Name{key}));
      continue;
    }
    auto* table = document.get_as<toml::table>(section);
    if (!table) table = document.insert_or_assign(section, toml::table{}).first->second.as_table();
    table->insert_or_assign(key.substr(dot + 1), value);
  }
}

/// Each table of a list [[name]].
template <class Read>
auto list_of(Section& root, const char* name, FileProblems& problems, const Read& read) {
  std::vector<decltype(read(root))> all;
  const auto* node = root.find(name);
  if (!node) return all;
  const auto* array = node->as_array();
  if (!array) {
    root.problem_at(name, say("a list is expected: [[{}]]", name));
    return all;
  }
  for (const auto& element : *array) {
    const auto* table = element.as_table();
    if (!table) {
      root.problem_at(name, say("a list of tables is expected: [[{}]]", name));
      continue;
    }
    Section section(*table, fmt::format("[[{}]]", name), problems);
    all.push_back(read(section));
    section.close();
  }
  return all;
}

/// A table [name], or an empty one.
template <class Read>
void read_table(Section& root, const char* name, FileProblems& problems, const Read& read) {
  static const toml::table nothing;
  const auto* table = root.table(name);
  Section section(table ? *table : nothing, fmt::format("[{}]", name), problems);
  read(section);
  section.close();
}

}  // namespace

CertificateDetails load_lab(const std::string& path, const Sets& sets) {
  auto document = tables::document_of(read_text_file(path), path);
  FileProblems problems{.file = path, .all = {}};
  override_values(document, sets, problems);
  Section root(document, "", problems);
  CertificateDetails details{.file = path};
  const auto folder = std::filesystem::path(path).parent_path().string();
  read_table(root, "laboratory", problems, [&](Section& s) { details.laboratory = laboratory_of(s, folder); });
  read_table(root, "customer", problems, [&](Section& s) { details.customer = contact_of(s); });
  read_table(root, "item", problems, [&](Section& s) {
    details.item = {text_in(s, "name"), text_in(s, "manufacturer"), text_in(s, "model"), text_in(s, "serial"),
                    text_in(s, "customer_number")};
  });
  read_table(root, "certificate", problems, [&](Section& s) { read_certificate(s, details); });
  details.persons = list_of(root, "person", problems, person_of);
  details.equipment = list_of(root, "equipment", problems, equipment_of);
  details.conditions = list_of(root, "condition", problems, condition_of);
  details.populations = list_of(root, "population", problems, population_of);
  root.close();
  if (!problems.all.empty()) throw Error(Error::Kind::bad_input, problems.sorted());
  return details;
}

}  // namespace tumble
