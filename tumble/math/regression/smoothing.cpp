#include "tumble/math/regression/smoothing.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace tumble {
namespace {

/// Of a window in units of itself; [steps] of even readings.
constexpr double least_determinant = 1e-12, same_step = 1e-6;

constexpr double many = 1000.0;  ///< samples in a window, from which on sums over all samples before are faster
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
  if (m.n < 3 || !(std::abs(determinant) > least_determinant * m.n * m.n * m.n)) {
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
    if (std::abs(time[k] - time.front() - step * static_cast<double>(k)) > same_step * step) return false;
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

/// The window around each sample from sums over all samples before: for windows of many samples. The sums begin anew
/// where the window has gone on by its half width, so that x stays within 3 and nothing of them is lost in rounding.
class WindowSums {
 public:
  WindowSums(std::span<const double> time, std::span<const double> signal, double half_width)
      : time_(time), signal_(signal), half_(half_width) {}

  /// False where the window holds fewer than three samples. Sample k in ascending order.
  bool fit(std::size_t k, Smoothed& out) {
    while (begin_ < k && time_[begin_] < time_[k] - half_ - slack) ++begin_;
    end_ = std::max(end_, k);
    while (end_ < time_.size() && time_[end_] <= time_[k] + half_ + slack) ++end_;
    if (sums_.empty() || time_[k] - anchor_ > half_) restart(k);
    while (first_ + sums_.size() <= end_) extend();
    Moments window = difference(sums_[end_ - first_], sums_[begin_ - first_]);
    if (window.n < 3) return false;
    put(about(window, (time_[k] - anchor_) / half_), half_, offset_, k, out);
    return true;
  }

 private:
  void restart(std::size_t k) {
    anchor_ = time_[k];
    offset_ = std::isnan(signal_[k]) ? offset_ : signal_[k];
    first_ = begin_;
    sums_.assign(1, Moments{});
  }

  void extend() {
    const std::size_t j = first_ + sums_.size() - 1;
    Moments next = sums_.back();
    if (!std::isnan(signal_[j])) next.add((time_[j] - anchor_) / half_, signal_[j] - offset_);
    sums_.push_back(next);
  }

  static Moments difference(const Moments& a, const Moments& b) {
    return {a.n - b.n, a.x - b.x, a.xx - b.xx, a.xxx - b.xxx, a.xxxx - b.xxxx, a.y - b.y, a.xy - b.xy, a.xxy - b.xxy};
  }

  /// The moments about d instead of 0.
  static Moments about(const Moments& m, double d) {
    Moments out = m;
    out.x = m.x - d * m.n;
    out.xx = m.xx - d * (2.0 * m.x - d * m.n);
    out.xxx = m.xxx - d * (3.0 * m.xx - d * (3.0 * m.x - d * m.n));
    out.xxxx = m.xxxx - d * (4.0 * m.xxx - d * (6.0 * m.xx - d * (4.0 * m.x - d * m.n)));
    out.xy = m.xy - d * m.y;
    out.xxy = m.xxy - d * (2.0 * m.xy - d * m.y);
    return out;
  }

  static constexpr double slack = 5e-7;
  std::span<const double> time_, signal_;
  double half_, anchor_ = 0.0, offset_ = 0.0;
  std::size_t begin_ = 0, end_ = 0, first_ = 0;
  std::vector<Moments> sums_;  ///< of the samples from first_ up to each, the first of none
};

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
  if (n > 0 && static_cast<double>(n) * std::min(1.0, 2.0 * half_width / (time.back() - time.front())) > many) {
    WindowSums windows(time, signal, half_width);
    for (std::size_t k = 0; k < n; ++k)
      if (!windows.fit(k, out)) fit_around(time, signal, half_width, k, out);
    return out;
  }
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
