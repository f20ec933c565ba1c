#include "tumble/methods/testing/trials.hpp"

#include <fmt/format.h>

#include <cmath>
#include <span>

#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/accelerometer_four_position/estimator.hpp"
#include "tumble/methods/accelerometer_four_position/testing/trial.hpp"
#include "tumble/models/model.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::accelerometer_four_position {
namespace {

constexpr double plateaus[] = {-20.0, 0.0, 20.0, 40.0, 60.0};  ///< [degC]

void add_schedule(Plan& plan) {
  const auto hold = [](double value) { return Motion{.kind = Motion::Kind::hold, .value = value}; };
  for (int run = 1; run <= 4; ++run)
    for (const double t : plateaus) {
      plan.schedule.push_back({fmt::format("soak at {} degC", t), 4500.0, run, {{"temperature", hold(t + 273.15)}}});
      for (int position = 1; position <= 4; ++position)
        plan.schedule.push_back({fmt::format("{} at {} degC", position, t),
                                 120.0,
                                 run,
                                 {{"head", hold(si(90.0 * (position == 1   ? 1
                                                           : position == 2 ? 0
                                                           : position == 3 ? 3
                                                                           : 2),
                                                   "deg"))}}});
    }
}

/// Results of the closed forms without noise at one temperature.
FourResults exact(const Plan& plan, double celsius, double gravity, bool o_level = false) {
  const Model& model = find_model("pendulous_accelerometer");
  const Output output = model.outputs(plan.truth).front();
  const auto coefficients = coefficients_of(model, output, plan.truth);
  const Vector3 forces[] = {{gravity, 0, 0}, {0, gravity, 0}, {-gravity, 0, 0}, {0, -gravity, 0}};
  FourOutputs y{};
  for (std::size_t k = 0; k < 4; ++k) {
    Felt felt;
    felt.specific_force = forces[k];
    if (o_level) felt.specific_force = {forces[k].x, 0.0, forces[k].y};
    felt.temperature = celsius + 273.15;
    y[k] = output.input(felt);
    for (std::size_t t = 0; t < coefficients.size(); ++t) y[k] += coefficients[t] * output.terms[t].regressor(felt);
  }
  return from_four(y, gravity, o_level ? -1.0 : 1.0);
}

/// The quadratic through the exact results at the temperatures of the test; what they differ from it by is 1e-8 of
/// them.
void add_truth(const Plan& plan, Quantity quantity, const char* letter, std::span<const double> temperatures,
               bool o_level, Trial& trial) {
  Matrix design(temperatures.size(), 3);
  std::vector<double> values;
  for (std::size_t i = 0; i < temperatures.size(); ++i) {
    const double t = temperatures[i];
    design(i, 0) = 1.0;
    design(i, 1) = t;
    design(i, 2) = t * t;
    values.push_back(exact(plan, t, *plan.site->gravity, o_level).value[quantity]);
  }
  const auto fit = least_squares(design, values, {}, {});
  for (std::size_t j = 0; j < 3; ++j) trial.truth.emplace_back(fmt::format("{}_{}", letter, j), fit.parameters[j]);
}

void add_all_truth(const Plan& plan, std::span<const double> temperatures, bool o_level, Trial& trial) {
  add_truth(plan, bias, "b", temperatures, o_level, trial);
  add_truth(plan, scale_factor_error, "c", temperatures, o_level, trial);
  const auto at_20 = exact(plan, 20.0, *plan.site->gravity, o_level);
  trial.truth.emplace_back("bias", at_20.value[bias]);
  trial.truth.emplace_back("scale_factor_error", at_20.value[scale_factor_error]);
  trial.truth.emplace_back("second_order_coefficient", at_20.value[second_order]);
  trial.truth.emplace_back("misalignment", at_20.value[misalignment]);
}

/// Five power-ups from hot to cold, the positions backwards in every second one; the last lacks its last position.
void add_second_schedule(std::span<const double> temperatures, Plan& plan) {
  const auto hold = [](double degrees) { return Motion{.kind = Motion::Kind::hold, .value = si(degrees, "deg")}; };
  const double angles[] = {90.0, 0.0, 270.0, 180.0};
  for (int run = 1; run <= 5; ++run)
    for (const double t : temperatures) {
      plan.schedule.push_back(
          {fmt::format("soak at {} degC", t),
           4500.0,
           run,
           {{"temperature", {.kind = Motion::Kind::hold, .value = t + 273.15}}, {"mount_roll", hold(-90.0)}}});
      for (int k = 0; k < 4; ++k) {
        const int position = run % 2 == 0 ? 3 - k : k;
        plan.schedule.push_back(
            {fmt::format("{} at {}", position + 1, t), 100.0, run, {{"head", hold(angles[position])}}});
      }
    }
  plan.schedule.pop_back();
}

}  // namespace

