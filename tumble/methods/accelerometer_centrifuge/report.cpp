#include "tumble/methods/accelerometer_centrifuge/report.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/earth/earth.hpp"
#include "tumble/reduce/accelerometer/faults.hpp"
#include "tumble/reduce/accelerometer/hidden.hpp"
#include "tumble/reduce/accelerometer/output.hpp"
#include "tumble/rigs/capabilities.hpp"
#include "tumble/rigs/error_names.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::accelerometer_centrifuge {
namespace {

using accelerometer::Normalised;
using linear::SegmentSummary;

constexpr double turning = 0.05;  ///< [rad/s] below it the arm stands

double squared(Vector3 v) { return dot(v, v); }

/// Along the input axis, for a radius longer by a metre: w^2 towards the axis of rotation, where the part of the
/// specific force across the rate points.
double of_the_radius(const Felt& felt) {
  const double w2 = squared(felt.rate);
  if (!(w2 > 0.0)) return 0.0;
  const Vector3 across = felt.specific_force - (dot(felt.specific_force, felt.rate) / w2) * felt.rate;
  const double size = norm(across);
  return size > 0.0 ? w2 * across.x / size : 0.0;
}

/// For an effective centre a metre out along the input axis, which turns with the instrument.
double of_the_centre(const Felt& felt) { return -(felt.rate.y * felt.rate.y + felt.rate.z * felt.rate.z); }

/// What is felt so many metres out along the input axis: w x (w x r) more.
Felt felt_at(Felt felt, double centre) {
  const Vector3 w = felt.rate;
  felt.specific_force = felt.specific_force + centre * Vector3{of_the_centre(felt), w.x * w.y, w.x * w.z};
  return felt;
}

constexpr std::array along_p{"cross_coupling_ip", "misalignment_o", "second_order_pp"};
constexpr std::array along_o{"cross_coupling_io", "misalignment_p", "second_order_oo"};

/// Terms of the arm's geometry; the symbols are those of formulas in findings: in metres.
std::vector<Term> geometry(bool centre) {
  std::vector<Term> terms{{"effective_radius", "dR/m", "mm",
                           "from the axis of the arm to the effective centre, at rest",
                           [](const Felt& felt) { return of_the_radius(felt); }}};
  if (centre)
    terms.push_back({"centre_offset", "e/m", "mm", "effective centre along the input axis from the mounting's centre",
                     [](const Felt& felt) { return of_the_centre(felt); }});
  return terms;
}

bool is_level(const SegmentSummary& segment) { return norm(segment.felt.rate) > turning; }

/// Radius [m] of the plans of the arm.
double supposed_radius(const Evidence& evidence) {
  std::vector<const Plan*> plans{&evidence.plan};
  for (const auto& plan : evidence.plans) plans.push_back(plan.get());
  for (const auto& entry : evidence.plan.recordings) plans.push_back(entry.plan.get());
  for (const Plan* plan : plans)
    if (plan && is_fixed_on_arm(*plan)) return plan->rig.number("radius") + plan->rig.number("lever_x");
  throw Error(Error::Kind::bad_input,
              "the plan needs [rig] kind = \"centrifuge\", or a [[recording]] whose plan has it");
}

Table levels(const linear::Solution& solution, double centre) {
  std::vector<SegmentSummary> levels;
  std::ranges::copy_if(solution.segments, std::back_inserter(levels), is_level);
  const auto along = [centre](const SegmentSummary& s) { return felt_at(s.felt, centre).specific_force.x; };
  std::vector<ColumnOf<SegmentSummary>> columns{
      {"label", &SegmentSummary::label},
      {"arm_rate", "deg/s", [](const SegmentSummary& s) { return norm(s.felt.rate); }},
      {"acceleration", "g", [=](const SegmentSummary& s) { return std::abs(along(s)); }},
      {"sense", [=](const SegmentSummary& s) { return along(s) < 0.0 ? "outward" : "inward"; }},
      {"predicted", "g", &SegmentSummary::predicted}};
  if (!std::isnan(solution.segments.front().measured)) {
    columns.emplace_back("measured", "g", &SegmentSummary::measured);
    columns.emplace_back("residual", "g", [](const SegmentSummary& s) { return s.measured - s.predicted; });
  }
  return tabulate("levels", "output at each level of the arm (means over the samples used)", levels, columns);
}

/// Curves of the output minus the specific force, measured and by the model.
void add_departures(const linear::Solution& solution, double centre, Estimate& estimate) {
  std::vector<const SegmentSummary*> sorted;
  for (const auto& segment : solution.segments) sorted.push_back(&segment);
  std::ranges::sort(sorted, {}, [](const auto* s) { return s->felt.specific_force.x; });
  Curve line{.name = "model",
             .figure = "departure from the specific force",
             .x = {"a_i", Unit::parse("g")},
             .y = {"E/K_1 - a_i", Unit::parse("mg")}};
  Curve points = line;
  points.name = "measured";
  points.points = true;
  for (const auto* s : sorted) {
    const double a = felt_at(s->felt, centre).specific_force.x;
    add_point(line, a, s->predicted - a);
    if (!std::isnan(s->measured)) add_point(points, a, s->measured - a);
  }
  if (!points.x.values.empty()) estimate.curves.push_back(std::move(points));
  estimate.curves.push_back(std::move(line));
}

void add_stretch(Estimate& estimate) {
  const Parameter* odd = find_parameter(estimate, "odd_quadratic_coefficient");
  if (!odd) return;
  const auto j = static_cast<std::size_t>(odd - estimate.parameters.data());
  for (const auto& line : estimate.budget)
    if (line.source == error_names::stretch_of_radius)
      estimate.findings.push_back(
          {Finding::Severity::info, "stretch_like_odd_quadratic", {{"share", std::sqrt(line.variance(j)), odd->unit}}});
}

/// Findings about the terms across the input axis where the specific force across it is constant.
void add_terms_across(const Normalised& fit, Estimate& estimate) {
  for (const auto& names : {along_p, along_o})
    for (const auto& term : accelerometer::terms_of({names.begin(), names.end()})) {
      if (std::ranges::find(fit.problem.columns, term.name, &Term::name) != fit.problem.columns.end()) continue;
      const auto meanings = accelerometer::meanings(accelerometer::shares_of(term, fit.solution), term);
      if (!meanings.empty())
        estimate.findings.push_back({Finding::Severity::info,
                                     "gravity_across_at_all_levels",
                                     {{"symbol", term.symbol}, {"meanings", meanings}}});
    }
}

void look_at_levels(const Normalised& fit, const Settings& settings, Estimate& estimate) {
  using enum Finding::Severity;
  bool inward = false, outward = false;
  for (const auto& segment : fit.solution.segments) {
    inward = inward || (is_level(segment) && segment.felt.specific_force.x > 0.0);
    outward = outward || (is_level(segment) && segment.felt.specific_force.x < 0.0);
  }
  if (!inward && !outward)
    throw Error(Error::Kind::bad_data, "no segment turns the arm: the specific force is gravity alone");
  if (inward != outward)
    estimate.findings.push_back(
        {warning, "one_sense_of_the_arm", {{"direction", Phrase{inward ? "inwards" : "outwards"}}}});
  if (!find_parameter(estimate, "effective_radius") && !scale_factor_is_known(settings))
    estimate.findings.push_back({info, "radius_in_scale_factor", {}});
}

}  // namespace

