#include "tumble/checks/support/turns.hpp"

#include <cmath>

#include "tumble/math/extremes.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::support {

std::optional<Channel> without_wraps(const Channel& channel) {
  if (channel.kind != QuantityKind::angle) return std::nullopt;
  const Extremes ends = extremes_of(channel.values);
  constexpr double rounding = 1e-6;  // of a turn, written with few digits
  // one that counts turns goes beyond one, and increments of a gyro stay far below
  if (!(ends.highest - ends.lowest > pi) || ends.highest - ends.lowest > two_pi * (1.0 + rounding)) return std::nullopt;
  Channel out = channel;
  double last = 0.0;
  for (double& value : out.values) {
    if (std::isnan(value)) continue;
    value += two_pi * std::round((last - value) / two_pi);
    last = value;
  }
  return out;
}

}  // namespace tumble::support
