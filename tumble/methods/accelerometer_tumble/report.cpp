#include "tumble/methods/accelerometer_tumble/report.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/earth/earth.hpp"
#include "tumble/reduce/accelerometer/faults.hpp"
#include "tumble/reduce/accelerometer/hidden.hpp"
#include "tumble/reduce/accelerometer/output.hpp"
#include "tumble/rigs/capabilities.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::accelerometer_tumble {
namespace {

using accelerometer::Normalised;
using linear::Solution;

/// [1] of the specific force: an axis that feels more is used, and in a plane of two axes the third feels less than
/// this part of it: 0.06 deg across.
constexpr double felt_share = 0.1, across_share = 1e-3;
/// [1] of a term that is not identified: where more of it is explained by none of the others, its meaning is not
/// stated.
constexpr double most_unexplained = 0.2;
constexpr double opposite_within = 0.02;  ///< [rad] 1 deg: two mounts are opposite

std::vector<std::string> simple_terms() {
  return {"bias", "scale_factor_error", "second_order_coefficient", "misalignment_o", "misalignment_p"};
}

std::vector<std::string> gjb_terms() {
  return {"bias",
          "scale_factor_error",
          "second_order_coefficient",
          "third_order_coefficient",
          "cross_coupling_ip",
          "cross_coupling_io",
          "misalignment_o",
          "misalignment_p"};
}

/// Terms that a field of 1 g hides, completely or nearly.
std::vector<std::string> hidden_terms() {
  return {"second_order_pp", "second_order_oo", "cross_coupling_po", "odd_quadratic_coefficient"};
}

std::vector<std::string> all_names() {
  auto names = gjb_terms();
  for (auto& name : hidden_terms()) names.push_back(std::move(name));
  return names;
}

/// Whether some positions have the pendulum axis and others the output axis in the vertical plane.
bool in_both_mounts(const Solution& solution) {
  bool along_p = false, along_o = false;
  for (const auto& segment : solution.segments) {
    const Vector3 f = segment.felt.specific_force;
    const double used = felt_share * norm(f);
    along_p = along_p || (std::abs(f.y) > used && std::abs(f.z) < across_share * used);
    along_o = along_o || (std::abs(f.z) > used && std::abs(f.y) < across_share * used);
  }
  return along_p && along_o;
}

/// Removes cross-couplings that the positions show only mixed with K_3: aliases, at five positions for example.
void withhold_aliases(const Normalised& fit, Estimate& estimate) {
  for (const char* name : {"cross_coupling_ip", "cross_coupling_io"}) {
    const auto meaning = fit.solution.stands_for.find(name);
    const auto terms = fit.solution.contains.find(name);
    if (meaning == fit.solution.stands_for.end() || terms == fit.solution.contains.end()) continue;
    if (std::ranges::find(terms->second, "third_order_coefficient", &Parameter::Contained::name) == terms->second.end())
      continue;
    accelerometer::withhold(name, estimate);
    estimate.findings.push_back({Finding::Severity::warning,
                                 "coefficient_mixed_with_third_order",
                                 {{"parameter", name}, {"combination", meaning->second}}});
  }
}

/// Findings about the effect of each term outside of the model on the coefficients at these positions.
void add_hidden_terms(const Normalised& fit, Estimate& estimate) {
  using enum Finding::Severity;
  for (const auto& term : accelerometer::terms_of(hidden_terms())) {
    if (std::ranges::find(fit.problem.columns, term.name, &Term::name) != fit.problem.columns.end()) continue;
    const auto shares = accelerometer::shares_of(term, fit.solution);
    const auto meanings = accelerometer::meanings(shares, term);
    if (meanings.empty() && term.name == "cross_coupling_po")
      estimate.findings.push_back({info, "products_across_not_excited", {}});
    if (meanings.empty() || shares.unexplained > most_unexplained) continue;
    if (term.name == "second_order_pp") accelerometer::state_contained(shares, term, fit.scale_factor, estimate);
    estimate.findings.push_back({info,
                                 term.name == "second_order_pp" ? "hinge_hidden_at_one_g" : "term_hidden_at_one_g",
                                 {{"symbol", term.symbol}, {"meanings", meanings}}});
  }
}

/// Whether the positions were taken with the accelerometer turned by 180 deg about its input axis as well.
bool reversed(const Plan& plan) {
  std::vector<double> rolls;
  double roll = 0.0;
  for (const auto& segment : plan.schedule) {
    if (const auto axis = segment.axes.find("mount_roll"); axis != segment.axes.end()) roll = axis->second.value;
    rolls.push_back(std::remainder(roll, two_pi));
  }
  return std::ranges::any_of(rolls, [&](double first) {
    return std::ranges::any_of(rolls, [&](double second) {
      return std::abs(std::abs(std::remainder(first - second, two_pi)) - pi) < opposite_within;
    });
  });
}

void add_zero_of_head(const Plan& plan, Estimate& estimate) {
  const bool some = find_parameter(estimate, "misalignment_o") || find_parameter(estimate, "misalignment_p");
  if (has_one_index_axis(plan) && some && !reversed(plan))
    estimate.findings.push_back({Finding::Severity::info, "zero_of_head_in_misalignment", {}});
}

void warn_of_too_few_positions(const Plan& plan, const Normalised& fit, Estimate& estimate) {
  const std::size_t parameters = fit.solution.columns.size();
  if (fit.solution.segments.size() <= parameters)
    estimate.findings.push_back(
        {Finding::Severity::warning,
         "no_position_to_spare",
         {{"positions", accelerometer::different_positions(plan)}, {"parameters", parameters}}});
}

/// Residuals over the angle of the input axis from the horizontal, a curve for each mount.
void add_residuals(const Solution& solution, Estimate& estimate) {
  Curve along_p{.name = "pendulum axis in the vertical plane",
                .figure = "residuals of the positions",
                .x = {"angle", Unit::parse("deg")},
                .y = {"residual", Unit::parse("ug")},
                .band = "2 sd of the output noise",
                .points = true};
  Curve along_o = along_p;
  along_o.name = "output axis in the vertical plane";
  for (const auto& segment : solution.segments) {
    if (std::isnan(segment.measured)) return;
    const Vector3 f = segment.felt.specific_force;
    const bool second = std::abs(f.z) > std::abs(f.y);
    add_point(second ? along_o : along_p, std::atan2(f.x, second ? f.z : f.y), segment.measured - segment.predicted,
              2.0 * segment.sd);
  }
  for (Curve* curve : {&along_p, &along_o})
    if (!curve->x.values.empty()) estimate.curves.push_back(std::move(*curve));
}

}  // namespace

