#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tumble/core/columns.hpp"
#include "tumble/departures/remedies.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/tasks/provenance.hpp"
#include "tumble/tasks/validate.hpp"
#include "tumble/tasks/validation/coverage.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {
namespace validation {
namespace {

using Severity = Finding::Severity;

/// Beyond this [sd] of what the number of tests lets scatter, a difference is one: p = 0.001, a parameter.
constexpr double rare_sd = 3.3;
/// A prediction is met where the scatter is between its inverse and itself [1] times the prediction.
constexpr double met_within = 1.25;
/// What a 95 % interval should hold [1].
constexpr double should_hold = 0.95;
/// So many sound tests [1] may be accused.
constexpr double may_be_accused = 0.01;

/// To three digits [1]: more of them are not known.
double rounded(double value) { return rounded_to_digits(value, 3); }

/// A difference [SI] in the unit that people are shown.
double shown_difference(const Unit& unit, double si) { return rounded(unit.difference_from_si(si)); }

Table coverage_table(const Validation& validation) {
  using Of = ValidatedParameter;
  const auto share_if_truth = [](double Of::*member) {
    return [member](const Of& one) { return one.truth ? rounded(one.*member) : std::nan(""); };
  };
  const auto in_unit = [](auto value) {
    return [value](const Of& one) { return shown_difference(one.unit, std::invoke(value, one)); };
  };
  const auto predicted = [](const Of& one) { return one.predicted.value_or(std::nan("")); };
  return tabulate(
      "coverage",
      "how often the 95 % interval of sound tests holds the truth, with the interval of this share; the "
      "scatter of the values over the predicted uncertainty",
      validation.parameters,
      {{"parameter", &Of::name},
       {"tests", &Of::tests},
       {"held", "%", [](const Of& one) { return one.truth ? rounded(one.coverage()) : std::nan(""); }},
       {"held_from", "%", share_if_truth(&Of::coverage_lower)},
       {"held_to", "%", share_if_truth(&Of::coverage_upper)},
       {"unit", [](const Of& one) { return one.unit.text(); }},
       {"sd_predicted", in_unit(predicted)},
       {"sd_stated", in_unit(&Of::stated)},
       {"scatter", in_unit(&Of::scatter)},
       {"scatter/predicted", [&](const Of& one) { return rounded(one.scatter / predicted(one)); }},
       {"bias", [](const Of& one) { return one.truth ? shown_difference(one.unit, one.bias) : std::nan(""); }},
       {"sd_of_bias", in_unit([](const Of& one) { return one.scatter / std::sqrt(double(one.tests)); })}});
}

Table sound_table(const Validation& validation) {
  const Accusations& sound = validation.sound;
  const auto accused = share_interval(sound.warned, sound.tests, normal_two_sided_95);
  return tabulate("sound_tests", "what is said of tests that are carried out as planned", 1,
                  {{"tests", [&](std::size_t) { return sound.tests; }},
                   {"accused", [&](std::size_t) { return sound.warned; }},
                   {"accused_from", "%", [&](std::size_t) { return rounded(accused.lower); }},
                   {"accused_to", "%", [&](std::size_t) { return rounded(accused.upper); }},
                   {"without_result", [&](std::size_t) { return sound.refused; }},
                   {"said", [&](std::size_t) { return fmt::format("{}", fmt::join(sound.codes, " ")); }}});
}

std::vector<DepartureStudy> studies_of(const Validation& validation, bool unnoticed) {
  std::vector<DepartureStudy> all;
  for (const DepartureStudy& one : validation.departures)
    if ((one.exposure == Exposure::unnoticed) == unnoticed) all.push_back(one);
  return all;
}

using StudyColumns = std::vector<ColumnOf<DepartureStudy>>;

ColumnOf<DepartureStudy> size_column(const char* heading, double DepartureStudy::*size) {
  return {heading, [size](const DepartureStudy& one) {
            return one.sized ? shown_difference(one.unit, one.*size) : std::nan("");
          }};
}

StudyColumns study_columns(bool unnoticed) {
  using Of = DepartureStudy;
  StudyColumns columns{{"departure_name", [](const Of& one) { return one.departure->name; }}, {"target", &Of::target}};
  if (!unnoticed)
    columns.push_back(
        {"outcome", [](const Of& one) { return std::string(one.refused ? "no result" : name(one.exposure)); }});
  columns.push_back({"parameter", &Of::parameter});
  if (unnoticed) columns.push_back({"shift", [](const Of& one) { return rounded(one.shift); }});
  columns.push_back({"unit", [](const Of& one) { return one.sized ? one.unit.text() : std::string(); }});
  columns.push_back(size_column("moves_at", &Of::moves));
  columns.push_back(size_column("not_named_at", &Of::greatest));
  columns.push_back(size_column("named_at", &Of::named));
  columns.push_back(size_column("covered", &Of::covered));
  columns.push_back({"said", [](const Of& one) { return fmt::format("{}", fmt::join(one.codes, " ")); }});
  return columns;
}

Table unnoticed_table(const Validation& validation) {
  return tabulate("unnoticed",
                  "what could go wrong in this test without anybody noticing, the worst first: the greatest shift of a "
                  "parameter in "
                  "its sd, the size that moves it by one sd, the greatest size that is not named, and the size that is "
                  "named in nine "
                  "of ten tests",
                  studies_of(validation, true), study_columns(true));
}

Table remedies_table(const Validation& validation) {
  std::vector<const Departure*> departures;
  for (const DepartureStudy& one : studies_of(validation, true))
    if (std::ranges::find(departures, one.departure) == departures.end()) departures.push_back(one.departure);
  return tabulate("what_would_show_it", "what a test needs to show these departures", departures,
                  {{"departure_name", [](const Departure* one) { return one->name; }},
                   {"remedy", [](const Departure* one) { return std::string(remedy_of(one->name)); }}});
}

Table others_table(const Validation& validation) {
  return tabulate(
      "other_departures",
      "departures that are named, or leave no result, before they move a parameter by its sd, and those that move none",
      studies_of(validation, false), study_columns(false));
}

Table not_tried_table(const Validation& validation) {
  return tabulate("not_tried", "departures of which no test can be made", validation.not_tried,
                  {{"departure_name", [](const NotTried& one) { return one.departure->name; }},
                   {"target", &NotTried::target},
                   {"reason", [](const NotTried& one) { return one.why.text(); }}});
}

/// The findings about a parameter whose interval does not hold, whose prediction is not met, or which is biased.
void add_findings_of(const ValidatedParameter& one, Findings& findings) {
  const auto n = static_cast<double>(one.tests);
  // The scatter of few tests may be small by chance: then the stated uncertainty says how well their mean is known.
  const auto [lower, upper] = share_interval(one.held, one.tests, rare_sd);
  if (one.truth && (lower > should_hold || upper < should_hold))
    findings.push_back(
        {Severity::warning, "interval_does_not_hold", {{"held", one.held}, {"tests", one.tests}}, one.name});
  if (one.truth && std::abs(one.bias) > rare_sd * std::max(one.scatter, one.stated) / std::sqrt(n))
    findings.push_back(
        {Severity::warning,
         "biased_in_sound_tests",
         {{"bias", shown_difference(one.unit, one.bias)}, {"unit", one.unit.text()}, {"shift", one.bias / one.stated}},
         one.name});
  const double ratio = one.scatter / one.predicted.value_or(one.scatter);
  if (std::abs(std::log(ratio)) > std::max(std::log(met_within), rare_sd / std::sqrt(2.0 * (n - 1.0))))
    findings.push_back({Severity::warning, "scatter_differs_from_prediction", {{"ratio", ratio}}, one.name});
}

std::string without_truth(const Validation& validation) {
  std::vector<std::string> names;
  for (const ValidatedParameter& one : validation.parameters)
    if (!one.truth) names.push_back(one.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

Findings findings_of(const Validation& validation) {
  Findings findings;
  for (const ValidatedParameter& one : validation.parameters) add_findings_of(one, findings);
  const Accusations& sound = validation.sound;
  if (share_interval(sound.warned, sound.tests, normal_two_sided_95).lower > may_be_accused || sound.refused > 0)
    findings.push_back({Severity::warning,
                        "sound_tests_accused",
                        {{"warned", sound.warned},
                         {"refused", sound.refused},
                         {"tests", sound.tests},
                         {"codes", fmt::format("{}", fmt::join(sound.codes, ", "))}}});
  if (const std::string names = without_truth(validation); !names.empty())
    findings.push_back({Severity::info, "truth_not_in_plan", {{"parameters", names}}});
  if (validation.not_predicted)
    findings.push_back({Severity::info, "uncertainty_not_predicted", {{"reason", *validation.not_predicted}}});
  const auto unnoticed = studies_of(validation, true);
  if (!unnoticed.empty())
    findings.push_back({Severity::info,
                        "departures_unnoticed",
                        {{"unnoticed", unnoticed.size()},
                         {"tried", validation.departures.size()},
                         {"worst", std::string(unnoticed.front().departure->name)}}});
  if (!validation.not_tried.empty())
    findings.push_back({Severity::info, "departures_not_tried", {{"number", validation.not_tried.size()}}});
  return findings;
}

}  // namespace
}  // namespace validation

Estimate report_of(const Validation& validation) {
  using namespace validation;
  Estimate estimate;
  const Plan& plan = validation.plan;
  estimate.method = "validation";
  estimate.title = fmt::format("Validation of {} in {} simulated tests", plan.method, validation.tests);
  estimate.instrument_model = plan.instrument_model;
  estimate.instrument_serial = plan.instrument_serial;
  estimate.provenance = provenance_of(plan);
  estimate.provenance.seed = validation.seed;
  add_unless_empty(estimate.tables, coverage_table(validation));
  estimate.tables.push_back(sound_table(validation));
  add_unless_empty(estimate.tables, unnoticed_table(validation));
  add_unless_empty(estimate.tables, remedies_table(validation));
  add_unless_empty(estimate.tables, others_table(validation));
  add_unless_empty(estimate.tables, not_tried_table(validation));
  estimate.findings = findings_of(validation);
  return estimate;
}

}  // namespace tumble
