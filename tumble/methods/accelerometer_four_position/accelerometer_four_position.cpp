#include "tumble/methods/accelerometer_four_position/report.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/units/error.hpp"

// Symbols of the source: N_ij pulses in position j, H counting window, G gravity, K_m reference scale factor, nabla
// bias.

namespace tumble::accelerometer_four_position {
namespace {

std::vector<Role> roles() {
  auto roles = accelerometer::roles();
  roles.push_back({"temperature", "degC", false, "temperature of the accelerometer; absent: that of the schedule"});
  return roles;
}

std::vector<Option> options() {
  return {
      accelerometer::scale_factor_option(
          "reference scale factor K_m of a current, voltage or pulses: \"2000 pulse/s/g\""),
      word("estimator", {"four_positions", "up_and_down"})
          .otherwise("four_positions")
          .says("four_positions: bias from positions 2 and 4; up_and_down: bias and scale factor from positions 1 "
                "and 3, as in the source"),
      word("order", {"auto", "0", "1", "2"})
          .otherwise("auto")
          .says("highest power of T in (3.6); auto: 2 if the temperatures allow it"),
      quantity("settling", "s")
          .at_least(0)
          .otherwise("2 s")
          .says("time after the rig has settled that is skipped in each segment"),
      quantity("averaging", "s")
          .above(0)
          .otherwise("10 s")
          .says("length of the averages whose scatter gives the noise: at least one window, at most a quarter of a "
                "position"),
      quantity("same_temperature", "K").above(0).otherwise("2 K").says("temperatures closer than this count as one"),
      quantity("thermometer_sd", "K")
          .between(0, 100)
          .otherwise("0 K")
          .says("standard uncertainty of the temperature, common to the test, in addition to that of the rig"),
      quantity("self_heating", "K")
          .between(0, 100)
          .otherwise("0 K")
          .says("by how much the thermometer in the unit is warmer than the set points, since the unit heats itself"),
      quantity("report_temperature", "degC")
          .otherwise("20 degC")
          .says("temperature of bias and scale_factor_error in the result; the nearest temperature of the test if it "
                "lies outside")};
}

Estimate reduced(const Bench& bench, const Settings& settings, const Expected* expected) {
  const auto result = reduce(bench, order_of(settings, bench), settings.word("estimator") == "up_and_down",
                             settings.number("thermometer_sd"), expected);
  return described(bench, result, settings, expected == nullptr);
}

Estimate identify(const Evidence& evidence, const Progress&) {
  const Bench bench = bench_of(evidence, "accelerometer");
  Estimate estimate = reduced(bench, evidence.plan.settings, nullptr);
  estimate.models = {model_of(bench, evidence, estimate)};
  return estimate;
}

/// Sets the output that the model of [truth] gives in each position.
void set_outputs(const Plan& plan, Bench& bench) {
  const Model& model = find_model(plan.instrument_model);
  const Output output = model.outputs(plan.truth).front();
  const auto coefficients = coefficients_of(model, output, plan.truth);
  for (auto& position : bench.positions) {
    Felt felt = bench.rows.segments[position.stretch].felt;
    felt.temperature = position.temperature;
    position.output = output.input(felt);
    for (std::size_t t = 0; t < coefficients.size(); ++t)
      position.output += coefficients[t] * output.terms[t].regressor(felt);
  }
}

Estimate predict(const Plan& plan) {
  const auto truth = linear::truth_of(plan, "accelerometer");
  if (plan.instrument_model != "pendulous_accelerometer")
    throw Error(Error::Kind::bad_input, "a prediction needs [instrument] model = \"pendulous_accelerometer\"");
  Bench bench = bench_of(plan);
  bench.white = truth.noise.angle_random_walk * truth.noise.angle_random_walk;
  set_outputs(plan, bench);
  const Expected expected{truth.noise, truth.turn_on_sd};
  return reduced(bench, plan.settings, &expected);
}

}  // namespace

extern const Method accelerometer_four_position{
    .name = "accelerometer_four_position",
    .summary = "bias, scale factor and their temperature models of an accelerometer, from four positions in gravity",
    .source =
        "Lu Hanjie, Liu Yabin, Zhou Qiang, dynamic test of linear accelerometers based on INS pulse counting, 2019, "
        "eq. (4)-(8)",
    .needs_plan = true,
    .roles = roles,
    .options = options,
    .identify = identify,
    .compensates = true,
    .predict = predict,
    .takes_prior = true};

}  // namespace tumble::accelerometer_four_position
