#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "tumble/models/lock_in.hpp"

namespace tumble::testing {

/// The beat phase (4.24) by classical Runge-Kutta steps of the phase less the known one, for tests and benchmarks:
/// slow, simple, and independent of BeatPhase except for the draws of the turn-arounds.
class BeatReference {
 public:
  /// Given  steps in each half cycle of the dither: 10 000 leave 1e-10 turns a half cycle at x = 400
  BeatReference(const LockIn& lock_in, const Dither& dither, double input_rate, const RandomStream& random, int steps)
      : dither_(dither), random_(random), steps_(steps) {
    coupling_ = 2.0 * std::numbers::pi * lock_in.scale_factor * lock_in.rate;
    input_ = 2.0 * std::numbers::pi * lock_in.scale_factor * input_rate;
    swing_ = lock_in.scale_factor * dither.rate / dither.frequency;
    step_ = 0.5 / dither.frequency / steps;
    for (int j = 0; j <= 2 * steps; ++j) cosine_.push_back(std::cos(0.5 * std::numbers::pi * j / steps));
  }

  /// One half cycle on.
  ///
  /// Returned  psi/(2 pi) less the dither's own phase
  double half_cycle() {
    const double before = turn_around(done_), after = turn_around(done_ + 1);
    const double middle = 0.5 * (before + after), half = 0.5 * (before - after);
    const double begin = input_ * step_ * steps_ * static_cast<double>(done_);
    const auto slope = [&](int j, double slow) {  // j counts half steps
      return -coupling_ * std::sin(begin + input_ * 0.5 * step_ * j + middle + half * cosine_[j] + slow);
    };
    for (int i = 0; i < 2 * steps_; i += 2) {
      const double k1 = slope(i, slow_), k2 = slope(i + 1, slow_ + 0.5 * step_ * k1);
      const double k3 = slope(i + 1, slow_ + 0.5 * step_ * k2), k4 = slope(i + 2, slow_ + step_ * k3);
      slow_ += step_ / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    ++done_;
    return (input_ * step_ * steps_ * static_cast<double>(done_) + slow_) / (2.0 * std::numbers::pi);
  }

 private:
  /// Phase of turn-around k [rad].
  double turn_around(std::uint64_t k) const {
    const double noise = dither_.noise > 0.0 ? dither_.noise * random_.normal(k) : 0.0;
    return (k % 2 == 0 ? -1.0 : 1.0) * swing_ * (1.0 + noise);
  }

  Dither dither_;
  RandomStream random_;
  int steps_;
  double coupling_ = 0.0, input_ = 0.0, swing_ = 0.0, step_ = 0.0, slow_ = 0.0;
  std::uint64_t done_ = 0;
  std::vector<double> cosine_;
};

}  // namespace tumble::testing