Trial trial(std::uint64_t seed) {
  const Method& method = find_method("accelerometer_four_position");
  Plan plan = trial_plan(method.name, method.options(), "pendulous_accelerometer", "dividing_head", 0.2);
  plan.site->gravity = 9.797;
  plan.settings.set_word("scale_factor", "2000 pulse/s/g");
  const auto set = [&](const char* name, double value, const char* unit) { set_truth(plan, name, value, unit); };
  plan.truth.set_word("output", "count");
  plan.truth.set_integer("oversampling", 5);
  set("pulse_scale_factor", 2000.0, "pulse/s/g");
  set("bias", 2.5, "mg");
  set("scale_factor_error", 150.0, "ppm");
  set("second_order_coefficient", 25.0, "ug/g^2");
  set("third_order_coefficient", 8.0, "ug/g^3");
  set("misalignment_o", 60.0, "arcsec");
  set("bias_temperature_coefficient", 12.0, "ug/K");
  set("bias_temperature_square", 0.06, "ug/K^2");
  set("scale_factor_temperature_coefficient", -25.0, "ppm/K");
  set("scale_factor_temperature_square", 0.15, "ppm/K^2");
  set("angle_random_walk", 0.005, "(m/s)/sqrt(h)");
  set("bias_instability", 2.0, "ug");
  set("turn_on_repeatability", 15.0, "ug");
  add_schedule(plan);
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  add_all_truth(plan, plateaus, false, trial);
  return trial;
}

Trial second_trial(std::uint64_t seed) {
  const Method& method = find_method("accelerometer_four_position");
  Plan plan = trial_plan(method.name, method.options(), "pendulous_accelerometer", "dividing_head", 0.5);
  plan.site = Site{si(-33.9, "deg"), si(18.4, "deg"), 40.0, 9.7966};
  plan.settings.set_word("scale_factor", "-1.25 mA/g");
  const auto set = [&](const char* name, double value, const char* unit) { set_truth(plan, name, value, unit); };
  plan.truth.set_word("output", "current");
  set("current_scale_factor", -1.25, "mA/g");
  set("bias", -1.2, "mg");
  set("scale_factor_error", -400.0, "ppm");
  set("second_order_coefficient", -40.0, "ug/g^2");
  set("second_order_oo", 6.0, "ug/g^2");
  set("third_order_coefficient", -12.0, "ug/g^3");
  set("misalignment_o", 30.0, "arcsec");
  set("misalignment_p", -90.0, "arcsec");
  set("bias_temperature_coefficient", -9.0, "ug/K");
  set("bias_temperature_square", -0.1, "ug/K^2");
  set("scale_factor_temperature_coefficient", 40.0, "ppm/K");
  set("scale_factor_temperature_square", -0.3, "ppm/K^2");
  set("angle_random_walk", 0.003, "(m/s)/sqrt(h)");
  set("bias_instability", 4.0, "ug");
  set("turn_on_repeatability", 30.0, "ug");
  const double temperatures[] = {50.0, 30.0, 5.0, -15.0};
  add_second_schedule(temperatures, plan);
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  lose_samples(trial.evidence.recordings.front(), seed, 40);
  add_all_truth(plan, temperatures, true, trial);
  return trial;
}

extern const Trials trials{trial, second_trial};

}  // namespace tumble::accelerometer_four_position
