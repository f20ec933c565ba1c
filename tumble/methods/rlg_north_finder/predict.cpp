#include "tumble/methods/rlg_north_finder/predict.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tumble/earth/earth.hpp"
#include "tumble/sim/power_up.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::rlg_north_finder {
namespace {

/// 0 to 2 for a rate or a specific force along x to z.
int axis_of(Input input) {
  const bool rate = input <= Input::rate_z;
  return static_cast<int>(input) - static_cast<int>(rate ? Input::rate_x : Input::specific_force_x);
}

/// Pulses for one SI unit of the indicated quantity over one second: of a long run at a rate of 1.
double pulses_per_unit(const Participant& instrument, std::size_t output) {
  constexpr std::size_t samples = 1000;
  const Recorded recorded = instrument.model.record(instrument.truth, output, 1.0, RandomStream(0));
  std::vector<double> values(samples, 1.0);
  if (recorded.response) recorded.response(values);
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(samples);
}

/// Indication of an output without noise.
double indicated(const Participant& instrument, const Output& output, Vector3 rate, Vector3 force) {
  Felt felt;
  felt.rate = instrument.own_from_first * rate;
  felt.specific_force = instrument.own_from_first * force;
  double value = output.input ? output.input(felt) : 0.0;
  const auto coefficients = coefficients_of(instrument.model, output, instrument.truth);
  for (std::size_t t = 0; t < coefficients.size(); ++t) value += coefficients[t] * output.terms[t].regressor(felt);
  return value;
}

Vector3 axis(int i) { return {i == 0 ? 1.0 : 0.0, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0}; }

linear::Truth truths_of_unit(const Participant& instrument, std::size_t number, Which which) {
  const Output output = instrument.model.outputs(instrument.truth)[number];
  const double pulses = pulses_per_unit(instrument, number);
  const double size = which == gyro ? 0.1 : standard_gravity;
  const auto at = [&](int i, double sign) {
    const Vector3 v = sign * size * axis(i);
    return which == gyro ? indicated(instrument, output, v, {}) : indicated(instrument, output, {}, v);
  };
  const int own = which == accelerometer_y ? 1 : 0;
  linear::Truth truth;
  for (const auto& parameter : wanted()) {
    if (parameter.output != which) continue;
    const int i = parameter.input ? axis_of(*parameter.input) : own;
    truth.coefficients[parameter.name] =
        pulses * (parameter.input ? (at(i, 1.0) - at(i, -1.0)) / (2.0 * size) : 0.5 * (at(own, 1.0) + at(own, -1.0)));
  }
  NoiseModel noise = noise_of(instrument.truth, output.noise_prefix);
  for (double* density : {&noise.quantization_noise, &noise.angle_random_walk, &noise.bias_instability,
                          &noise.rate_random_walk, &noise.rate_ramp, &noise.markov_sd})
    *density *= std::abs(pulses);
  truth.noise = noise;
  truth.turn_on_sd = std::abs(pulses) * instrument.truth.number(output.noise_prefix + "turn_on_repeatability");
  return truth;
}

}  // namespace

std::array<linear::Truth, outputs> truths_of(const Plan& plan) {
  std::array<linear::Truth, outputs> truths;
  Problems problems;
  if (plan.instrument_model.empty()) problems.push_back("a prediction needs [instrument] model = \"...\"");
  if (plan.truth.texts().empty()) problems.push_back("a prediction needs [truth] with the noise that is expected");
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  for (const Which which : {gyro, accelerometer_x, accelerometer_y}) {
    const auto choice = plan.channels.find(role_of(which));
    const std::string channel = choice == plan.channels.end() ? role_of(which) : choice->second.front().channel;
    bool found = false;
    for (const auto& instrument : participants_of(plan)) {
      const auto all = instrument.model.outputs(instrument.truth);
      for (std::size_t k = 0; k < all.size() && !found; ++k) {
        if (instrument.prefix + all[k].channel != channel) continue;
        found = true;
        if (!instrument.model.record ||
            instrument.model.record(instrument.truth, k, 1.0, RandomStream(0)).kind != QuantityKind::count)
          problems.push_back(say("'{}' does not count: let its truth say output = \"count\"", channel));
        else
          truths[which] = truths_of_unit(instrument, k, which);
      }
    }
    if (!found)
      problems.push_back(
          say("no instrument of the plan has the output '{}' that plays {}: name it in "
              "[channels], and put it into [beside.NAME]",
              channel, Name{role_of(which)}));
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return truths;
}

}  // namespace tumble::rlg_north_finder
