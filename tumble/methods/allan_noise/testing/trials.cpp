#include "tumble/methods/testing/trials.hpp"

#include <cmath>

#include "tumble/math/noise_model.hpp"
#include "tumble/math/random.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::allan_noise {
namespace {

/// A gyro whose record shows angle random walk, bias instability and rate random walk clearly.
Trial trial(std::uint64_t seed) {
  const double rate = 10.0;
  const NoiseModel truth{.angle_random_walk = si(0.1, "deg/sqrt(h)"),
                         .bias_instability = si(4.75, "deg/h"),
                         .rate_random_walk = si(72.0, "deg/h/sqrt(h)")};
  Channel gyro{"gyro.x", QuantityKind::angular_rate, Unit::parse("deg/h"), {0.0, rate, nullptr}, {}};
  gyro.values.assign(40000, si(3.0, "deg/h"));
  add_noise(truth, rate, RandomStream(seed).split("allan_noise"), gyro.values);
  Trial trial;
  trial.evidence.plan.method = "allan_noise";
  trial.evidence.plan.settings = defaults(find_method("allan_noise").options());
  Recording recording;
  recording.channels.push_back(std::move(gyro));
  trial.evidence.recordings.push_back(std::move(recording));
  trial.truth = {{"gyro.x.angle_random_walk", truth.angle_random_walk},
                 {"gyro.x.bias_instability", truth.bias_instability},
                 {"gyro.x.rate_random_walk", truth.rate_random_walk}};
  return trial;
}

/// An accelerometer on end with a low pass of its own, other terms, a large offset and a piece that was lost.
Trial second_trial(std::uint64_t seed) {
  const double rate = 50.0, bandwidth = 8.0;
  const double white = si(0.03, "(m/s)/sqrt(h)"), time = 1.0 / (two_pi * bandwidth);
  const NoiseModel filtered{.markov_sd = white / std::sqrt(2.0 * time), .markov_time = time};
  const NoiseModel slow{.rate_random_walk = si(3000.0, "ug/sqrt(h)")};
  Channel accelerometer{"accelerometer.z", QuantityKind::specific_force, Unit::parse("ug"), {0.0, rate, nullptr}, {}};
  accelerometer.values.assign(30000, -standard_gravity);
  const RandomStream random = RandomStream(seed).split("allan_noise");
  add_noise(filtered, rate, random.split("filtered"), accelerometer.values);
  add_noise(slow, rate, random.split("slow"), accelerometer.values);
  for (std::size_t i = 11000; i < 11700; ++i) accelerometer.values[i] = std::nan("");
  Trial trial;
  trial.evidence.plan.method = "allan_noise";
  trial.evidence.plan.settings = defaults(find_method("allan_noise").options());
  trial.evidence.recordings.emplace_back();
  trial.evidence.recordings.back().channels.push_back(std::move(accelerometer));
  trial.truth = {{"accelerometer.z.velocity_random_walk", white},
                 {"accelerometer.z.bandwidth", bandwidth},
                 {"accelerometer.z.acceleration_random_walk", slow.rate_random_walk}};
  return trial;
}

}  // namespace

extern const Trials trials{trial, second_trial};

}  // namespace tumble::allan_noise
