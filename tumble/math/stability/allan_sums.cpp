#include "tumble/math/stability/allan_sums.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <vector>

#include "tumble/math/parallel.hpp"

namespace tumble {

MeanSquare difference_variance(std::span<const double> x, std::size_t m, int order, std::size_t stride) {
  const std::size_t reach = static_cast<std::size_t>(order) * m;
  if (x.size() <= reach) return {};
  const std::size_t count = (x.size() - reach - 1) / stride + 1;
  double sum = 0.0;
  for (std::size_t k = 0; k < count; ++k) {
    const double* const p = x.data() + k * stride;
    const double z2 = (p[2 * m] - p[m]) - (p[m] - p[0]);
    const double z = order == 2 ? z2 : (p[3 * m] - p[2 * m]) - (p[2 * m] - p[m]) - z2;
    sum += z * z;
  }
  const double tau = static_cast<double>(m);
  return {sum / ((order == 2 ? 2.0 : 6.0) * tau * tau * static_cast<double>(count)), count};
}

MeanSquare modified_allan_variance(std::span<const double> x, std::size_t m) {
  if (x.size() < 3 * m) return {};
  const std::size_t count = x.size() - 3 * m + 1;
  double z = 0.0;
  for (std::size_t i = 0; i < m; ++i) z += (x[i + 2 * m] - x[i + m]) - (x[i + m] - x[i]);
  double sum = z * z;
  for (std::size_t n = 0; n + 1 < count; ++n) {
    z += (x[n + 3 * m] - x[n]) - 3.0 * (x[n + 2 * m] - x[n + m]);
    sum += z * z;
  }
  const double tau = static_cast<double>(m);
  return {sum / (2.0 * tau * tau * tau * tau * static_cast<double>(count)), count};
}

MeanSquare parabolic_variance(std::span<const double> x, std::size_t m) {
  if (m == 1) return difference_variance(x, 1, 2, 1);  // a line through one point has no slope
  if (x.size() <= 2 * m) return {};
  // The sum over k moves along with i by its two ends and by the plain sum of the differences. Rounding of what is
  // added up twice grows fast, hence a fresh start at every block.
  const std::size_t count = x.size() - 2 * m, block = std::max<std::size_t>(256, m);
  std::vector<double> partial((count + block - 1) / block, 0.0);
  const double middle = 0.5 * static_cast<double>(m - 1);
  parallel_for(partial.size(), [&](std::size_t task) {
    const std::size_t first = task * block, last = std::min(count, first + block);
    double plain = 0.0, weighted = 0.0;
    for (std::size_t k = 0; k < m; ++k) {
      const double difference = x[first + k] - x[first + m + k];
      plain += difference;
      weighted += (middle - static_cast<double>(k)) * difference;
    }
    for (std::size_t i = first; i < last; ++i) {
      partial[task] += weighted * weighted;
      const double leaves = x[i] - x[i + m], enters = x[i + m] - x[std::min(i + 2 * m, x.size() - 1)];
      plain += enters - leaves;
      weighted += plain - middle * leaves - (middle + 1.0) * enters;
    }
  });
  double sum = 0.0;
  for (const double part : partial) sum += part;
  const double tau = static_cast<double>(m);
  return {72.0 * sum / (tau * tau * tau * tau * tau * tau * static_cast<double>(count)), count};
}

MeanSquare total_variance(std::span<const double> x, std::size_t m) {
  const std::size_t size = x.size();
  if (size < 3 || m > size - 1) return {};
  // The record with m - 1 more points at both ends.
  std::vector<double> extended(size + 2 * (m - 1));
  std::copy(x.begin(), x.end(), extended.begin() + static_cast<std::ptrdiff_t>(m - 1));
  for (std::size_t k = 1; k < m; ++k) {
    extended[m - 1 - k] = 2.0 * x[0] - x[k];
    extended[m - 1 + size - 1 + k] = 2.0 * x[size - 1] - x[size - 1 - k];
  }
  double sum = 0.0;
  for (std::size_t n = 0; n + 2 < size; ++n) {
    const double z = (extended[n + 2 * m] - extended[n + m]) - (extended[n + m] - extended[n]);
    sum += z * z;
  }
  const double tau = static_cast<double>(m);
  return {sum / (2.0 * tau * tau * static_cast<double>(size - 2)), size - 2};
}

namespace {

/// Sum over j = 0 ... 6m-1 of the squared second differences of m-sums of one segment. `sums` are the running sums of
/// the record from the segment's start on, 3m + 1 of them; `extended` is room for 9m + 1.
double segment_squares(const double* sums, std::size_t m, double* extended) {
  const std::size_t length = 3 * m, half = length / 2, rest = length - half;
  const double h = static_cast<double>(half);
  // Slope from the means of the first and the last half (the middle value of an odd length belongs to neither).
  const double slope = ((sums[length] - sums[rest]) - (sums[half] - sums[0])) / (h * static_cast<double>(rest));
  // Running sums of the mirrored segment, the segment and the mirrored segment again, all without the slope.
  const auto without_slope = [&](std::size_t k) {
    const double count = static_cast<double>(k);
    return (sums[k] - sums[0]) - slope * (0.5 * count * (count - 1.0));
  };
  const double all = without_slope(length);
  for (std::size_t k = 0; k <= length; ++k) {
    const double sum = without_slope(k);
    extended[length - k] = all - sum;
    extended[length + k] = all + sum;
    extended[3 * length - k] = 3.0 * all - sum;
  }
  double sum[2] = {0.0, 0.0};
  for (std::size_t j = 0; j < 6 * m; ++j) {
    const double z = (extended[j + 3 * m] - extended[j]) - 3.0 * (extended[j + 2 * m] - extended[j + m]);
    sum[j % 2] += z * z;
  }
  return sum[0] + sum[1];
}

}  // namespace

MeanSquare reflected_segments(std::span<const double> values, std::size_t m) {
  if (values.size() < 3 * m) return {};
  const std::size_t count = values.size() - 3 * m + 1;
  std::vector<double> sums(values.size() + 1, 0.0);
  double mean = 0.0;
  for (const double value : values) mean += value;
  mean /= static_cast<double>(values.size());
  for (std::size_t n = 0; n < values.size(); ++n) sums[n + 1] = sums[n] + (values[n] - mean);

  constexpr std::size_t block =
      256;  // segments a task: fixed, so that the order of addition does not depend on threads
  std::vector<double> partial((count + block - 1) / block, 0.0);
  parallel_for(partial.size(), [&](std::size_t task) {
    std::vector<double> room(9 * m + 1);
    for (std::size_t n = task * block; n < std::min(count, (task + 1) * block); ++n) {
      partial[task] += segment_squares(sums.data() + n, m, room.data());
    }
  });
  double sum = 0.0;
  for (const double part : partial) sum += part;
  const double tau = static_cast<double>(m);
  return {sum / (tau * tau * 6.0 * tau * static_cast<double>(count)), count};
}

MeanSquare theo1_variance(std::span<const double> x, std::size_t m) {
  if (m < 10 || m % 2 != 0 || x.size() <= m) return {};
  const std::size_t outer = x.size() - m, half = m / 2;
  constexpr std::size_t block = 256;
  std::vector<double> partial((outer + block - 1) / block, 0.0);
  parallel_for(partial.size(), [&](std::size_t task) {
    const std::size_t first = task * block, last = std::min(outer, first + block);
    for (std::size_t k = 0; k < half; ++k) {
      double sum = 0.0;
      for (std::size_t i = first; i < last; ++i) {
        const double z = (x[i] - x[i + half - k]) + (x[i + m] - x[i + half + k]);
        sum += z * z;
      }
      partial[task] += sum / static_cast<double>(half - k);
    }
  });
  double sum = 0.0;
  for (const double part : partial) sum += part;
  const double span = static_cast<double>(m);
  return {sum / (0.75 * span * span * static_cast<double>(outer)), outer * half};
}

MeanSquare peak_interval_error(std::span<const double> x, std::size_t m) {
  if (x.size() <= m) return {};
  // Indices whose values still can become the largest (smallest) of a window, in order.
  std::deque<std::size_t> high, low;
  double peak = 0.0;
  for (std::size_t n = 0; n < x.size(); ++n) {
    while (!high.empty() && x[high.back()] <= x[n]) high.pop_back();
    while (!low.empty() && x[low.back()] >= x[n]) low.pop_back();
    high.push_back(n);
    low.push_back(n);
    if (high.front() + m < n) high.pop_front();
    if (low.front() + m < n) low.pop_front();
    if (n >= m) peak = std::max(peak, x[high.front()] - x[low.front()]);
  }
  return {peak, x.size() - m};
}

MeanSquare interval_error_variance(std::span<const double> x, std::size_t m) {
  if (x.size() <= m) return {};
  const std::size_t count = x.size() - m;
  double sum = 0.0;
  for (std::size_t n = 0; n < count; ++n) sum += (x[n + m] - x[n]) * (x[n + m] - x[n]);
  return {sum / static_cast<double>(count), count};
}

}  // namespace tumble
