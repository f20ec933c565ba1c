#include "tumble/methods/accelerometer_tumble/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/say.hpp"
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

const std::vector<std::string> simple{"bias", "scale_factor_error", "second_order_coefficient", "misalignment_o",
                                      "misalignment_p"};
const std::vector<std::string> gjb{"bias",
                                   "scale_factor_error",
                                   "second_order_coefficient",
                                   "third_order_coefficient",
                                   "cross_coupling_ip",
                                   "cross_coupling_io",
                                   "misalignment_o",
                                   "misalignment_p"};
/// What a field of 1 g hides, wholly or nearly.
const std::vector<std::string> beyond{"second_order_pp", "second_order_oo", "cross_coupling_po",
                                      "odd_quadratic_coefficient"};

Finding note(std::string text) { return {Finding::Severity::info, std::move(text), ""}; }
Finding warning(std::string text) { return {Finding::Severity::warning, std::move(text), ""}; }

/// Whether some positions have the pendulum axis and others the output axis in the vertical plane.
bool in_both_mounts(const Solution& solution) {
  bool along_p = false, along_o = false;
  for (const auto& segment : solution.segments) {
    const Vector3 f = segment.felt.specific_force;
    const double tenth = 0.1 * norm(f);
    along_p = along_p || (std::abs(f.y) > tenth && std::abs(f.z) < 1e-3 * tenth);
    along_o = along_o || (std::abs(f.z) > tenth && std::abs(f.y) < 1e-3 * tenth);
  }
  return along_p && along_o;
}

/// Cross-couplings that are seen only mixed with K_3 are none: an alias of the positions (five of them, for example).
void withhold_aliases(const Normalised& found, Estimate& estimate) {
  for (const char* name : {"cross_coupling_ip", "cross_coupling_io"}) {
    const auto meaning = found.solution.stands_for.find(name);
    if (meaning == found.solution.stands_for.end() || meaning->second.find("K_3") == std::string::npos) continue;
    accelerometer::withhold(name, estimate);
    estimate.findings.push_back(
        warning(fmt::format("{} is not given: these positions show only {}", name, meaning->second)));
  }
}

/// What each term outside the model does to the coefficients at these positions.
void say_what_one_g_hides(const Normalised& found, Estimate& estimate) {
  for (const auto& term : accelerometer::terms_of(beyond)) {
    if (std::ranges::find(found.problem.columns, term.name, &Term::name) != found.problem.columns.end()) continue;
    const auto shares = accelerometer::shares_of(term, found.solution);
    const auto words = accelerometer::said(shares, term);
    if (words.empty() && term.name == "cross_coupling_po")
      estimate.findings.push_back(note("these positions never excite K_po a_p a_o: nothing is said about it"));
    if (words.empty() || shares.left > 0.2) continue;
    std::string text =
        fmt::format("a term {} of the instrument does not show by itself at 1 g: it changes {}", term.symbol, words);
    if (term.name == "second_order_pp")
      text += "; an elastic hinge has K_pp = -K_2, and what is found here is then twice the K_2 that vibration meets";
    estimate.findings.push_back(note(std::move(text)));
  }
}

/// Whether the positions were taken with the accelerometer turned by 180 deg about its input axis as well.
bool reversed(const Plan& plan) {
  std::vector<double> rolls;
  double roll = 0.0;
  for (const auto& segment : plan.schedule) {
    if (const auto found = segment.axes.find("mount_roll"); found != segment.axes.end()) roll = found->second.value;
    rolls.push_back(std::remainder(roll, two_pi));
  }
  return std::ranges::any_of(rolls, [&](double one) {
    return std::ranges::any_of(
        rolls, [&](double other) { return std::abs(std::abs(std::remainder(one - other, two_pi)) - pi) < 0.02; });
  });
}

void say_what_the_head_hides(const Plan& plan, Estimate& estimate) {
  const bool some = find_parameter(estimate, "misalignment_o") || find_parameter(estimate, "misalignment_p");
  if (!has_one_index_axis(plan) || !some || reversed(plan)) return;
  estimate.findings.push_back(
      note("misalignment_o (misalignment_p) holds the zero of the head's angle, + (-) in full: positions with the "
           "accelerometer turned by 180 deg about its input axis (mount_roll) take it out"));
}

