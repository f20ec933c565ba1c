#include "tumble/methods/testing/trials.hpp"

#include <utility>

#include "tumble/math/random.hpp"
#include "tumble/reduce/linear/testing/table_trial.hpp"
#include "tumble/reduce/sdof_gyro_support/testing/positions.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::sdof_gyro_dynamic {
namespace {

constexpr std::pair<const char*, double> coefficients[] = {
    {"K_I", 1e-6},     {"K_O", -1.06e-3}, {"K_S", 2e-6},   {"K_IO", -2e-6},    {"K_OS", 1e-6},
    {"K_IS", -1.6e-3}, {"K_II", 3e-6},    {"K_SS", -3e-6}, {"K_III", -1.3e-6}, {"K_ISS", 2.6e-6}};

/// Positions, rates about one and two axes, and oscillations on a two-axis table; the loop known to one per cent.
Trial trial(std::uint64_t seed) {
  Plan plan = sdof_gyro_support::trial_plan("sdof_gyro_dynamic", find_method("sdof_gyro_dynamic").options(),
                                            "two_axis_table", 20.0);
  for (const auto& [name, value] : coefficients) plan.truth.set_number(name, value, Unit());
  plan.truth.set_number("natural_frequency", 92.0, Unit::parse("Hz"));
  plan.truth.set_number("damping_ratio", 0.7, Unit());
  plan.truth.set_integer("oversampling", 8);  // the simulated loop is solved for parabolas through three steps
  linear::add_table_motions(plan);
  const double lag_error = 0.01 * RandomStream(seed).split("loop").normal(0);
  plan.settings.set_number("natural_frequency", 92.0 * (1.0 + lag_error), Unit::parse("Hz"));
  plan.settings.set_number("damping_ratio", 0.7, Unit());
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  for (const auto& [name, value] : coefficients) trial.truth.emplace_back(name, plan.truth.number(name));
  return trial;
}

/// Coefficients of the other sign, a slower loop with less damping, other speeds and oscillations on a table whose axis
/// is tilted, at another site; a current, with samples missing.
Trial second_trial(std::uint64_t seed) {
  Plan plan = sdof_gyro_support::trial_plan("sdof_gyro_dynamic", find_method("sdof_gyro_dynamic").options(),
                                            "two_axis_table", 25.0);
  plan.site = Site{si(-33.9, "deg"), si(18.4, "deg"), 1700.0, {}};
  plan.rig.set_number("outer_azimuth", si(37.0, "deg"), Unit::parse("deg"));
  plan.rig.set_number("outer_elevation", si(20.0, "deg"), Unit::parse("deg"));
  for (const auto& [name, value] : coefficients) plan.truth.set_number(name, -1.5 * value, Unit());
  plan.truth.set_number("natural_frequency", 55.0, Unit::parse("Hz"));
  plan.truth.set_number("damping_ratio", 0.5, Unit());
  plan.truth.set_integer("oversampling", 8);
  set_truth(plan, "scale_factor_error", -60.0, "ppm");
  set_truth(plan, "misalignment_O", 50.0, "arcsec");
  set_truth(plan, "misalignment_S", -40.0, "arcsec");
  set_truth(plan, "angle_random_walk", 0.005, "deg/sqrt(h)");
  linear::add_table_motions(plan, 40.0, 12.0, 0.7);
  const double lag_error = 0.01 * RandomStream(seed).split("loop").normal(0);
  plan.settings.set_number("natural_frequency", 55.0 * (1.0 + lag_error), Unit::parse("Hz"));
  plan.settings.set_number("damping_ratio", 0.5, Unit());
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  lose_samples(trial.evidence.recordings.front(), seed, 50);
  for (const auto& [name, value] : coefficients) trial.truth.emplace_back(name, plan.truth.number(name));
  return trial;
}

}  // namespace

extern const Trials trials{trial, second_trial};

}  // namespace tumble::sdof_gyro_dynamic
