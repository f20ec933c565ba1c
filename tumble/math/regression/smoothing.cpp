#include "tumble/math/regression/smoothing.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace tumble {
namespace {

constexpr double missing = std::numeric_limits<double>::quiet_NaN();

/// Quadratic a + b x + c x^2 from sums over the window, by Cramer's rule: x lies in [-1, 1].
struct Moments {
  double n = 0, x = 0, xx = 0, xxx = 0, xxxx = 0, y = 0, xy = 0, xxy = 0;

  void add(double at, double value) {
    n += 1;
    x += at;
    xx += at * at;
    xxx += at * at * at;
    xxxx += at * at * at * at;
    y += value;
    xy += at * value;
    xxy += at * at * value;
  }
};

void put(const Moments& m, double scale, double offset, std::size_t k, Smoothed& out) {
  const double d0 = m.xx * m.xxxx - m.xxx * m.xxx, d1 = m.x * m.xxxx - m.xxx * m.xx, d2 = m.x * m.xxx - m.xx * m.xx;
  const double determinant = m.n * d0 - m.x * d1 + m.xx * d2;
  if (m.n < 3 || !(std::abs(determinant) > 1e-12 * m.n * m.n * m.n)) {
    out.value[k] = out.slope[k] = out.curvature[k] = missing;
    return;
  }
  const double a = (m.y * d0 - m.x * (m.xy * m.xxxx - m.xxx * m.xxy) + m.xx * (m.xy * m.xxx - m.xx * m.xxy));
  const double b = (m.n * (m.xy * m.xxxx - m.xxx * m.xxy) - m.y * d1 + m.xx * (m.x * m.xxy - m.xy * m.xx));
  const double c = (m.n * (m.xx * m.xxy - m.xy * m.xxx) - m.x * (m.x * m.xxy - m.xy * m.xx) + m.y * d2);
  out.value[k] = offset + a / determinant;
  out.slope[k] = b / determinant / scale;
  out.curvature[k] = 2.0 * c / determinant / (scale * scale);
}

bool evenly_spaced(std::span<const double> time) {
  if (time.size() < 3) return false;
  const double step = (time.back() - time.front()) / static_cast<double>(time.size() - 1);
  for (std::size_t k = 0; k < time.size(); ++k)
    if (std::abs(time[k] - time.front() - step * static_cast<double>(k)) > 1e-6 * step) return false;
  return true;
}

/// The window around sample k, whatever is in it; widened where it holds fewer than three samples.
void fit_around(std::span<const double> time, std::span<const double> signal, double half_width, std::size_t k,
                Smoothed& out) {
  // Half a microsecond of slack so that rounding of the stamps does not decide who is inside.
  auto begin = static_cast<std::size_t>(std::ranges::lower_bound(time, time[k] - half_width - 5e-7) - time.begin());
  auto end = static_cast<std::size_t>(std::ranges::upper_bound(time, time[k] + half_width + 5e-7) - time.begin());
  const auto there = [&](std::size_t j) { return !std::isnan(signal[j]); };
  std::size_t count = 0;
  for (std::size_t j = begin; j < end; ++j) count += there(j);
  // At the ends of a coarse grid the third sample may lie just outside; across a gap nothing is made up.
  const double reach = 2.0 * half_width + 5e-7;
  while (count < 3 && end < time.size() && time[end] - time[k] <= reach) count += there(end++);
  while (count < 3 && begin > 0 && time[k] - time[begin - 1] <= reach) count += there(--begin);
  const double offset = there(k) ? signal[k] : 0.0;
  Moments moments;
  for (std::size_t j = begin; j < end; ++j)
    if (there(j)) moments.add((time[j] - time[k]) / half_width, signal[j] - offset);
  put(moments, half_width, offset, k, out);
}

/// Samples first to last (exclusive) of an even grid whose windows are whole: sums tap by tap, so that the inner loop
/// runs over neighbouring samples.
void fit_even(std::span<const double> signal, double step, std::size_t half, std::size_t first, std::size_t last,
              Smoothed& out) {
  constexpr std::size_t block = 1024;
  double sums[3][block];
  const double width = static_cast<double>(half) * step;
  Moments shape;
  for (std::size_t j = 0; j <= 2 * half; ++j)
    shape.add((static_cast<double>(j) - static_cast<double>(half)) / static_cast<double>(half), 0.0);
  for (std::size_t at = first; at < last; at += block) {
    const std::size_t size = std::min(block, last - at);
    const double offset = signal[at];
    for (auto& sum : sums) std::fill_n(sum, size, 0.0);
    for (std::size_t j = 0; j <= 2 * half; ++j) {
      const double x = (static_cast<double>(j) - static_cast<double>(half)) / static_cast<double>(half), xx = x * x;
      const double* y = signal.data() + at - half + j;
      for (std::size_t i = 0; i < size; ++i) {
        const double value = y[i] - offset;
        sums[0][i] += value;
        sums[1][i] += x * value;
        sums[2][i] += xx * value;
      }
    }
    for (std::size_t i = 0; i < size; ++i) {
      Moments moments = shape;
      moments.y = sums[0][i];
      moments.xy = sums[1][i];
      moments.xxy = sums[2][i];
      put(moments, width, offset, at + i, out);
    }
  }
}

}  // namespace

Smoothed local_quadratic(std::span<const double> time, std::span<const double> signal, double half_width) {
  const std::size_t n = signal.size();
  Smoothed out{std::vector<double>(n), std::vector<double>(n), std::vector<double>(n)};
  const bool even = evenly_spaced(time) && std::ranges::none_of(signal, [](double v) { return std::isnan(v); });
  std::size_t first = n, last = n;
  if (even) {
    const double step = (time.back() - time.front()) / static_cast<double>(n - 1);
    const auto half = static_cast<std::size_t>((half_width + 5e-7) / step);
    if (half >= 1 && n > 2 * half) {
      first = half;
      last = n - half;
      fit_even(signal, step, half, first, last, out);
    }
  }
  for (std::size_t k = 0; k < first; ++k) fit_around(time, signal, half_width, k, out);
  for (std::size_t k = last; k < n; ++k) fit_around(time, signal, half_width, k, out);
  return out;
}

}  // namespace tumble
