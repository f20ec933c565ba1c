#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "tumble/core/json_text.hpp"
#include "tumble/report/error_model/json.hpp"
#include "tumble/report/limit_text.hpp"
#include "tumble/report/report.hpp"
#include "tumble/report/result_members.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/report/shape.hpp"
#include "tumble/report/shown_value.hpp"
#include "tumble/version.hpp"

namespace tumble {
namespace {

using Json = nlohmann::ordered_json;

Json finite(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json value_in(double si, const Unit& unit) { return finite(shown_value(si, unit)); }

Json covariance_in(double si, const Unit& a, const Unit& b) {
  const double factor = a.factor() * b.factor();
  return finite(shown_value(
      si, [&](double x) { return x * factor; }, [&](double x) { return x / factor; }));
}

Json difference_in(double si, const Unit& unit) {
  return finite(shown_value(
      si, [&](double x) { return unit.difference_to_si(x); }, [&](double x) { return unit.difference_from_si(x); }));
}

/// sd and interval come from the numbers shown, so that the file agrees with itself to the last digit.
Json parameter_json(const Estimate& estimate, std::size_t i) {
  const auto& parameter = estimate.parameters[i];
  const auto value = value_in(parameter.value, parameter.unit);
  const auto variance = covariance_in(estimate.covariance(i, i), parameter.unit, parameter.unit);
  const double sd = variance.is_null() ? NAN : std::sqrt(variance.get<double>());
  auto [lower, upper] = interval95(value.is_null() ? NAN : value.get<double>(), sd, parameter.degrees_of_freedom);
  const bool own = std::isfinite(parameter.lower) && std::isfinite(parameter.upper);
  if (own) lower = parameter.unit.from_si(parameter.lower), upper = parameter.unit.from_si(parameter.upper);
  Json json{{"name", parameter.name},
            {"symbol", parameter.symbol},
            {"value", value},
            {"sd", finite(sd)},
            {"unit", parameter.unit.text()},
            {"description", parameter.description},
            {"degrees_of_freedom", finite(parameter.degrees_of_freedom)},
            {"interval95", {finite(lower), finite(upper)}}};
  if (own) json["own_interval"] = true;
  for (const auto& term : parameter.contains)
    json["contains"].push_back(Json{{"term", term.name},
                                    {"unit", term.unit.text()},
                                    {"weight", finite(term.weight * term.unit.factor() / parameter.unit.factor())}});
  return json;
}

Json parameters_json(const Estimate& estimate) {
  auto array = Json::array();
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) array.push_back(parameter_json(estimate, i));
  return array;
}

Json covariance_json(const Estimate& estimate) {
  auto rows = Json::array();
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    auto row = Json::array();
    for (std::size_t j = 0; j < estimate.parameters.size(); ++j) {
      row.push_back(covariance_in(estimate.covariance(i, j), estimate.parameters[i].unit, estimate.parameters[j].unit));
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

/// Root of the sum of squares of the numbers shown, so that the file agrees with itself to the last digit.
Json sd_of(const Json& row) {
  double squares = 0.0;
  for (const auto& element : row) squares += element.is_null() ? NAN : element.get<double>() * element.get<double>();
  return finite(std::sqrt(squares));
}

Json budget_json(const Estimate& estimate) {
  auto array = Json::array();
  for (const auto& part : estimate.budget) {
    auto sd = Json::array();
    auto factor = Json::array();
    for (std::size_t i = 0; i < part.factor.rows; ++i) {
      const Unit& unit = estimate.parameters[i].unit;
      auto row = Json::array();
      for (std::size_t k = 0; k < part.factor.columns; ++k) row.push_back(difference_in(part.factor(i, k), unit));
      sd.push_back(sd_of(row));
      factor.push_back(std::move(row));
    }
    array.push_back({{"source", part.source},
                     {"key", part.key.empty() ? Json(nullptr) : Json(part.key)},
                     {"sd", std::move(sd)},
                     {"factor", std::move(factor)}});
  }
  return array;
}

Json table_json(const Table& table) {
  auto columns = Json::array();
  for (const auto& column : table.columns) columns.push_back({{"name", column.name}, {"unit", column.unit.text()}});
  auto rows = Json::array();
  for (const auto& cells : table.rows) {
    auto row = Json::array();
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const auto* number = std::get_if<double>(&cells[i]);
      row.push_back(number ? value_in(*number, table.columns[i].unit) : Json(std::get<std::string>(cells[i])));
    }
    rows.push_back(std::move(row));
  }
  Json json{{"name", table.name}, {"caption", table.caption}, {"columns", columns}, {"rows", std::move(rows)}};
  if (table.for_programs) json["for_programs"] = true;
  return json;
}

template <HasMembers<MembersToJson> T>
Json members_json(const T& value) {
  Json json = Json::object();
  MembersToJson visit{JsonObject(&json)};
  members(visit, value);
  return json;
}

template <class Item, class ToJson>
Json array_of(const std::vector<Item>& items, const ToJson& to_json_of) {
  auto array = Json::array();
  for (const auto& item : items) array.push_back(to_json_of(item));
  return array;
}

struct ValueJson {
  const Unit& unit;

  Json operator()(double si) const {
    const double shown = unit.from_si(si);
    return unit.text() == "1" ? finite(shown) : Json{{"value", finite(shown)}, {"unit", unit.text()}};
  }
  Json operator()(long long value) const { return value; }
  Json operator()(const std::string& value) const { return value; }
  Json operator()(const Phrase& phrase) const { return {{"phrase", phrase.key}}; }
};

Json place_json(const Place& place) {
  Json json = Json::object();
  if (!place.label.empty()) json["label"] = place.label;
  if (std::isfinite(place.time)) json["time"] = place.time;
  return json;
}

Json finding_json(const Finding& finding) {
  constexpr std::array words{"info", "warning", "error"};
  Json json{{"severity", words[static_cast<std::size_t>(finding.severity)]},
            {"code", finding.code},
            {"message", finding.message},
            {"where", finding.where},
            {"count", finding.occurrences.count}};
  if (finding.occurrences.first.given()) json["first"] = place_json(finding.occurrences.first);
  if (finding.occurrences.worst.given()) json["worst"] = place_json(finding.occurrences.worst);
  std::map<std::string, Json> values;  // by name, as they are read
  for (const auto& value : finding.values) values[value.name] = std::visit(ValueJson{value.unit}, value.value);
  json["values"] = Json::object();
  for (auto& [name, value] : values) json["values"][name] = std::move(value);
  return json;
}

/// A finding of a result: which parameters it concerns, and which are below its limit.
Json finding_of_result_json(const Finding& finding) {
  Json json = finding_json(finding);
  if (!finding.about.empty() || finding.severity == Finding::Severity::error) json["about"] = finding.about;
  for (const HiddenParameter& hidden : finding.hidden)
    json["hidden"].push_back(Json{{"name", hidden.name}, {"channel", hidden.channel}});
  return json;
}

Json bound_json(const Bound& bound) { return {{"value", finite(written_value(bound))}, {"unit", bound.unit.text()}}; }

/// The text of the limit is for readers of before, which have no ends.
Json verdict_json(const Verdict& verdict) {
  constexpr std::array words{"pass", "fail", "undecided"};
  Json json{{"parameter", verdict.parameter},
            {"outcome", words[static_cast<std::size_t>(verdict.outcome)]},
            {"limit", limit_text(verdict.limit)}};
  if (verdict.limit.lower) json["lower"] = bound_json(*verdict.limit.lower);
  if (verdict.limit.upper) json["upper"] = bound_json(*verdict.limit.upper);
  return json;
}

Json object_of(const std::map<std::string, std::string>& texts) {
  auto object = Json::object();
  for (const auto& [key, text] : texts) object[key] = text;
  return object;
}

Json provenance_json(const Provenance& provenance) {
  const auto input = [](const Provenance::Input& i) { return Json{{"file", i.file}, {"sha256", i.sha256}}; };
  const auto plan = [](const Provenance::PlanFile& p) {
    return Json{{"file", p.file}, {"sha256", p.sha256}, {"text", p.text ? Json(*p.text) : Json(nullptr)}};
  };
  Json json{{"inputs", array_of(provenance.inputs, input)},
            {"plans", array_of(provenance.plans, plan)},
            {"settings", object_of(provenance.settings)},
            {"command_line", object_of(provenance.command_line)},
            {"seed", provenance.seed ? Json(*provenance.seed) : Json(nullptr)}};
  if (provenance.memory) json["memory"] = *provenance.memory;
  return json;
}

/// Values, covariance and budget alone.
Json numbers_json(const Estimate& estimate) {
  return {{"parameters", parameters_json(estimate)},
          {"covariance", covariance_json(estimate)},
          {"budget", budget_json(estimate)}};
}

Json prior_json(const PriorUse& use) {
  const auto input = [](const Provenance::Input& i) { return Json{{"file", i.file}, {"sha256", i.sha256}}; };
  Json json{{"from", use.from},
            {"verdicts", use.verdicts},
            {"used", use.with_prior != nullptr},
            {"belongs", finite(use.belongs)},
            {"belongs_by_one", finite(use.belongs_by_one)},
            {"model", use.population->instrument_model},
            {"population", members_json(*use.population->population)},
            {"results", array_of(use.population->provenance.inputs, input)}};
  json.update(numbers_json(*use.population));
  return json;
}

Json whole(const Estimate& estimate) {
  Json json{{"tumble", version},
            {"method", estimate.method},
            {"title", estimate.title},
            {"instrument", {{"model", estimate.instrument_model}, {"serial", estimate.instrument_serial}}},
            {"parameters", parameters_json(estimate)},
            {"covariance", covariance_json(estimate)},
            {"budget", budget_json(estimate)},
            {"models", error_model::models_json(estimate.models)},
            {"tables", array_of(estimate.tables, table_json)},
            {"curves", array_of(estimate.curves, members_json<Curve>)},
            {"fit", members_json(estimate.fit)},
            {"findings", array_of(estimate.findings, finding_of_result_json)},
            {"verdicts", array_of(estimate.verdicts, verdict_json)},
            {"provenance", provenance_json(estimate.provenance)}};
  if (estimate.population) json["population"] = members_json(*estimate.population);
  if (estimate.prior) json["prior"] = prior_json(*estimate.prior);
  if (estimate.prior && estimate.prior->with_prior) json["with_prior"] = numbers_json(*estimate.prior->with_prior);
  return json;
}

/// Shortest decimal that reads back as the same double, always recognisable as a real number: "3.0".
void write_number(double value, std::string& out) {
  std::array<char, 32> text;
  const std::string_view digits(text.data(), std::to_chars(text.begin(), text.end(), value).ptr);
  out += digits;
  if (digits.find_first_of(".e") == std::string_view::npos) out += ".0";
}

void write(const Json& value, std::size_t indent, std::string& out);

/// Objects and arrays of arrays one member a line, arrays of numbers and small objects on one line: made to be read
/// and compared by people as well.
void write_members(const Json& value, std::size_t indent, std::string& out) {
  const bool object = value.is_object();
  const bool flat = std::all_of(value.begin(), value.end(), [](const Json& item) { return item.is_primitive(); }) &&
                    (!object || value.size() <= 4);
  const std::string gap = flat ? "" : "\n" + std::string(indent + 1, ' ');
  out += object ? '{' : '[';
  for (auto item = value.begin(); item != value.end(); ++item) {
    if (item != value.begin()) out += flat ? ", " : ",";
    out += gap;
    if (object) out += json_text(Json(item.key())) + ": ";
    write(*item, indent + 1, out);
  }
  if (!flat && !value.empty()) out += "\n" + std::string(indent, ' ');
  out += object ? '}' : ']';
}

void write(const Json& value, std::size_t indent, std::string& out) {
  if (value.is_number_float()) {
    write_number(value.get<double>(), out);
  } else if (value.is_primitive()) {
    out += json_text(value);
  } else {
    write_members(value, indent, out);
  }
}

}  // namespace

std::string to_json(const Findings& findings) {
  std::string text;
  write(array_of(findings, finding_json), 0, text);
  return text;
}

std::string to_json(const Estimate& estimate) {
  require_shape(estimate);
  std::string text;
  write(whole(estimate), 0, text);
  return text + "\n";
}

}  // namespace tumble
