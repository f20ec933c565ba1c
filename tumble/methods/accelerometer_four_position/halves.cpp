#include "tumble/methods/accelerometer_four_position/halves.hpp"

#include <cmath>

#include "tumble/clocks/stamp_slack.hpp"

namespace tumble::accelerometer_four_position {

Halves halves_of(const Channel& channel, std::span<const double> values, const Stretch& stretch) {
  const double begin = stretch.power_on + stretch.first, end = begin + stretch.duration();
  const double slack = stamp_slack(end, stretch.step);
  double sum[2] = {0.0, 0.0}, count[2] = {0.0, 0.0};
  for (std::size_t i = index_at(channel, begin - slack); i < values.size() && channel.time(i) < end - slack; ++i) {
    if (!std::isfinite(values[i])) continue;
    const int half = channel.time(i) < 0.5 * (begin + end) - slack ? 0 : 1;
    sum[half] += values[i];
    count[half] += 1.0;
  }
  const double all = count[0] + count[1];
  return {all > 0.0 ? (sum[0] + sum[1]) / all : std::nan(""),
          count[0] > 0.0 && count[1] > 0.0 ? sum[1] / count[1] - sum[0] / count[0] : 0.0};
}

}  // namespace tumble::accelerometer_four_position
