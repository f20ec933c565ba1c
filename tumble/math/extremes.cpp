#include "tumble/math/extremes.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace tumble {
namespace {

using Lanes = double __attribute__((vector_size(16)));
using Counts = long long __attribute__((vector_size(16)));

constexpr std::size_t width = 2, rows = 4;

Lanes load(const double* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}

Lanes magnitude(Lanes lanes) { return std::bit_cast<Lanes>(std::bit_cast<Counts>(lanes) & INT64_MAX); }

/// Lowest, highest and present of a stretch that stays in the cache.
Extremes range_of(std::span<const double> values) {
  Extremes result;
  Lanes low[rows], high[rows];
  Counts missing[rows] = {};
  std::fill_n(low, rows, Lanes{} + result.lowest);
  std::fill_n(high, rows, Lanes{} + result.highest);
  std::size_t n = 0;
  for (; n + rows * width <= values.size(); n += rows * width)
    for (std::size_t k = 0; k < rows; ++k) {
      const Lanes value = load(values.data() + n + k * width);
      low[k] = value < low[k] ? value : low[k];  // of NaN neither is true
      high[k] = value > high[k] ? value : high[k];
      missing[k] += value != value;  // true is -1
    }
  result.present = n;
  for (std::size_t k = 0; k < rows; ++k)
    for (std::size_t i = 0; i < width; ++i) {
      result.lowest = std::min(result.lowest, low[k][i]);
      result.highest = std::max(result.highest, high[k][i]);
      result.present -= static_cast<std::size_t>(-missing[k][i]);
    }
  for (; n < values.size(); ++n) {
    result.lowest = values[n] < result.lowest ? values[n] : result.lowest;
    result.highest = values[n] > result.highest ? values[n] : result.highest;
    result.present += values[n] == values[n];
  }
  return result;
}

}  // namespace

void Extremes::add(const Extremes& more) {
  at_lowest = (lowest <= more.lowest ? at_lowest : 0) + (more.lowest <= lowest ? more.at_lowest : 0);
  at_highest = (highest >= more.highest ? at_highest : 0) + (more.highest >= highest ? more.at_highest : 0);
  lowest = std::min(lowest, more.lowest);
  highest = std::max(highest, more.highest);
  present += more.present;
}

Extremes extremes_of(std::span<const double> values) {
  constexpr std::size_t stretch = 1024;
  Extremes all;
  for (std::size_t first = 0; first < values.size(); first += stretch) {
    const auto some = values.subspan(first, std::min(stretch, values.size() - first));
    Extremes part = range_of(some);
    // A new extreme is a rare thing: only then is it counted.
    const auto count = [&](double value) { return static_cast<std::size_t>(std::ranges::count(some, value)); };
    if (part.lowest <= all.lowest) part.at_lowest = count(part.lowest);
    if (part.highest >= all.highest) part.at_highest = count(part.highest);
    all.add(part);
  }
  return all;
}

double greatest_spike(std::span<const double> values, std::size_t begin, std::size_t end) {
  Lanes greatest[rows] = {};
  const double* const x = values.data();
  std::size_t n = begin;
  for (; n + rows * width <= end; n += rows * width)
    for (std::size_t k = 0; k < rows; ++k) {
      const double* const at = x + n + k * width;
      const Lanes before = magnitude(load(at) - load(at - 1)), after = magnitude(load(at) - load(at + 1));
      const Lanes less = after < before ? after : before;
      greatest[k] = less > greatest[k] ? less : greatest[k];  // of NaN it is not
    }
  double result = 0.0;
  for (const Lanes& lanes : greatest)
    for (std::size_t i = 0; i < width; ++i) result = std::max(result, lanes[i]);
  for (; n < end; ++n) {
    const double less = std::min(std::abs(x[n] - x[n - 1]), std::abs(x[n] - x[n + 1]));
    result = less > result ? less : result;
  }
  return result;
}

}  // namespace tumble