std::vector<Option> options() {
  auto options = linear::options("5 s", "10 s");
  options.push_back(linear::bias_instability_option("ug"));
  options.push_back(accelerometer::scale_factor_option(
      "nominal scale factor; not needed where a tumble is part of the evidence; with scale_factor_sd it is taken as "
      "known"));
  options.push_back(
      quantity("scale_factor_sd", "ppm").at_least(0).says("relative standard uncertainty of scale_factor"));
  options.push_back(flag("centre_offset")
                        .otherwise("true")
                        .says("the effective centre may lie off the centre of the mounting along the input axis, so "
                              "that the two senses have different radii"));
  return options;
}

bool scale_factor_is_known(const Settings& settings) { return settings.has("scale_factor_sd"); }

namespace {

/// The radius belongs to the arm, not to the instrument.
std::vector<std::string> terms_of_the_instrument() {
  return {"bias",
          "second_order_coefficient",
          "third_order_coefficient",
          "odd_quadratic_coefficient",
          "cross_coupling_ip",
          "cross_coupling_io",
          "misalignment_o",
          "misalignment_p",
          "second_order_pp",
          "second_order_oo"};
}

}  // namespace

linear::Problem problem_of(const Settings& settings, double centre) {
  linear::Problem problem;
  linear::set_options(settings, problem);
  problem.role = "accelerometer";
  problem.input = [centre](const Felt& felt) { return felt_at(felt, centre).specific_force.x; };
  problem.even_averages = true;  // the arm turns many times in a sample
  std::vector<std::string> names = terms_of_the_instrument();
  if (!scale_factor_is_known(settings)) names.insert(names.begin() + 1, "scale_factor_error");
  problem.columns = accelerometer::terms_of(names);
  for (auto& term : geometry(settings.flag("centre_offset"))) problem.columns.push_back(std::move(term));
  if (centre != 0.0)
    for (Term& term : problem.columns)
      term.regressor = [centre, at = std::move(term.regressor)](const Felt& felt) { return at(felt_at(felt, centre)); };
  problem.leave_out_first = {"second_order_oo",        "second_order_pp",   "misalignment_p",
                             "misalignment_o",         "cross_coupling_io", "cross_coupling_ip",
                             "centre_offset",          "effective_radius",  "odd_quadratic_coefficient",
                             "third_order_coefficient"};
  return problem;
}

