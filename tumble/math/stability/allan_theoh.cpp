#include "tumble/math/stability/allan_theoh.hpp"

#include <cmath>

namespace tumble {
namespace {

constexpr std::size_t most_ratios = 64;

/// Calls body(i) for at most 64 of the i = 0 ... N/30 - 3, evenly; returned: how many.
template <class Body>
double over_range(std::size_t points, const Body& body) {
  const std::size_t count = points / 30 >= 3 ? points / 30 - 2 : 0;  // n + 1
  const std::size_t stride = (count + most_ratios - 1) / most_ratios;
  double used = 0.0;
  for (std::size_t i = 0; i < count; i += stride, ++used) body(i);
  return used;
}

/// Autocovariance of flicker phase noise averaged over t0, but for a parabola (Greenhall and Riley 2003, eq. (8)).
double flicker_phase(std::size_t lag) {
  const auto squared_log = [](long double t) { return t == 0.0L ? 0.0L : t * t * std::log(std::abs(t)); };
  const auto t = static_cast<long double>(lag);
  return static_cast<double>(2.0L * squared_log(t) - squared_log(t - 1.0L) - squared_log(t + 1.0L));
}

}  // namespace

double allan_over_theo1(std::span<const double> x) {
  double sum = 0.0;
  const double used = over_range(x.size(), [&](std::size_t i) {
    sum += difference_variance(x, 9 + 3 * i, 2, 1).value / theo1_variance(x, 12 + 4 * i).value;
  });
  return used > 0.0 && std::isfinite(sum) ? sum / used : 0.0;
}

MeanSquare theoh_variance(std::span<const double> x, double bias, std::size_t m) {
  if (x.empty()) return {};
  if (theoh_shortest_ratio * static_cast<double>(m) <= static_cast<double>(x.size() - 1))
    return difference_variance(x, m, 2, 1);
  if (m % 3 != 0 || !(bias > 0.0)) return {};
  const MeanSquare theo1 = theo1_variance(x, m / 3 * 4);
  return {bias * theo1.value, theo1.count};
}

double expected_allan_over_theo1(int alpha, std::size_t m) {
  const std::size_t half = m / 2, tau = 3 * m / 4;
  const auto covariance = [&](std::size_t lag) { return alpha == 2 ? (lag == 0 ? 1.0 : 0.0) : flicker_phase(lag); };
  double theo1 = 0.0;
  for (std::size_t d = 1; d <= half; ++d)
    theo1 +=
        (4.0 * (covariance(0) - covariance(d) - covariance(m - d)) + 2.0 * (covariance(m) + covariance(m - 2 * d))) /
        static_cast<double>(d);
  const double allan = 6.0 * covariance(0) - 8.0 * covariance(tau) + 2.0 * covariance(2 * tau);
  return allan / 2.0 / (0.75 * theo1);  // of the same m^2: Allan over (3 m/4)^2, Theo1 over 0.75 m^2
}

double theo_ratio_change(int alpha, std::size_t points, std::size_t m) {
  if (alpha <= 0) return 1.0;
  double sum = 0.0;
  const double used = over_range(points, [&](std::size_t i) { sum += expected_allan_over_theo1(alpha, 12 + 4 * i); });
  return used > 0.0 ? expected_allan_over_theo1(alpha, m / 3 * 4) * used / sum : 1.0;
}

}  // namespace tumble
