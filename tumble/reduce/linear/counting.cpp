#include <algorithm>
#include <cmath>

#include "tumble/math/bisection.hpp"
#include "tumble/reduce/linear/rows.hpp"
#include "tumble/reduce/pulses/rounding.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::linear {
namespace {

/// Stretches of samples without a hole in it: each begins and ends with a reading of the counter.
double pieces_of(const Stretch& stretch) {
  if (stretch.values.empty()) return 1.0;
  double pieces = 0.0;
  for (std::size_t i = 0; i < stretch.values.size(); ++i)
    if (!std::isnan(stretch.values[i]) && (i == 0 || std::isnan(stretch.values[i - 1]))) pieces += 1.0;
  return pieces;
}

/// Entry b of the k-th cosine over n blocks, of unit norm.
double cosine(std::size_t k, std::size_t b, std::size_t n) {
  const auto size = static_cast<double>(n);
  return std::sqrt(2.0 / size) * std::cos(pi * static_cast<double>(k) * (static_cast<double>(b) + 0.5) / size);
}

/// Blocks of one steady stretch in their cosines k = 1 ... n - 1, where white noise and rounding are nearly
/// independent of each other: those of white noise have the variance s^2, those of rounding `rounding`.
struct Blocks {
  std::size_t first = 0, end = 0;
  double mean = 0.0;                    ///< of the output
  std::vector<double> waves, rounding;  ///< [SI^2 s], the blocks taken times the root of their weight
};

/// Rounding is x_b = e_b - e_(b-1) with independent e: a cosine c over blocks of weights w sees the squares of
/// c_b/sqrt(w_b) - c_(b+1)/sqrt(w_(b+1)) and of the free ends. The last block may be much shorter than the others.
Blocks blocks_of(const Problem& problem, const Rows& rows, std::size_t first, std::size_t end) {
  Blocks blocks{first, end, 0.0, {}, {}};
  double time = 0.0;
  for (std::size_t i = first; i < end; ++i) {
    blocks.mean += rows.weights[i] * rows.output[i];
    time += rows.weights[i];
  }
  blocks.mean /= time;
  const std::size_t n = end - first;
  const double unit = problem.pulse * problem.pulse * pulses::reading_variance;
  for (std::size_t k = 1; k < n; ++k) {
    double wave = 0.0, differences = 0.0, before = 0.0;
    for (std::size_t b = 0; b < n; ++b) {
      const double root = std::sqrt(rows.weights[first + b]), share = cosine(k, b, n) / root;
      wave += cosine(k, b, n) * root * (rows.output[first + b] - blocks.mean);
      differences += (share - before) * (share - before);
      before = share;
    }
    blocks.waves.push_back(wave);
    blocks.rounding.push_back(unit * (differences + before * before));
  }
  return blocks;
}

/// s^2 of greatest likelihood; 0 where the waves are no greater than rounding makes them.
double white_variance(const std::vector<Blocks>& all) {
  const auto slope = [&](double white) {
    double sum = 0.0;
    for (const auto& blocks : all)
      for (std::size_t k = 0; k < blocks.waves.size(); ++k) {
        const double variance = white + blocks.rounding[k];
        sum += (blocks.waves[k] * blocks.waves[k] - variance) / (variance * variance);
      }
    return sum;
  };
  double high = 0.0;
  for (const auto& blocks : all)
    for (const double wave : blocks.waves) high = std::max(high, wave * wave);
  if (!(high > 0.0) || slope(0.0) <= 0.0) return 0.0;
  constexpr int halvings = 100;  // to rounding
  return bisected(0.0, high, halvings, [&](double white) { return slope(white) > 0.0; }).middle();
}

/// Shrinks every wave to what is not rounding.
void shrink(const Blocks& blocks, double white, Rows& rows) {
  constexpr double least = 1e-3;  // so that there remains a noise to be estimated
  const std::size_t n = blocks.end - blocks.first;
  std::vector<double> off(n, 0.0);
  double mean = 0.0, time = 0.0;
  for (std::size_t b = 0; b < n; ++b) {
    const double weight = rows.weights[blocks.first + b];
    for (std::size_t k = 1; k < n; ++k) {
      const double share = std::max(least, white / (white + blocks.rounding[k - 1]));
      off[b] += std::sqrt(share / weight) * cosine(k, b, n) * blocks.waves[k - 1];
    }
    mean += weight * off[b];
    time += weight;
  }
  for (std::size_t b = 0; b < n; ++b) rows.output[blocks.first + b] = blocks.mean + off[b] - mean / time;
}

}  // namespace

KnownEffect take_out_counting(const Evidences& evidence, const Problem& problem, Rows& rows) {
  KnownEffect effect{"counting", std::vector<double>(rows.weights.size(), 0.0), true};
  if (!(problem.pulse > 0.0)) return effect;
  std::vector<Blocks> all;
  for (std::size_t first = 0, end = 0; first < rows.segment.size(); first = end) {
    const std::size_t g = rows.segment[first];
    while (end < rows.segment.size() && rows.segment[end] == g) ++end;
    const Stretch& stretch = evidence.test.stretches[g];
    if (!evidence.uniform(g) && evidence.blocking[g].instants.empty()) continue;
    const double sd =
        std::sqrt(pieces_of(stretch) * pulses::rounding_variance(problem.pulse, rows.segments[g].duration));
    std::fill(effect.column.begin() + static_cast<std::ptrdiff_t>(first),
              effect.column.begin() + static_cast<std::ptrdiff_t>(end), sd);
    if (!rows.output.empty()) all.push_back(blocks_of(problem, rows, first, end));
  }
  const double white = white_variance(all);
  for (const auto& blocks : all) shrink(blocks, white, rows);
  return effect;
}

}  // namespace tumble::linear