void say_what_is_left_over(const Plan& plan, const Normalised& found, Estimate& estimate) {
  const auto different = accelerometer::different_positions(plan);
  const std::size_t parameters = found.solution.columns.size(), segments = found.solution.segments.size();
  if (segments > parameters) return;
  estimate.findings.push_back(warning(fmt::format(
      "{} positions give {} parameters and leave nothing over: what the model lacks and what drifts from position to "
      "position is not in the uncertainties; repeat positions, or take more of them",
      different, parameters)));
}

/// Residuals over the angle of the input axis from the horizontal, a curve for each mount.
void add_residuals(const Solution& solution, Estimate& estimate) {
  Curve curves[2];
  for (const auto& segment : solution.segments) {
    if (std::isnan(segment.measured)) return;
    const Vector3 f = segment.felt.specific_force;
    const bool second = std::abs(f.z) > std::abs(f.y);
    Curve& curve = curves[second ? 1 : 0];
    curve.name = second ? "output axis in the vertical plane" : "pendulum axis in the vertical plane";
    curve.x.values.push_back(std::atan2(f.x, second ? f.z : f.y));
    curve.y.values.push_back(segment.measured - segment.predicted);
    curve.lower.push_back(curve.y.values.back() - 2.0 * segment.sd);
    curve.upper.push_back(curve.y.values.back() + 2.0 * segment.sd);
  }
  for (auto& curve : curves) {
    if (curve.name.empty()) continue;
    curve.figure = "residuals of the positions";
    curve.x.name = "angle";
    curve.x.unit = Unit::parse("deg");
    curve.y.name = "residual";
    curve.y.unit = Unit::parse("ug");
    curve.band = "2 sd of the output noise";
    curve.points = true;
    estimate.curves.push_back(std::move(curve));
  }
}

}  // namespace

std::vector<Option> options() {
  using Type = Option::Type;
  auto options = linear::options("2 s", "10 s");
  options.push_back(linear::bias_instability_option("ug"));
  options.push_back(accelerometer::scale_factor_option(
      "nominal, \"2000 pulse/s/g\" or the like; not needed: what is found is compared with it"));
  options.push_back({"terms",
                     Type::word,
                     "1",
                     "mounts",
                     {"simple", "gjb", "mounts", "all"},
                     "simple: K_0, K_1, K_2 and misalignments; gjb: all of (4.19); mounts: K_pp - K_oo too where "
                     "positions in both mounts show it; all: K_pp, K_oo, K_po and K_oq too as far as they show"});
  return options;
}

std::vector<Term> all_terms() {
  auto names = gjb;
  names.insert(names.end(), beyond.begin(), beyond.end());
  std::erase(names, "scale_factor_error");
  return accelerometer::terms_of(names);
}

linear::Problem problem_of(const Settings& settings) {
  linear::Problem problem;
  linear::set_options(settings, problem);
  problem.input = [](const Felt& felt) { return felt.specific_force.x; };
  const auto& word = settings.word("terms");
  auto names = word == "simple" ? simple : gjb;
  if (word == "all") names.insert(names.end(), beyond.begin(), beyond.end());
  problem.columns = accelerometer::terms_of(names);
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

Estimate answer_of(const Evidence& evidence, Normalised found) {
  const bool measured = !evidence.recordings.empty();
  if (measured) accelerometer::refuse_clipped_and_overflown(evidence, found);
  accelerometer::describe_dropped(found, "seven positions or more, evenly spaced over the turn, show all");
  Estimate estimate = linear::answer_of(found.solution, "accelerometer_tumble", "g", {"i", "p", "o"});
  withhold_aliases(found, estimate);
  const auto add = [&](Findings findings) {
    for (auto& one : findings) estimate.findings.push_back(std::move(one));
  };
  add(accelerometer::about_labels(evidence.plan));
  if (measured) {
    add(accelerometer::about_unsettled(evidence, found));
    add(accelerometer::about_misplaced(found.solution));
    add(accelerometer::about_signs(estimate, evidence.plan.settings, found.output));
  }
  say_what_is_left_over(evidence.plan, found, estimate);
  say_what_one_g_hides(found, estimate);
  say_what_the_head_hides(evidence.plan, estimate);
  if (evidence.plan.site) estimate.tables.push_back(accelerometer::in_local_g(estimate, gravity(*evidence.plan.site)));
  add_residuals(found.solution, estimate);
  return estimate;
}

}  // namespace tumble::accelerometer_tumble
