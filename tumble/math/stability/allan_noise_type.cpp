#include "tumble/math/stability/allan_noise_type.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "tumble/math/parallel.hpp"
#include "tumble/math/stability/allan_differences.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

constexpr double stationary_rho = 0.25;  ///< Riley and Greenhall, 2004: differences are taken until rho is below it

constexpr std::size_t fewest_for_autocorrelation = 30;
constexpr std::size_t fewest_for_phase = 128;
constexpr std::size_t fewest_for_ratio = 8;
constexpr std::size_t segment_points = 4096;  // of a long decimated phase, read in this many points at a time ...
constexpr std::size_t most_segments = 4;      // ... so many times, evenly over the record
constexpr int most_differences = 3;

using Series = std::vector<double>;

/// z_i <- z_{i+1} - z_i
void difference(Series& z) {
  for (std::size_t i = 0; i + 1 < z.size(); ++i) z[i] = z[i + 1] - z[i];
  if (!z.empty()) z.pop_back();
}

/// Sum of term(i) over i < count, four partial sums beside each other so that none waits for the one before.
template <class Term>
double sum_of(std::size_t count, const Term& term) {
  double sums[4] = {};
  std::size_t i = 0;
  for (; i + 4 <= count; i += 4)
    for (std::size_t k = 0; k < 4; ++k) sums[k] += term(i + k);
  for (; i < count; ++i) sums[0] += term(i);
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

std::size_t points(const std::vector<Series>& all) {
  std::size_t count = 0;
  for (const auto& series : all) count += series.size();
  return count;
}

/// r = sum (z_i - mean)(z_{i+1} - mean)/sum (z_i - mean)^2, pooled over the series.
double lag_1_autocorrelation(const std::vector<Series>& all) {
  double sum = 0.0, products = 0.0, squares = 0.0;
  for (const auto& z : all) sum += sum_of(z.size(), [&](std::size_t i) { return z[i]; });
  const double mean = sum / static_cast<double>(points(all));
  for (const auto& z : all) {
    squares += sum_of(z.size(), [&](std::size_t i) { return (z[i] - mean) * (z[i] - mean); });
    if (!z.empty()) products += sum_of(z.size() - 1, [&](std::size_t i) { return (z[i] - mean) * (z[i + 1] - mean); });
  }
  return squares > 0.0 ? products / squares : 0.0;
}

/// Phase at stride m of one run, in segments where it is long.
void append_decimated(const Phase& phase, const PhaseRun& run, std::size_t m, std::vector<Series>& all) {
  const std::size_t count = (run.last - run.first) / m + 1;
  const bool whole = count <= segment_points * most_segments;
  const std::size_t segments = whole ? 1 : most_segments;
  const std::size_t length = whole ? count : segment_points;
  for (std::size_t k = 0; k < segments; ++k) {
    const std::size_t from = segments == 1 ? 0 : k * (count - length) / (segments - 1);
    Series z(length);
    for (std::size_t i = 0; i < length; ++i) z[i] = phase.values[run.first + (from + i) * m];
    all.push_back(std::move(z));
  }
}

std::vector<Series> decimated(const Phase& phase, std::size_t m) {
  std::vector<Series> all;
  for (const auto& run : phase.runs) {
    if (run.last - run.first >= 2 * m) append_decimated(phase, run, m, all);
  }
  return all;
}

/// What the record says at one factor, whatever it says at the others.
struct Reading {
  enum class Kind { nothing, ratio, autocorrelation } kind = Kind::nothing;
  int alpha = 0;
  double exponent = 0.0, sd = 0.0;  ///< before it was rounded to alpha, of an autocorrelation
};

Reading from_autocorrelation(std::vector<Series> all, bool gaps) {
  // Across a gap the phase is not known, and in a short record its quadratic takes much of a random walk away: there
  // the averages (d = 1) are the start.
  for (auto& z : all) {
    if (!gaps) remove_quadratic(z);
  }
  int d = 0;
  if (gaps || points(all) < fewest_for_phase) {
    for (auto& z : all) difference(z);
    d = 1;
  }
  for (;; ++d) {
    const double r = lag_1_autocorrelation(all);
    const double rho = r / (1.0 + r);
    if (rho < stationary_rho || d >= most_differences) {
      const double exponent = 2.0 - 2.0 * (rho + d);
      const double sd = 2.0 / ((1.0 + r) * (1.0 + r) * std::sqrt(static_cast<double>(points(all))));  // of r: 1/sqrt(n)
      return {Reading::Kind::autocorrelation, std::clamp(static_cast<int>(std::lround(exponent)), -4, 2), exponent, sd};
    }
    for (auto& z : all) difference(z);
  }
}

/// Expected B1 = sample variance/Allan variance of n averages, mu = the exponent of tau in the Allan variance.
double expected_b1(double n, int alpha) {
  switch (alpha) {
    case 2:
    case 1:
      return (n * n - 1.0) / (1.5 * n * (n - 1.0));
    case 0:
      return 1.0;
    case -1:
      return n * std::log(n) / (2.0 * (n - 1.0) * std::numbers::ln2);
    case -2:
      return n / 2.0;
    default:
      return n * (n + 1.0) / 6.0;
  }
}

/// Modified Allan variance over plain one of flicker phase noise, bandwidth 1/(2 t0).
double expected_r(double m) {
  const double plain = 1.038 + 3.0 * std::log(pi * m);
  return 1.5 * std::log(256.0 / 27.0) / plain;
}

/// sum over n of (sum_{i=n}^{n+m-1} x_{i+2m} - 2 x_{i+m} + x_i)^2 and its number of terms, over every run.
struct ModifiedSum {
  double squares = 0.0;
  std::size_t terms = 0;
};
ModifiedSum modified_sum(const Phase& phase, std::size_t m) {
  ModifiedSum result;
  for (const auto& run : phase.runs) {
    if (run.points() < 3 * m + 1) continue;
    const double* x = phase.values.data() + run.first;
    double z = 0.0;
    for (std::size_t i = 0; i < m; ++i) z += (x[i] - x[i + m]) + (x[i + 2 * m] - x[i + m]);
    result.squares += z * z;
    ++result.terms;
    for (std::size_t n = 0; n + 3 * m + 1 < run.points(); ++n) {
      z += (x[n + 3 * m] - x[n]) - 3.0 * (x[n + 2 * m] - x[n + m]);
      result.squares += z * z;
      ++result.terms;
    }
  }
  return result;
}

int from_variance_ratio(std::vector<Series> all, const Phase& phase, std::size_t factor, double allan_variance) {
  for (auto& z : all) difference(z);
  const double n = static_cast<double>(points(all));
  double sum = 0.0, squares = 0.0;
  for (const auto& z : all) {
    for (const double value : z) sum += value;
  }
  for (const auto& z : all) {
    for (const double value : z) squares += (value - sum / n) * (value - sum / n);
  }
  const double b1 = squares / (n - 1.0) / allan_variance;
  const auto between = [&](int a, int b) { return std::sqrt(expected_b1(n, a) * expected_b1(n, b)); };
  for (int alpha = -3; alpha < 0; ++alpha) {
    if (b1 > between(alpha, alpha + 1)) return alpha;
  }
  if (b1 > between(0, 1)) return 0;
  const double m = static_cast<double>(factor);
  const auto modified = modified_sum(phase, factor);
  if (modified.terms == 0) return 1;
  const double ratio = modified.squares / (2.0 * m * m * static_cast<double>(modified.terms)) / allan_variance;
  return ratio < std::sqrt(expected_r(m) / m) ? 2 : 1;
}

Reading read_type(const Phase& phase, std::size_t factor, double allan_sum) {
  std::size_t terms = 0;
  for (const auto& run : phase.runs) terms += run.points() > 2 * factor ? run.points() - 2 * factor : 0;
  auto series = decimated(phase, factor);
  const std::size_t count = points(series);
  if (count < fewest_for_ratio || terms == 0 || !(allan_sum > 0.0)) return {};
  if (count >= fewest_for_autocorrelation) return from_autocorrelation(std::move(series), phase.has_gaps());
  const double allan_variance = allan_sum / (2.0 * static_cast<double>(terms));
  return {Reading::Kind::ratio, from_variance_ratio(std::move(series), phase, factor, allan_variance)};
}

/// The type where the next shorter tau has type `shorter`.
int settled(const Reading& reading, int shorter) {
  switch (reading.kind) {
    case Reading::Kind::nothing:
      return shorter;
    case Reading::Kind::ratio:
      return std::min(shorter, reading.alpha);
    case Reading::Kind::autocorrelation:
      break;
  }
  const bool too_white =
      reading.alpha > 0 && reading.alpha > shorter && reading.exponent < shorter + 0.5 + 2.0 * reading.sd;
  return too_white ? std::max(shorter, 0) : reading.alpha;
}

}  // namespace

std::vector<int> identify_noise_types(const Phase& phase, std::span<const std::size_t> factors) {
  // The octaves of the record from one sample on decide what follows what, whichever factors are asked for.
  const std::size_t longest = factors.empty() ? 0 : *std::ranges::max_element(factors);
  std::vector<std::size_t> all(factors.begin(), factors.end());
  for (std::size_t octave = 1; octave <= longest; octave *= 2) all.push_back(octave);
  std::ranges::sort(all);
  const auto repeated = std::ranges::unique(all);
  all.erase(repeated.begin(), repeated.end());
  const auto sums = second_difference_sums(phase, all);
  std::vector<Reading> readings(all.size());
  parallel_for(all.size(), [&](std::size_t i) { readings[i] = read_type(phase, all[i], sums[i]); });
  std::map<std::size_t, int> types;
  int octave = 2;
  for (std::size_t i = 0; i < all.size(); ++i) {
    types[all[i]] = settled(readings[i], octave);
    if (std::has_single_bit(all[i])) octave = types[all[i]];
  }
  std::vector<int> asked;
  for (const std::size_t factor : factors) asked.push_back(types.at(factor));
  return asked;
}

}  // namespace tumble
