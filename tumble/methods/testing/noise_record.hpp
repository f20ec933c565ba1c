#pragma once

#include <utility>
#include <vector>

#include "tumble/methods/method.hpp"

/// For the tests of allan_noise.
namespace tumble {

/// One recording of these channels, with the default settings.
inline Evidence noise_evidence(std::vector<Channel> channels) {
  Evidence evidence;
  evidence.plan.method = "allan_noise";
  evidence.plan.settings = defaults(find_method("allan_noise").options());
  evidence.recordings.emplace_back();
  evidence.recordings.back().channels = std::move(channels);
  return evidence;
}

/// One recording of one gyro, values [rad/s] at `rate` [Hz].
inline Evidence noise_evidence(std::vector<double> values, double rate) {
  return noise_evidence(
      {{"gyro.x", QuantityKind::angular_rate, Unit::parse("deg/h"), {0.0, rate, nullptr}, std::move(values)}});
}

inline Estimate identify_noise(const Evidence& evidence) { return find_method("allan_noise").identify(evidence, {}); }

}  // namespace tumble
