#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <pugixml.hpp>
#include <set>
#include <span>
#include <sstream>

#include "tumble/exchange/certificate.hpp"
#include "tumble/exchange/certificate/countries.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble {
namespace {

constexpr std::string_view dsi_words[] = {
    "one",    "metre",  "kilogram", "second",    "ampere",    "kelvin", "mole",    "candela",       "radian", "degree",
    "hour",   "minute", "day",      "arcminute", "arcsecond", "ppm",    "percent", "degreecelsius", "hertz",  "newton",
    "pascal", "joule",  "watt",     "volt",      "ohm",       "tesla",  "coulomb", "farad"};
constexpr std::string_view dsi_prefixes[] = {"deca", "hecto", "kilo",  "mega",  "giga", "tera",
                                             "deci", "centi", "milli", "micro", "nano", "pico"};

bool is_one_of(std::string_view word, std::span<const std::string_view> words) {
  return std::ranges::find(words, word) != words.end();
}

/// "{-1}" or "{0.5}" at the start: its length; 0 where it is none.
std::size_t exponent_size(std::string_view text) {
  const auto end = text.find('}');
  if (!text.starts_with('{') || end == text.npos || end < 2) return 0;
  const auto number = text.substr(1, end - 1);
  const bool plain = std::ranges::all_of(number.substr(number.starts_with('-') ? 1 : 0),
                                         [](char c) { return (c >= '0' && c <= '9') || c == '.'; });
  return plain && number != "-" ? end + 1 : 0;
}

/// Whether the text is a product of units of D-SI: each a prefix or none, a word, a power or none.
bool is_dsi(std::string_view text) {
  bool any = false, prefixed = false;
  while (!text.empty()) {
    if (text.front() != '\\') return false;
    const auto end = std::min(text.find_first_of("\\{", 1), text.size());
    const auto word = text.substr(1, end - 1);
    text.remove_prefix(end);
    if (word == "tothe") {
      const auto size = exponent_size(text);
      if (size == 0 || !any || prefixed) return false;
      text.remove_prefix(size);
    } else if (is_one_of(word, dsi_prefixes)) {
      if (prefixed) return false;
      prefixed = true;
    } else {
      if (!is_one_of(word, dsi_words) || (word == "one" && prefixed)) return false;
      any = true, prefixed = false;
    }
  }
  return any && !prefixed;
}

std::vector<std::string> words_of(std::string_view text) {
  std::istringstream stream{std::string(text)};
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

/// "v1.4.0": a letter, perhaps a blank, up to four numbers of at most three digits.
bool is_release(std::string_view text) {
  if (text.empty() || !((text[0] >= 'a' && text[0] <= 'z') || (text[0] >= 'A' && text[0] <= 'Z'))) return false;
  text.remove_prefix(text.size() > 1 && text[1] == ' ' ? 2 : 1);
  int parts = 1, digits = 0;
  for (const char c : text) {
    if (c == '.') {
      if (digits == 0) return false;
      ++parts, digits = 0;
    } else if (c < '0' || c > '9' || ++digits > 3) {
      return false;
    }
  }
  return digits > 0 && parts <= 4;
}

/// What is wrong with a DCC, found in one walk over its elements.
struct Walk {
  Problems problems;
  std::set<std::string> languages, ids;
  std::vector<std::pair<std::string, std::string>> references;  ///< id that is meant, and where

  void complain(const pugi::xml_node& node, const Sentence& what) {
    problems.push_back(say("{}: {}", Name{node.path('/')}, what));
  }

  void check_units(const pugi::xml_node& node, const std::string& text) {
    if (words_of(text).empty()) complain(node, "a unit of D-SI is missing");
    for (const auto& unit : words_of(text))
      if (!is_dsi(unit)) complain(node, say("'{}' is no unit of D-SI", unit));
  }

  /// Every list beside valueXMLList has one word, or as many as there are values.
  void check_list(const pugi::xml_node& node) {
    const auto values = words_of(node.child_value("si:valueXMLList")).size();
    const auto check = [&](const pugi::xml_node& list) {
      const auto count = words_of(list.child_value()).size();
      if (count != 1 && count != values) complain(list, say("{} words for {} values", count, values));
      if (std::string_view(list.child_value()).find("  ") != std::string_view::npos)
        complain(list, "two blanks in a list");
    };
    for (const char* name : {"si:labelXMLList", "si:unitXMLList"})
      if (const auto list = node.child(name)) check(list);
    for (const auto& kind : node.child("si:measurementUncertaintyUnivariateXMLList").children())
      for (const auto& list : kind.children()) check(list);
    if (const auto matrix = node.child("si:measurementUncertaintyMultivariateXMLList")
                                .child("si:ellipsoidalRegionMUXMLList")
                                .child("si:covarianceMatrixXMLList"))
      check_covariance(matrix, values,
                       words_of(node.child("si:measurementUncertaintyUnivariateXMLList")
                                    .child("si:standardMUXMLList")
                                    .child_value("si:valueStandardMUXMLList")));
  }

  /// Square, symmetric, and with the squares of the standard uncertainties on its diagonal.
  void check_covariance(const pugi::xml_node& matrix, std::size_t count, const std::vector<std::string>& sds) {
    std::vector<std::vector<double>> columns;
    for (const auto& column : matrix.children()) {
      auto& numbers = columns.emplace_back();
      for (const auto& word : words_of(column.child("si:covarianceXMLList").child_value("si:valueXMLList")))
        numbers.push_back(std::strtod(word.c_str(), nullptr));
      if (numbers.size() != count) return complain(matrix, say("a column of {} for {} values", numbers.size(), count));
    }
    if (columns.size() != count) return complain(matrix, say("{} columns for {} values", columns.size(), count));
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (columns[i][j] != columns[j][i]) return complain(matrix, "is not symmetric");
    for (std::size_t i = 0; i < std::min(count, sds.size()); ++i)
      if (const double sd = std::strtod(sds[i].c_str(), nullptr);
          !(std::abs(sd * sd - columns[i][i]) <= 1e-12 * sd * sd))
        return complain(matrix, "its diagonal is not the square of the standard uncertainties");
  }

  /// All languages once, or no language.
  void check_languages(const pugi::xml_node& node) {
    std::multiset<std::string> used;
    std::size_t contents = 0;
    for (const auto& content : node.children("dcc:content")) {
      ++contents;
      if (const auto language = content.attribute("lang")) used.insert(language.value());
    }
    if (used.empty()) return;
    if (used.size() != contents || used.size() != languages.size() || std::set(used.begin(), used.end()) != languages)
      complain(node, "each declared language must be there once");
  }

  void check_element(const pugi::xml_node& node) {
    const std::string_view name = node.name();
    const std::string text = node.child_value();
    if (name == "si:unit" || name == "si:unitXMLList") check_units(node, text);
    if (name == "si:realListXMLList") check_list(node);
    if (name == "dcc:release" && !is_release(text))
      complain(node, say("'{}': a letter and numbers such as v1.4.0 are expected", text));
    if ((name == "dcc:countryCode" || name == "dcc:countryCodeISO3166_1") && !certificate::is_country(text))
      complain(node, say("'{}' is no country of ISO 3166-1", text));
    if (const auto id = node.attribute("id")) ids.insert(id.value());
    if (const auto to = node.attribute("refId"))
      for (const auto& word : words_of(to.value())) references.emplace_back(word, node.path('/'));
    check_languages(node);
    for (const auto& child : node.children())
      if (child.type() == pugi::node_element) check_element(child);
  }

  void check_core(const pugi::xml_node& core) {
    for (const auto& language : core.children("dcc:usedLangCodeISO639_1")) languages.insert(language.child_value());
    for (const auto& language : core.children("dcc:mandatoryLangCodeISO639_1"))
      if (!languages.contains(language.child_value()))
        complain(core, "a mandatory language is not among the used ones");
    if (std::string_view(core.child_value("dcc:endPerformanceDate")) < core.child_value("dcc:beginPerformanceDate"))
      complain(core, "the test ends before it begins");
  }

  void check_results(const pugi::xml_node& results) {
    for (const auto& result : results.children("dcc:measurementResult"))
      for (const char* part : {"dcc:usedMethods", "dcc:influenceConditions"})
        if (!result.child(part)) complain(result, say("{} is missing", Name{part}));
    const auto signers =
        results.parent().child("dcc:administrativeData").child("dcc:respPersons").children("dcc:respPerson");
    if (std::none_of(signers.begin(), signers.end(), [](const auto& person) {
          return std::string_view(person.child_value("dcc:mainSigner")) == "true";
        }))
      complain(results.parent(), "nobody is the main signer");
  }
};

}  // namespace

Problems dcc_problems(const std::string& xml) {
  pugi::xml_document document;
  if (const auto read = document.load_buffer(xml.data(), xml.size()); !read)
    return {say("not XML: {} at byte {}", read.description(), read.offset)};
  const auto root = document.child("dcc:digitalCalibrationCertificate");
  if (!root) return {say("{} is missing", Name{"dcc:digitalCalibrationCertificate"})};
  Walk walk;
  walk.check_core(root.child("dcc:administrativeData").child("dcc:coreData"));
  walk.check_results(root.child("dcc:measurementResults"));
  walk.check_element(root);
  for (const auto& [id, where] : walk.references)
    if (!walk.ids.contains(id)) walk.problems.push_back(say("{}: refId '{}' is no id", Name{where}, id));
  return walk.problems;
}

}  // namespace tumble