std::vector<Option> options() {
  auto options = linear::options("2 s", "10 s");
  options.push_back(linear::bias_instability_option("ug"));
  options.push_back(
      accelerometer::scale_factor_option("nominal scale factor, \"2000 pulse/s/g\" for example, with which the result "
                                         "is compared; absent: no comparison"));
  options.push_back(word("terms", {"simple", "gjb", "mounts", "all"})
                        .otherwise("mounts")
                        .says("simple: K_0, K_1, K_2 and misalignments; gjb: all of (4.19); mounts: also K_pp - K_oo "
                              "where positions in both mounts show it; all: also K_pp, K_oo, K_po and K_oq as far as "
                              "the positions show them"));
  return options;
}

linear::Problem problem_of(const Settings& settings) {
  linear::Problem problem;
  linear::set_options(settings, problem);
  problem.input = Input::specific_force_x;
  const auto& word = settings.word("terms");
  problem.columns = accelerometer::terms_of(word == "simple" ? simple_terms()
                                            : word == "all"  ? all_names()
                                                             : gjb_terms());
  problem.leave_out_first = {"odd_quadratic_coefficient",
                             "third_order_coefficient",
                             "second_order_oo",
                             "cross_coupling_po",
                             "second_order_pp",
                             "cross_coupling_io",
                             "cross_coupling_ip",
                             "second_order_coefficient",
                             "misalignment_p",
                             "misalignment_o"};
  return problem;
}

accelerometer::Refine refine_of(const Settings& settings) {
  if (settings.word("terms") != "mounts") return nullptr;
  return [](const Solution& first, linear::Problem& problem) {
    if (!in_both_mounts(first)) return;
    for (auto& term : accelerometer::terms_of({"second_order_pp"})) problem.columns.push_back(std::move(term));
  };
}

Estimate answer_of(const Evidence& evidence, Normalised fit) {
  const bool measured = !evidence.recordings.empty();
  if (measured) accelerometer::refuse_clipped_and_overflown(evidence, fit);
  accelerometer::describe_dropped(fit, "seven_positions_show_all");
  Estimate estimate = linear::answer_of(fit.solution, "g", {"i", "p", "o"});
  withhold_aliases(fit, estimate);
  for (auto& finding : accelerometer::about_labels(evidence.plan)) estimate.findings.push_back(std::move(finding));
  if (measured) accelerometer::add_faults(evidence, fit, estimate);
  warn_of_too_few_positions(evidence.plan, fit, estimate);
  add_hidden_terms(fit, estimate);
  add_zero_of_head(evidence.plan, estimate);
  if (evidence.plan.site) estimate.tables.push_back(accelerometer::in_local_g(estimate, gravity(*evidence.plan.site)));
  add_residuals(fit.solution, estimate);
  auto names = all_names();
  std::erase(names, "scale_factor_error");
  accelerometer::set_model(evidence, fit.solution, names, estimate);
  return estimate;
}

}  // namespace tumble::accelerometer_tumble