void remove_constant_terms(const linear::Solution& first, linear::Problem& problem) {
  Vector3 low{1e300, 1e300, 1e300}, high = -1.0 * low;
  for (const auto& segment : first.segments) {
    const Vector3 f = segment.felt.specific_force;
    low = {std::min(low.x, f.x), std::min(low.y, f.y), std::min(low.z, f.z)};
    high = {std::max(high.x, f.x), std::max(high.y, f.y), std::max(high.z, f.z)};
  }
  const auto remove = [&](const auto& names) {
    std::erase_if(problem.columns,
                  [&](const Term& term) { return std::ranges::find(names, term.name) != names.end(); });
  };
  constexpr double least_range = 0.05;  // [g] of a component across, with which its terms are distinguished
  const double enough = least_range * standard_gravity;
  if (high.y - low.y < enough) remove(along_p);
  if (high.z - low.z < enough) remove(along_o);
}

Plan with_radius_to_find(Plan plan, double longer) {
  if (!is_fixed_on_arm(plan)) return plan;
  plan.rig.set_number("radius", plan.rig.number("radius") + longer, Unit::parse("m"));
  plan.rig.set_number("radius_sd", 0.0, Unit::parse("um"));
  plan.rig.set_number("lever_sd", 0.0, Unit::parse("mm"));
  return plan;
}

Estimate answer_of(const Evidence& evidence, Normalised fit, double centre) {
  const bool measured = !evidence.recordings.empty();
  const double radius = supposed_radius(evidence);
  if (measured) accelerometer::refuse_clipped_and_overflown(evidence, fit);
  accelerometer::describe_dropped(fit, "both_senses_and_a_tumble_show_more");
  Estimate estimate = linear::answer_of(fit.solution, "g", {"i", "p", "o"});
  for (auto& parameter : estimate.parameters) {
    if (parameter.name == "centre_offset") {
      parameter.symbol = "e";
      parameter.value += centre;
    }
    if (parameter.name != "effective_radius") continue;
    parameter.symbol = "R";
    parameter.value += radius;
  }
  look_at_levels(fit, evidence.plan.settings, estimate);
  if (measured) accelerometer::add_faults(evidence, fit, estimate);
  add_terms_across(fit, estimate);
  add_stretch(estimate);
  estimate.tables.insert(estimate.tables.begin(), levels(fit.solution, centre));
  add_departures(fit.solution, centre, estimate);
  accelerometer::set_model(evidence, fit.solution, terms_of_the_instrument(), estimate);
  return estimate;
}

}  // namespace tumble::accelerometer_centrifuge
