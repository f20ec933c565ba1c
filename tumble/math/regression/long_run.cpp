#include "tumble/math/regression/long_run.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "tumble/math/fourier.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/matrix3.hpp"
#include "tumble/math/regression/local_polynomial.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr std::size_t lowest_of_start = 8;  ///< ordinates, whose mean is the white noise where the search begins
constexpr double start_share = 0.3, least_start = 1e-12;  ///< [1] of that mean; at least of the unit power
/// Of Levenberg and Marquardt.
constexpr double first_damping = 1e-3, least_damping_of_step = 1e-6, most_damping_of_step = 1e6;
constexpr double least_curvature_of_step = 1e-6, curvature_floor = 1e-12;  ///< of a part that has no effect
constexpr double longest_log_step = 3.0;                                   ///< a factor of 20
constexpr int rounds_of_fit = 100;
constexpr double least_slow = 1e-14;  ///< [unit power] of the slow part
constexpr double last_fall_of_cost = 1e-7;
/// Of -2 ln L by slow noise: chi-square of one degree of freedom exceeds it with p = 0.8 %.
constexpr double slow_fall = 7.0;
constexpr std::size_t correlated_ordinates = 40;  ///< the lowest, of which correlations are estimated
constexpr double least_white_sd = 0.3;            ///< [sd] of the white density, that its value counts as at least

constexpr std::size_t fewest_samples = 64, fewest_ordinates = 16, first_ordinate = 2;

/// X_k for k = 0...count - 1, of the middle of the series.
std::vector<double> projections(std::span<const double> values, std::size_t count) {
  const std::size_t n = smooth_length(values.size(), 1);
  values = values.subspan((values.size() - n) / 2, n);
  // The mean without the velocities at the ends: a plain one would bring them into every odd sine.
  const auto weights = faded_weights(n, 0.1);
  double mean = 0.0, present = 0.0;
  for (std::size_t j = 0; j < n; ++j)
    if (std::isfinite(values[j])) mean += weights[j] * values[j], present += weights[j];
  if (present > 0.0) mean /= present;
  // Odd about its middle, the series repeated backwards has the sines alone.
  std::vector<double> odd(2 * n);
  for (std::size_t j = 0; j < n; ++j) {
    odd[j] = std::isfinite(values[j]) ? values[j] - mean : 0.0;
    odd[2 * n - 1 - j] = -odd[j];
  }
  std::vector<std::complex<double>> spectrum;
  real_transform(odd, spectrum);
  std::vector<double> out(std::min(count, n));
  for (std::size_t k = 0; k < out.size(); ++k) {
    const double half = pi * static_cast<double>(k) / static_cast<double>(2 * n);
    const std::complex<double> turned = spectrum[k] * std::polar(1.0, -half);
    out[k] = -0.5 * turned.imag() * std::sqrt(2.0 / static_cast<double>(n));
    // The mean, which was subtracted, had a part of the white noise in this sine.
    if (k % 2 == 1) out[k] /= std::sqrt(std::max(0.1, 1.0 - 8.0 / (pi * pi * static_cast<double>(k * k))));
  }
  return out;
}

/// Squares of projections at frequencies f, scaled to mean 1, and the parts that their density may have.
struct Whittle {
  std::vector<double> power, frequency;
  static constexpr double floor = 1e-12;

  /// The parts at f: constant, f^2 and 1/f.
  Vector3 columns(std::size_t i) const { return {1.0, frequency[i] * frequency[i], 1.0 / frequency[i]}; }
  double density(std::size_t i, Vector3 parts) const { return dot(columns(i), parts) + floor; }

  /// -2 ln L, up to a constant. Eight densities share a logarithm, which costs more than all else.
  double cost(Vector3 parts) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < power.size();) {
      double product = 1.0;
      for (const std::size_t end = std::min(i + 8, power.size()); i < end; ++i) {
        const double s = density(i, parts);
        product *= s;
        sum += power[i] / s;
      }
      sum += std::log(product);
    }
    return sum;
  }
};

/// Twice the expected information [3 x 3] about the parts.
Matrix3 information(const Whittle& problem, Vector3 parts) {
  Matrix3 sum;
  for (std::size_t i = 0; i < problem.power.size(); ++i) {
    const Vector3 slope = 1.0 / problem.density(i, parts) * problem.columns(i);
    sum += outer(slope, slope);
  }
  return sum;
}

