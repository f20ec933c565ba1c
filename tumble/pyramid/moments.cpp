#include "tumble/pyramid/moments.hpp"

#include <algorithm>
#include <cmath>

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

}  // namespace

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
