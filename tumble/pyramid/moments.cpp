#include "tumble/pyramid/moments.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>

namespace tumble {
namespace {

constexpr std::size_t lanes = 8;

/// Lanes are summed side by side, which vectorises without a change of the result from one compiler to another.
double total(const double (&lane)[lanes]) {
  return ((lane[0] + lane[1]) + (lane[2] + lane[3])) + ((lane[4] + lane[5]) + (lane[6] + lane[7]));
}

/// Samples of which some may be missing, at any times.
Moments of_some(const double* values, const double* times, std::size_t count, double first_time, double offset) {
  const auto time = [&](std::size_t i) { return times ? times[i] : first_time + static_cast<double>(i); };
  Moments all;
  double sum = 0.0, sum_time = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    if (std::isnan(values[i])) continue;
    all.count += 1.0;
    sum += values[i] - offset;
    sum_time += time(i) - first_time;
    all.minimum = std::min(all.minimum, values[i]);
    all.maximum = std::max(all.maximum, values[i]);
  }
  if (all.count == 0.0) return all;
  all.mean = sum / all.count;
  all.mean_time = first_time + sum_time / all.count;
  for (std::size_t i = 0; i < count; ++i) {
    if (std::isnan(values[i])) continue;
    const double value = values[i] - offset - all.mean, late = time(i) - all.mean_time;
    all.squares += value * value;
    all.squares_time += late * late;
    all.products += value * late;
  }
  return all;
}

using Lanes = double __attribute__((vector_size(32)));
constexpr std::size_t width = 4, rows = 4;

[[gnu::always_inline]] inline double total(const Lanes (&lanes)[rows]) {
  const Lanes sum = (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/// Sums, and their order, are those of the lanes: the processor does not matter.
[[gnu::always_inline]] inline double sum_of_block(const double* values, double offset, BarBounds& bars) {
  Lanes sum[rows] = {};
  for (std::size_t bar = 0; bar < block_samples / bar_samples; ++bar) {
    const double* const from = values + bar * bar_samples;
    Lanes least[rows], most[rows];
    for (std::size_t k = 0; k < rows; ++k) {
      std::memcpy(&least[k], from + k * width, sizeof(Lanes));
      most[k] = least[k];
    }
#pragma GCC unroll 4
    for (std::size_t i = 0; i < bar_samples; i += rows * width)
#pragma GCC unroll 4
      for (std::size_t k = 0; k < rows; ++k) {
        Lanes value;
        std::memcpy(&value, from + i + k * width, sizeof value);
        sum[k] += value - offset;
        least[k] = value < least[k] ? value : least[k];
        most[k] = value > most[k] ? value : most[k];
      }
    Lanes low = least[0], high = most[0];
    for (std::size_t k = 1; k < rows; ++k) {
      low = least[k] < low ? least[k] : low;
      high = most[k] > high ? most[k] : high;
    }
    bars.least[bar] = std::min(std::min(low[0], low[1]), std::min(low[2], low[3]));
    bars.greatest[bar] = std::max(std::max(high[0], high[1]), std::max(high[2], high[3]));
  }
  return total(sum);
}

/// Sums of squares, and of products with the number of the sample, about their means.
[[gnu::always_inline]] inline void squares_of_block(const double* values, double base, double rest, double& squares,
                                                    double& products) {
  constexpr double middle = 0.5 * (block_samples - 1.0);
  Lanes square[rows] = {}, product[rows] = {}, late = {0.0 - middle, 1.0 - middle, 2.0 - middle, 3.0 - middle};
  for (std::size_t i = 0; i < block_samples; i += rows * width)
#pragma GCC unroll 4
    for (std::size_t k = 0; k < rows; ++k) {
      Lanes value;
      std::memcpy(&value, values + i + k * width, sizeof value);
      value = value - base - rest;
      square[k] += value * value;
      product[k] += value * late;
      late += static_cast<double>(width);
    }
  squares = total(square);
  products = total(product);
}

[[gnu::always_inline]] inline bool block(const double* values, double first_time, double offset, Moments& moments,
                                         BarBounds& bars) {
  constexpr double count = block_samples;
  const double sum = sum_of_block(values, offset, bars);
  if (!std::isfinite(sum)) return false;
  const double mean = sum / count, base = offset + mean;
  moments.count = count;
  moments.mean = mean;
  moments.mean_time = first_time + 0.5 * (count - 1.0);
  moments.squares_time = count * (count * count - 1.0) / 12.0;
  squares_of_block(values, base, mean - (base - offset), moments.squares, moments.products);  // base is rounded
  moments.minimum = *std::min_element(std::begin(bars.least), std::end(bars.least));
  moments.maximum = *std::max_element(std::begin(bars.greatest), std::end(bars.greatest));
  return true;
}

#ifdef __x86_64__
[[gnu::target("avx2")]] bool block_avx2(const double* values, double first_time, double offset, Moments& moments,
                                        BarBounds& bars) {
  return block(values, first_time, offset, moments, bars);
}
#endif

}  // namespace

bool moments_of_block(const double* values, double first_time, double offset, Moments& moments, BarBounds& bars) {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2")) return block_avx2(values, first_time, offset, moments, bars);
#endif
  return block(values, first_time, offset, moments, bars);
}

Moments joined(const Moments& a, const Moments& b) {
  if (a.count == 0.0) return b;
  if (b.count == 0.0) return a;
  Moments both;
  both.count = a.count + b.count;
  const double shift = b.mean - a.mean, late = b.mean_time - a.mean_time, weight = a.count * b.count / both.count;
  both.mean = a.mean + shift * (b.count / both.count);
  both.mean_time = a.mean_time + late * (b.count / both.count);
  both.squares = a.squares + b.squares + shift * shift * weight;
  both.squares_time = a.squares_time + b.squares_time + late * late * weight;
  both.products = a.products + b.products + shift * late * weight;
  both.minimum = std::min(a.minimum, b.minimum);
  both.maximum = std::max(a.maximum, b.maximum);
  return both;
}

Moments moments_of(const double* values, const double* times, std::size_t count, double first_time, double offset) {
  if (times || count % lanes != 0) return of_some(values, times, count, first_time, offset);
  double sum[lanes] = {}, least[lanes], most[lanes];
  std::fill_n(least, lanes, std::numeric_limits<double>::infinity());
  std::fill_n(most, lanes, -std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < count; i += lanes)
    for (std::size_t k = 0; k < lanes; ++k) {
      const double value = values[i + k];
      sum[k] += value - offset;
      least[k] = value < least[k] ? value : least[k];
      most[k] = value > most[k] ? value : most[k];
    }
  const double all = total(sum), number = static_cast<double>(count);
  if (std::isnan(all) || count == 0) return of_some(values, times, count, first_time, offset);
  const double mean = all / number, middle = 0.5 * (number - 1.0), base = offset + mean;
  const double rest = mean - (base - offset);  // base is rounded
  double square[lanes] = {}, product[lanes] = {};
  for (std::size_t i = 0; i < count; i += lanes)
    for (std::size_t k = 0; k < lanes; ++k) {
      const double value = values[i + k] - base - rest;
      square[k] += value * value;
      product[k] += value * (static_cast<double>(static_cast<int>(i + k)) - middle);
    }
  return {number,
          mean,
          total(square),
          first_time + middle,
          number * (number * number - 1.0) / 12.0,
          total(product),
          *std::min_element(least, least + lanes),
          *std::max_element(most, most + lanes)};
}

}  // namespace tumble
