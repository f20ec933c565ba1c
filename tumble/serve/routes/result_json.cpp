#include "tumble/serve/routes/result_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/language/said.hpp"
#include "tumble/report/figure.hpp"
#include "tumble/report/in_language.hpp"
#include "tumble/report/limit_text.hpp"
#include "tumble/report/names.hpp"
#include "tumble/report/parameter_rows.hpp"
#include "tumble/report/report.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/report/typeset.hpp"
#include "tumble/serve/routes/answers.hpp"
#include "tumble/serve/routes/numbers.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::routes {
namespace {

const char* word_of(Verdict::Outcome outcome) {
  switch (outcome) {
    case Verdict::Outcome::pass:
      return "pass";
    case Verdict::Outcome::fail:
      return "fail";
    case Verdict::Outcome::undecided:
      break;
  }
  return "undecided";
}

Json both(const SplitNumber& number) { return {number.before, number.after}; }

Json budget_of(const Estimate& estimate, std::size_t i, Language language) {
  Json parts = Json::array();
  for (const auto& part : estimate.budget) {
    const double share = part.variance(i) / estimate.covariance(i, i);
    const auto [sd, percent] = budget_cell(estimate, part, i, language);
    parts.push_back({{"sd", number_in_characters(sd)},
                     {"percent", percent},
                     {"share", std::isfinite(share) ? Json(share) : Json()}});
  }
  return parts;
}

Json parameters_of(const Estimate& estimate, const Estimate& budget, Language language) {
  Json all = Json::array();
  const auto rows = parameter_rows(estimate);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto& row = rows[i];
    all.push_back({{"name", row.name},
                   {"readable", readable_name(language, row.name, estimate.method)},
                   {"symbol", row.symbol},
                   {"description", row.description},
                   {"unit", row.unit},
                   {"units", units_like(estimate.parameters[i].unit)},
                   {"value", both(row.value)},
                   {"sd", both(row.sd)},
                   {"power", row.power},
                   {"text", row.text},
                   {"lower", both(row.lower)},
                   {"upper", both(row.upper)},
                   {"degrees_of_freedom", number_in_characters(row.degrees_of_freedom)},
                   {"budget", budget_of(budget, i, language)}});
  }
  return all;
}

/// A value with its power and unit, and its standard uncertainty beside it: in Chinese "±" would mean an expanded one.
struct MeasuredTexts {
  std::string value, sd;
};

MeasuredTexts measured_texts(const Estimate& estimate, const std::string& name, Language language) {
  const auto found = std::ranges::find(estimate.parameters, name, &Parameter::name);
  if (found == estimate.parameters.end()) return {measured_text(estimate, name, language), ""};
  const auto row = parameter_row(estimate, static_cast<std::size_t>(found - estimate.parameters.begin()));
  const auto tail = (row.power.empty() ? "" : " " + row.power) + (row.unit == "1" ? "" : " " + row.unit);
  const auto text = [&](const SplitNumber& number) {
    return number.before.empty() ? "" : number_in_characters(number.before) + number.after + tail;
  };
  return {text(row.value), text(row.sd)};
}

Json verdicts_of(const Estimate& estimate, Language language) {
  Json all = Json::array();
  for (const auto& verdict : estimate.verdicts) {
    const auto [value, sd] = measured_texts(judged(estimate), verdict.parameter, language);
    all.push_back({{"parameter", verdict.parameter},
                   {"readable", readable_name(language, verdict.parameter, estimate.method)},
                   {"outcome", word_of(verdict.outcome)},
                   {"limit", limit_in_characters(verdict.limit)},
                   {"measured", value},
                   {"sd", sd}});
  }
  return all;
}

Json provenance_of(const Provenance& provenance) {
  Json inputs = Json::array(), plans = Json::array();
  for (const auto& input : provenance.inputs) inputs.push_back({{"file", input.file}, {"sha256", input.sha256}});
  for (const auto& plan : provenance.plans)
    plans.push_back({{"file", plan.file}, {"sha256", plan.sha256}, {"text", plan.text.value_or("")}});
  return {{"inputs", inputs},
          {"plans", plans},
          {"settings", provenance.settings},
          {"command_line", provenance.command_line},
          {"seed", provenance.seed ? Json(*provenance.seed) : Json()}};
}

Json fit_of(const Fit& fit) {
  if (fit.observations == 0) return nullptr;
  const bool known = std::isfinite(fit.chi_square) && fit.degrees_of_freedom > 0.0;
  return {{"observations", fit.observations},
          {"degrees_of_freedom", general(fit.degrees_of_freedom)},
          {"chi_square", known ? fmt::format("{:#.3g}", fit.chi_square / fit.degrees_of_freedom) : ""}};
}