/// Where the search begins: white noise as at the lowest frequencies, the rest as in the upper half.
Vector3 start_of(const Whittle& problem, bool slow) {
  const std::size_t n = problem.power.size(), low = std::min<std::size_t>(lowest_of_start, n);
  double bottom = 0.0, top = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < low; ++i) bottom += problem.power[i] / static_cast<double>(low);
  for (std::size_t i = n - n / 2; i < n; ++i) top += problem.power[i], squares += problem.columns(i).y;
  bottom = start_share * std::max(bottom, least_start);
  return {bottom, top / squares, slow ? bottom * problem.frequency[0] : 0.0};
}

/// A step of scoring in the logarithms of the parts. Given: damping [1].
Vector3 step(const Whittle& problem, Vector3 parts, bool slow, double damping) {
  Vector3 gradient;
  for (std::size_t i = 0; i < problem.power.size(); ++i) {
    const double s = problem.density(i, parts);
    gradient += (problem.power[i] - s) / (s * s) * problem.columns(i);
  }
  gradient = scaled(parts, gradient);
  const Matrix3 weight = diagonal3(parts);
  Matrix3 curvature = weight * information(problem, parts) * weight;
  for (std::size_t i = 0; i < 3; ++i)
    curvature(i, i) += damping * (curvature(i, i) + least_curvature_of_step) + curvature_floor;
  const std::size_t in = slow ? 3 : 2;
  const double right[3]{gradient.x, gradient.y, gradient.z};
  const auto solved = solve_symmetric(block(dense(curvature), 0, in, 0, in), std::span(right, in));
  Vector3 move;
  for (std::size_t i = 0; i < in; ++i) move[i] = std::clamp(solved[i], -longest_log_step, longest_log_step);
  return move;
}

/// Maximum likelihood by scoring in the logarithms of the parts, which differ by many powers of ten; a part that is not
/// there runs down to nothing. `slow`: the third part may be there.
Vector3 fitted(const Whittle& problem, bool slow) {
  Vector3 parts = start_of(problem, slow);
  double cost = problem.cost(parts), damping = first_damping;
  for (int round = 0; round < rounds_of_fit && damping < most_damping_of_step; ++round) {
    const Vector3 move = step(problem, parts, slow, damping);
    Vector3 next;
    for (std::size_t i = 0; i < 3; ++i) next[i] = std::max(parts[i] * std::exp(move[i]), slow ? least_slow : 0.0);
    const double now = problem.cost(next);
    if (!(now <= cost)) {
      damping *= 10.0;
      continue;
    }
    const bool done = cost - now < last_fall_of_cost;
    parts = next;
    cost = now;
    damping = std::max(least_damping_of_step, 0.1 * damping);
    if (done) break;
  }
  return parts;
}

DensityAtZero density_of(const std::vector<double>& x, std::size_t n, bool slow) {
  Whittle problem;
  const double top = static_cast<double>(x.size() - 1) / static_cast<double>(2 * n);  // columns of size about 1
  double mean = 0.0;
  for (std::size_t k = first_ordinate; k < x.size(); ++k) {
    problem.frequency.push_back(static_cast<double>(k) / static_cast<double>(2 * n) / top);
    problem.power.push_back(x[k] * x[k]);
    mean += x[k] * x[k] / static_cast<double>(x.size() - first_ordinate);
  }
  DensityAtZero density;
  density.covariance = Matrix(3, 3);
  density.ordinates = problem.power.size();
  if (!(mean > 0.0) || !std::isfinite(mean)) return density;
  for (double& power : problem.power) power /= mean;
  Vector3 parts = fitted(problem, false);
  std::size_t count = 2;
  if (slow) {
    const Vector3 with = fitted(problem, true);
    if (problem.cost(parts) - problem.cost(with) > slow_fall) parts = with, count = 3;
  }
  const Vector3 scale{mean, mean / (top * top), mean * top};
  const Matrix inverse = inverse_symmetric(0.5 * block(dense(information(problem, parts)), 0, count, 0, count));
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j < count; ++j) density.covariance(i, j) = inverse(i, j) * scale[i] * scale[j];
  density.white = parts.x * scale.x, density.blue = parts.y * scale.y, density.slow = parts.z * scale.z;
  return density;
}

