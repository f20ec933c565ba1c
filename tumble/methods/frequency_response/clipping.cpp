#include "tumble/methods/frequency_response/clipping.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::frequency_response {
namespace {

constexpr std::size_t bins = 64, fewest_bins = 40;
constexpr int angles = 20;
constexpr double angle_step = 0.07;  ///< [rad]
/// Fall of chi-square by the two angles of a cut: it exceeds 40 by noise with p = e^-20 = 2e-9, and fewer than 100
/// pairs of angles are tried.
constexpr double cut_improvement = 40.0;
/// [1] of the squares that harmonics alone leave, which a cut may leave at most. Chosen: a cut explains a fifth of them
/// and more; doubled to two fifths, cuts beside other distortion are missed.
constexpr double cut_remaining = 0.8;

/// Means over parts of the cycle.
struct Cycle {
  std::vector<double> phase, mean, weight;
};

Cycle folded(const std::vector<double>& phase, const std::vector<double>& values) {
  std::vector<double> sum(bins, 0.0), angle(bins, 0.0), count(bins, 0.0);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    const double turns = phase[i] / two_pi, part = turns - std::floor(turns);
    const auto b = std::min(bins - 1, static_cast<std::size_t>(part * static_cast<double>(bins)));
    sum[b] += values[i];
    angle[b] += two_pi * part;
    ++count[b];
  }
  Cycle cycle;
  for (std::size_t b = 0; b < bins; ++b) {
    if (count[b] == 0.0) continue;
    cycle.phase.push_back(angle[b] / count[b]);
    cycle.mean.push_back(sum[b] / count[b]);
    cycle.weight.push_back(count[b]);
  }
  return cycle;
}

double cut(double psi, double high, double low) { return std::clamp(std::cos(psi), -std::cos(low), std::cos(high)); }

/// Sum of the weighted squares that constant, tone and harmonics 2 and 3 leave; the tone may turn a little.
double remaining(const Cycle& cycle, double high, double low) {
  const std::size_t n = cycle.phase.size();
  Matrix x(n, 7);
  for (std::size_t b = 0; b < n; ++b) {
    const double psi = cycle.phase[b];
    const double row[7]{1.0,
                        cut(psi, high, low),
                        std::sin(psi),
                        std::cos(2.0 * psi),
                        std::sin(2.0 * psi),
                        std::cos(3.0 * psi),
                        std::sin(3.0 * psi)};
    for (std::size_t k = 0; k < 7; ++k) x(b, k) = row[k];
  }
  const auto products = transposed(x) * scaled(cycle.weight, cycle.mean);
  const auto left = difference(cycle.mean, x * solve_symmetric(gram(x, cycle.weight), products));
  return dot(left, scaled(cycle.weight, left));
}

/// Of the fundamental of cos cut at these angles, what is lost.
double loss_of(double high, double low) {
  constexpr int points = 720;
  double sum = 0.0;
  for (int i = 0; i < points; ++i) {
    const double psi = two_pi * (i + 0.5) / points;
    sum += cut(psi, high, low) * std::cos(psi) * 2.0 / points;
  }
  return 1.0 - sum;
}

}  // namespace

FlatTops flat_tops(const std::vector<double>& phase, const std::vector<double>& values) {
  const Cycle cycle = folded(phase, values);
  FlatTops tops;
  if (cycle.phase.size() < fewest_bins) return tops;
  const double harmonics_alone = remaining(cycle, 0.0, 0.0);
  double least = harmonics_alone, high = 0.0, low = 0.0;
  const auto take = [&](double h, double l) {
    const double left = remaining(cycle, h, l);
    if (left < least) least = left, high = h, low = l;
  };
  for (int k = 1; k < angles; ++k) {
    const double angle = k * angle_step;
    for (const auto& [h, l] : {std::pair(angle, angle), std::pair(angle, 0.0), std::pair(0.0, angle)}) take(h, l);
  }
  if (low > 0.0 && high > 0.0)
    for (int k = 0; k < angles; ++k) take(high, k * angle_step);
  const double noise = least / static_cast<double>(cycle.phase.size() - 9);
  if (!(noise > 0.0)) return tops;
  tops.improvement = (harmonics_alone - least) / noise;
  tops.loss = loss_of(high, low);
  tops.found = tops.improvement > cut_improvement && least < cut_remaining * harmonics_alone;
  return tops;
}

}  // namespace tumble::frequency_response