Json pair_of_results(const ResultPair& pair, Language language) {
  Json rows = Json::array();
  for (const auto& one : pair.differences) {
    const auto texts = texts_of(one);
    rows.push_back({{"parameter", one.parameter},
                    {"readable", readable_name(language, one.parameter)},
                    {"unit", one.unit.text()},
                    {"earlier", number_in_characters(texts.earlier)},
                    {"later", number_in_characters(texts.later)},
                    {"difference", number_in_characters(texts.difference)},
                    {"e_n", number_in_characters(texts.e_n)},
                    {"significant", std::abs(one.e_n) > 1.0}});
  }
  return {{"earlier", pair.earlier},
          {"later", pair.later},
          {"differences", rows},
          {"together", chi_square_text(pair, language)}};
}

/// E_n asks whether one instrument changed: two results that somebody chose, or more of one serial number.
bool is_about_one_instrument(const std::vector<NamedResult>& results) {
  const auto& serial = results.front().estimate.instrument_serial;
  return results.size() == 2 || (!serial.empty() && std::ranges::all_of(results, [&](const NamedResult& one) {
           return one.estimate.instrument_serial == serial;
         }));
}

Json texts_of_units(const std::vector<NamedResult>& results, const Figure& figure, Language language) {
  Json texts = Json::array();
  for (const auto& [name, estimate] : results) {
    const auto [value, sd] = measured_texts(estimate, figure.name, language);
    texts.push_back({{"value", value}, {"sd", sd}});
  }
  return texts;
}

}  // namespace

void show_in_units(const std::vector<std::string>& units, Estimate& estimate) {
  Problems problems;
  for (const auto& text : units) {
    const auto at = text.rfind('~');
    const auto name = text.substr(0, at);
    const auto found = std::ranges::find(estimate.parameters, name, &Parameter::name);
    if (at == std::string::npos || found == estimate.parameters.end()) {
      problems.push_back(say("there is no parameter '{}'", name));
      continue;
    }
    const Unit unit = Unit::parse(text.substr(at + 1));
    if (unit.dimension() != found->unit.dimension())
      problems.push_back(
          say("'{}' is in {}, which is not a kind of {}", name, Name{found->unit.text()}, Name{unit.text()}));
    else
      found->unit = unit;
  }
  if (!problems.empty()) throw Error{Error::Kind::bad_input, problems};
}

Json json_of_result(const Estimate& original, Language language) {
  const Estimate estimate = in_language(language, original);
  Estimate budget;
  budget.parameters = estimate.parameters;
  budget.covariance = estimate.covariance;
  budget.budget = budget_to_show(estimate, language);
  Json sources = Json::array(), figures = Json::array();
  for (const auto& part : budget.budget) sources.push_back(part.source);
  for (const auto& figure : figures_of(original)) figures.push_back(readable_name(language, figure.name));
  Json answer{{"method", estimate.method},
              {"method_name", result_words_in(language, estimate.method).value_or(estimate.method)},
              {"title", estimate.title},
              {"model", estimate.instrument_model},
              {"serial", estimate.instrument_serial},
              {"fit", fit_of(estimate.fit)},
              {"verdicts", verdicts_of(estimate, language)},
              {"sources", sources},
              {"parameters", parameters_of(estimate, budget, language)},
              {"findings", findings_in(language, Json::parse(to_json(estimate.findings)))},
              {"figures", figures},
              {"correlation", correlation_json(estimate)},
              {"covariance", covariance_json(estimate)},
              {"compensates", !estimate.models.empty()},
              {"provenance", provenance_of(estimate.provenance)}};
  if (estimate.prior && estimate.prior->with_prior) {
    Estimate none = *estimate.prior->with_prior;
    none.budget.clear();
    answer["with_prior"] = parameters_of(none, none, language);
  }
  return answer;
}

Json json_of_comparison(std::vector<NamedResult> results, Language language) {
  Json answer{{"results", Json::array()}, {"pairs", Json::array()}, {"findings", Json::array()}};
  for (const auto& [name, estimate] : results)
    answer["results"].push_back({{"name", name},
                                 {"method", estimate.method},
                                 {"model", estimate.instrument_model},
                                 {"serial", estimate.instrument_serial}});
  const auto figures = figures_of_units(results);
  answer["figures"] = Json::parse(to_json(in_language(language, figures)));
  answer["values"] = Json::array();
  for (std::size_t i = 0; i < figures.size(); ++i) {
    answer["figures"][i]["name"] = figures[i].name;  // that of the parameter: addresses have it
    answer["values"].push_back(texts_of_units(results, figures[i], language));
  }
  if (is_about_one_instrument(results)) {
    const Comparison comparison = compare(std::move(results));
    for (const auto& pair : comparison.pairs) answer["pairs"].push_back(pair_of_results(pair, language));
    answer["findings"] = findings_in(language, Json::parse(to_json(comparison.findings)));
  }
  return answer;
}

}  // namespace tumble::routes