double density_at(const DensityAtZero& d, double f) { return d.white + d.blue * f * f + d.slow / f; }

/// Of the projections at the lowest frequencies, each over the root of its density.
Matrix correlation_of(const std::vector<std::vector<double>>& x, const std::vector<DensityAtZero>& density,
                      std::size_t n) {
  const std::size_t lowest = std::min<std::size_t>(correlated_ordinates, x.front().size() - first_ordinate);
  Matrix z(lowest, x.size());
  for (std::size_t s = 0; s < x.size(); ++s)
    for (std::size_t i = 0; i < lowest; ++i) {
      const std::size_t k = first_ordinate + i;
      const double variance = density_at(density[s], static_cast<double>(k) / static_cast<double>(2 * n));
      z(i, s) = variance > 0.0 ? x[s][k] / std::sqrt(variance) : 0.0;
    }
  Matrix correlation = gram(z);
  const auto squares = diagonal_of(correlation);
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t j = 0; j < x.size(); ++j) {
      const double size = std::sqrt(squares[i] * squares[j]);
      correlation(i, j) = i == j ? 1.0 : (size > 0.0 ? correlation(i, j) / size : 0.0);
    }
  return correlation;
}

/// x^2/2 ln|x| - 3/4 x^2: its second derivative is ln|x|.
double twice_integrated_log(double x) { return x == 0.0 ? 0.0 : 0.5 * x * x * std::log(std::abs(x)) - 0.75 * x * x; }

}  // namespace

std::vector<double> faded_weights(std::size_t n, double share) {
  std::vector<double> weights(n, 1.0);
  const double length = share * static_cast<double>(n);
  double sum = 0.0;
  for (std::size_t j = 0; j < n; ++j) {
    const double from_end = std::min(static_cast<double>(j) + 0.5, static_cast<double>(n - j) - 0.5);
    if (from_end < length) weights[j] = 0.5 - 0.5 * std::cos(pi * from_end / length);
    sum += weights[j];
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

LongRunVariance variance_of_sum(const DensityAtZero& density, std::span<const double> weights, double slow_gain) {
  double squares = 0.0, steps = 0.0, before = 0.0;
  for (const double weight : weights) {
    squares += weight * weight;
    steps += (weight - before) * (weight - before);
    before = weight;
  }
  steps += before * before;
  const double gain[3]{squares, steps / (4.0 * pi * pi), slow_gain}, part[3]{density.white, density.blue, density.slow};
  double variance = 0.0, of_variance = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    variance += gain[i] * std::max(part[i], i == 0 ? least_white_sd * std::sqrt(density.covariance(0, 0)) : 0.0);
    for (std::size_t j = 0; j < 3; ++j) of_variance += gain[i] * gain[j] * density.covariance(i, j);
  }
  if (!(variance > 0.0)) return {0.0, 1.0};
  return {variance, std::max(1.0, 2.0 * variance * variance / of_variance)};
}

LongRun long_run(const std::vector<std::span<const double>>& series, double highest, bool slow) {
  LongRun out;
  if (series.empty()) return out;
  const std::size_t size = series.front().size();
  if (size < fewest_samples) throw Error(Error::Kind::bad_data, "fewer than 64 samples: they give no spectral density");
  const std::size_t n = smooth_length(size, 1);
  const auto wanted = static_cast<std::size_t>(2.0 * static_cast<double>(n) * highest);
  const std::size_t ordinates = std::clamp(wanted, fewest_ordinates, n / 2);
  std::vector<std::vector<double>> x;
  for (const auto& values : series) {
    x.push_back(projections(values, first_ordinate + ordinates));
    out.density.push_back(density_of(x.back(), n, slow));
  }
  out.correlation = correlation_of(x, out.density, n);
  return out;
}

double slow_gain(std::span<const WeightedSpan> spans) {
  const auto& second = twice_integrated_log;
  double sum = 0.0;
  for (const auto& a : spans)
    for (const auto& b : spans) {
      const double integral =
          second(a.end - b.begin) + second(a.begin - b.end) - second(a.begin - b.begin) - second(a.end - b.end);
      sum += a.weight * b.weight * integral / ((a.end - a.begin) * (b.end - b.begin));
    }
  return std::max(0.0, -2.0 * sum);
}

}  // namespace tumble
