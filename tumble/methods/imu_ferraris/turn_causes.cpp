#include "tumble/methods/imu_ferraris/turn_causes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/earth/earth.hpp"
#include "tumble/math/square.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::imu_ferraris {
namespace {

/// [1] of the mean rate of a turn, below which its ends are at rest: a turn by a table has its rate from end to end.
constexpr double rest_of_turn = 0.1;
constexpr double change_sd = 6.0;  ///< [1] chosen: p = 2e-9, so that the degrees of freedom of drift do not matter

/// A cause that adds an error of its own to what each gyro counts in each turn.
Cause of_turned(const char* name) {
  return {name, {}, std::numeric_limits<double>::infinity(), [](std::span<const double> z, Means& disturbed) {
            for (std::size_t t = 0; t < turns; ++t)
              for (std::size_t k = 0; k < 3; ++k) disturbed.turned[t][k] += z[3 * t + k];
          }};
}

/// What the turns may have been where samples are missing.
Cause bridges_of(const Recorded& recorded) {
  Cause cause = of_turned("missing samples of the turns");
  for (std::size_t t = 0; t < turns; ++t)
    for (std::size_t k = 3; k < outputs; ++k) {
      const Section& turn = recorded.section[poses + t];
      cause.sd.push_back(std::sqrt(turn.bridged[k]) / static_cast<double>(turn.parts));
    }
  return cause;
}

/// Bias in the turns beside that of the poses.
Cause bias_in_turns(const Means& means, const std::array<Vector3, turns>& changes) {
  Cause cause = of_turned("bias in the turns");
  for (std::size_t t = 0; t < turns; ++t)
    for (std::size_t k = 0; k < 3; ++k) cause.sd.push_back(means.turn_time[t] * std::abs(changes[t][k]));
  return cause;
}

}  // namespace

std::array<Vector3, turns> bias_changes(const Means& means, const Calibration& c, const Recorded& recorded) {
  std::array<Vector3, turns> changes{};
  const double drift = shown_variance(means, recorded);
  for (std::size_t t = 0; t < turns; ++t) {
    const Section& turn = recorded.section[poses + t];
    const double rate = std::abs(means.turned[t][t]) / means.turn_time[t];
    Vector3 off;
    double ends = 0.0;
    for (const std::size_t e : {0u, 1u}) {
      const auto still = [&](std::size_t k) { return turn.ends[3 + k][e].still; };
      const double along = turn.ends[3 + t][e].mean - c.b_g[t];
      if (!still(0) || !still(1) || !still(2) || std::abs(along) > rest_of_turn * rate) continue;
      ends += 1.0;
      for (std::size_t k = 0; k < 3; ++k) off[k] += turn.ends[3 + k][e].mean - c.b_g[k];
    }
    const Vector3 by_force = c.k_ga * (inverse(response(c.k_a, c.r_a)) * (means.turn_force[t] - c.b_a));
    for (std::size_t k = 0; k < 3 && ends > 0.0; ++k) {
      const double change = off[k] / ends - by_force[k];
      const double noise = recorded.section[2 * t].density[3 + k] / turn.ends[3 + k][0].samples / ends;
      if (std::abs(change) >
          change_sd * std::sqrt(noise + drift * variance(recorded, 2 * t, 3 + k) + square(earth_rate * c.k_g[k])))
        changes[t][k] = change;
    }
  }
  return changes;
}

void add_turn_causes(const Means& means, const Calibration& calibration, const Recorded& recorded,
                     std::vector<Cause>& all) {
  for (Cause& cause :
       std::array{bridges_of(recorded), bias_in_turns(means, bias_changes(means, calibration, recorded))})
    if (*std::ranges::max_element(cause.sd) > 0.0) all.push_back(std::move(cause));
}

}  // namespace tumble::imu_ferraris
