#include <algorithm>
#include <cmath>

#include "tumble/reduce/pulses/rounding.hpp"
#include "tumble/reduce/vibration/vibration.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::vibration {

double sinc(double x) { return x == 0.0 ? 1.0 : std::sin(pi * x) / (pi * x); }

Mean mean_of(const Series& series, double pulse) {
  constexpr std::size_t blocks = 16;
  Mean mean;
  double total = 0.0;
  std::vector<double> sum(blocks, 0.0), count(blocks, 0.0);
  for (std::size_t i = 0; i < series.force.size(); ++i) {
    if (std::isnan(series.force[i])) continue;
    const std::size_t b = i * blocks / series.force.size();
    sum[b] += series.force[i];
    ++count[b];
    total += series.force[i];
    ++mean.windows;
  }
  if (mean.windows == 0) return mean;
  const double n = static_cast<double>(mean.windows);
  mean.value = total / n;
  const double time = n * series.window;
  const double rounding = pulses::rounding_variance(pulse, time);
  double squares = 0.0, used = 0.0, rounding_of_blocks = 0.0;
  for (std::size_t b = 0; b < blocks; ++b) {
    if (count[b] == 0.0) continue;
    const double off = sum[b] / count[b] - mean.value;
    squares += count[b] * off * off;
    rounding_of_blocks += count[b] * pulses::rounding_variance(pulse, count[b] * series.window);
    ++used;
  }
  mean.degrees_of_freedom = std::max(1.0, used - 1.0);
  const double white = used > 1.0 ? std::max(0.0, squares - rounding_of_blocks) / (used - 1.0) / n : 0.0;
  mean.variance = white + rounding;
  return mean;
}

AtRest at_rest(const Data& data, const Series& series) {
  std::size_t before = data.series.size(), after = data.series.size();
  for (std::size_t i = 0; i < data.series.size(); ++i) {
    const Series& other = data.series[i];
    if (!other.at_rest() || other.unit != series.unit || other.power_up != series.power_up) continue;
    // A fixture that was turned in between shows another gravity.
    if (std::abs(other.rest - series.rest) > 1e-3 * standard_gravity) continue;
    const auto nearer = [&](std::size_t known) {
      return known == data.series.size() ||
             std::abs(other.middle() - series.middle()) < std::abs(data.series[known].middle() - series.middle());
    };
    std::size_t& side = other.middle() <= series.middle() ? before : after;
    if (nearer(side)) side = i;
  }
  const bool earlier = before < data.series.size(), later = after < data.series.size();
  if (!earlier && !later) return {};
  if (!(earlier && later)) return {{{earlier ? before : after, 1.0}}, false};
  const double a = data.series[before].middle(), b = data.series[after].middle();
  const double w = (series.middle() - a) / (b - a);
  return {{{before, 1.0 - w}, {after, w}}, true};
}

}  // namespace tumble::vibration
