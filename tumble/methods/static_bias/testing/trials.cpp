#include "tumble/methods/testing/trials.hpp"

#include <cmath>
#include <utility>
#include <vector>

#include "tumble/earth/earth.hpp"
#include "tumble/math/noise_model.hpp"
#include "tumble/math/random.hpp"
#include "tumble/methods/static_bias/averages.hpp"
#include "tumble/methods/static_bias/testing/trial.hpp"

namespace tumble::static_bias {

Trial trial(std::uint64_t seed) {
  const double rate = 5.0;
  const std::size_t samples = 6000, runs = 8;
  const NoiseModel noise{.angle_random_walk = si(0.01, "deg/sqrt(h)"),
                         .bias_instability = si(0.2, "deg/h"),
                         .rate_random_walk = si(1.0, "deg/h/sqrt(h)")};
  const double bias = si(2.0, "deg/h"), repeatability = si(1.5, "deg/h");
  Trial trial;
  trial.evidence.plan.method = "static_bias";
  trial.evidence.plan.settings = defaults(find_method("static_bias").options());
  const RandomStream random = RandomStream(seed).split("static_bias");
  for (std::size_t run = 0; run < runs; ++run) {
    const double turn_on = bias + repeatability * random.split("turn_on").normal(run);
    Channel gyro{"gyro", QuantityKind::angular_rate, Unit::parse("deg/h"), {0.0, rate, nullptr}, {}};
    gyro.values.assign(samples, turn_on);
    add_noise(noise, rate, random.split(run), gyro.values);
    trial.evidence.recordings.emplace_back();
    trial.evidence.recordings.back().channels.push_back(std::move(gyro));
  }
  const std::vector<UnitTerm> terms{
      {NoiseTerm::quantization}, {NoiseTerm::white}, {NoiseTerm::flicker}, {NoiseTerm::random_walk}};
  const auto square = [](double x) { return x * x; };
  const auto scatter = expected_scatter(terms,
                                        {0.0, square(noise.angle_random_walk) * rate, square(noise.bias_instability),
                                         square(noise.rate_random_walk) / rate},
                                        samples, static_cast<std::size_t>(10.0 * rate), 10);
  trial.truth = {{"bias", bias},
                 {"bias_sd_10s", std::sqrt(scatter.shorter)},
                 {"bias_sd_100s", std::sqrt(scatter.longer)},
                 {"turn_on_repeatability", repeatability}};
  return trial;
}

Trial second_trial(std::uint64_t seed) {
  const double rate = 20.0, quantum = si(400.0, "ug");
  const std::size_t samples = 8000, runs = 10;
  const NoiseModel noise{.angle_random_walk = si(60.0, "ug") / std::sqrt(rate)};
  const double bias = si(-800.0, "ug"), repeatability = si(10.0, "ug"), converter = si(260.0, "ug");
  Trial trial;
  trial.evidence.plan.method = "static_bias";
  trial.evidence.plan.settings = defaults(find_method("static_bias").options());
  trial.evidence.plan.settings.set_word("axis", "down");
  trial.evidence.plan.site = Site{.latitude = si(-33.9, "deg"), .gravity = 9.79684};
  const RandomStream random = RandomStream(seed).split("static_bias, second");
  // Gravity as measured is known to its standard deviation.
  const double acts =
      gravity(*trial.evidence.plan.site) + gravity_sd(trial.evidence.plan.site) * random.split("gravity").normal(0);
  for (std::size_t run = 0; run < runs; ++run) {
    const RandomStream own = random.split(run);
    const double turn_on = bias + repeatability * random.split("turn_on").normal(run) - acts;
    Channel channel{"accelerometer", QuantityKind::specific_force, Unit::parse("m/s^2"), {3.0, rate, nullptr}, {}};
    channel.values.assign(samples, turn_on);
    add_noise(noise, rate, own, channel.values);
    std::vector<double> dither(samples);
    own.split("converter").normal(0, dither);
    for (std::size_t k = 0; k < samples; ++k) {
      channel.values[k] = quantum * std::round((channel.values[k] + converter * dither[k]) / quantum);
      if (k % 1999 == 500 || (k > 3000 && k < 3400)) channel.values[k] = std::nan("");
    }
    trial.evidence.recordings.emplace_back();
    trial.evidence.recordings.back().channels.push_back(std::move(channel));
  }
  // White within a sample: the noise, the converter's own, and a twelfth of the square of its step.
  const double of_sample = si(60.0, "ug") * si(60.0, "ug") + converter * converter + quantum * quantum / 12.0;
  trial.truth = {{"bias", bias},
                 {"bias_sd_10s", std::sqrt(of_sample / (10.0 * rate))},
                 {"bias_sd_100s", std::sqrt(of_sample / (100.0 * rate))},
                 {"turn_on_repeatability", repeatability}};
  return trial;
}

extern const Trials trials{trial, second_trial};

}  // namespace tumble::static_bias
