#include "tumble/math/regression/long_run.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>

#include "tumble/math/eigen/dense.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3>;

constexpr std::size_t fewest_samples = 64, fewest_ordinates = 16, first_ordinate = 2;

/// Largest number up to n without prime factors beyond 5, so that its transform is fast.
std::size_t smooth_length(std::size_t n) {
  for (;; --n) {
    std::size_t rest = n;
    for (const std::size_t p : {2, 3, 5})
      while (rest % p == 0) rest /= p;
    if (rest == 1) return n;
  }
}

/// X_k for k = 0...count - 1, of the middle of the series.
std::vector<double> projections(std::span<const double> values, std::size_t count) {
  const std::size_t n = smooth_length(values.size());
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
  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  std::vector<std::complex<double>> spectrum;
  fft.fwd(spectrum, odd);
  std::vector<double> out(std::min(count, n));
  for (std::size_t k = 0; k < out.size(); ++k) {
    const double half = pi * static_cast<double>(k) / static_cast<double>(2 * n);
    const std::complex<double> turned = spectrum[k] * std::polar(1.0, -half);
    out[k] = -0.5 * turned.imag() * std::sqrt(2.0 / static_cast<double>(n));
    // What the mean, which was taken off, had of white noise in this sine.
    if (k % 2 == 1) out[k] /= std::sqrt(std::max(0.1, 1.0 - 8.0 / (pi * pi * static_cast<double>(k * k))));
  }
  return out;
}

struct Whittle {
  Columns columns;
  Eigen::VectorXd power;
  double floor = 0.0;

  Eigen::VectorXd density(const Eigen::Vector3d& parts) const { return (columns * parts).array() + floor; }
  double cost(const Eigen::Vector3d& parts) const {
    const Eigen::ArrayXd s = density(parts);
    return (s.log() + power.array() / s).sum();
  }
};

Eigen::Matrix3d information(const Whittle& problem, const Eigen::Vector3d& parts) {
  const Eigen::VectorXd weight = problem.density(parts).array().square().inverse();
  return problem.columns.transpose() * weight.asDiagonal() * problem.columns;
}

/// Maximum likelihood by scoring in the logarithms of the parts, which differ by many powers of ten; a part that is not
/// there runs down to nothing. `slow`: the third part may be there.
Eigen::Vector3d fitted(const Whittle& problem, bool slow) {
  const Eigen::Index n = problem.power.size(), low = std::min<Eigen::Index>(8, n);
  const double bottom = std::max(problem.power.head(low).mean(), 1e-12);
  const Eigen::VectorXd squares = problem.columns.col(1);
  Eigen::Vector3d parts(0.3 * bottom, problem.power.tail(n / 2).sum() / squares.tail(n / 2).sum(), 0.0);
  if (slow) parts[2] = 0.3 * bottom / problem.columns(0, 2);
  const Eigen::Index in = slow ? 3 : 2;
  double cost = problem.cost(parts), damping = 1e-3;
  for (int step = 0; step < 100 && damping < 1e6; ++step) {
    const Eigen::ArrayXd s = problem.density(parts);
    const Eigen::VectorXd slope = ((problem.power.array() - s) / s.square()).matrix();
    const Eigen::Vector3d gradient = parts.cwiseProduct(problem.columns.transpose() * slope);
    Eigen::Matrix3d curvature = parts.asDiagonal() * information(problem, parts) * parts.asDiagonal();
    for (Eigen::Index i = 0; i < 3; ++i) curvature(i, i) += damping * (curvature(i, i) + 1e-6) + 1e-12;
    Eigen::Vector3d move = Eigen::Vector3d::Zero();
    move.head(in) = curvature.topLeftCorner(in, in).ldlt().solve(gradient.head(in));
    move = move.cwiseMax(-3.0).cwiseMin(3.0);
    const Eigen::Vector3d next = parts.cwiseProduct(move.array().exp().matrix()).cwiseMax(slow ? 1e-14 : 0.0);
    const double now = problem.cost(next);
    if (!(now <= cost)) {
      damping *= 10.0;
      continue;
    }
    const bool done = cost - now < 1e-7;
    parts = next;
    cost = now;
    damping = std::max(1e-6, 0.1 * damping);
    if (done) break;
  }
  return parts;
}

DensityAtZero density_of(const std::vector<double>& x, std::size_t n, bool slow) {
  const auto size = static_cast<Eigen::Index>(x.size() - first_ordinate);
  Whittle problem{Columns(size, 3), Eigen::VectorXd(size)};
  const double top = static_cast<double>(x.size() - 1) / static_cast<double>(2 * n);  // columns of size about 1
  for (Eigen::Index i = 0; i < size; ++i) {
    const std::size_t k = first_ordinate + static_cast<std::size_t>(i);
    const double f = static_cast<double>(k) / static_cast<double>(2 * n) / top;
    problem.columns.row(i) << 1.0, f * f, 1.0 / f;
    problem.power[i] = x[k] * x[k];
  }
  DensityAtZero density;
  density.covariance = Matrix(3, 3);
  density.ordinates = static_cast<std::size_t>(size);
  const double mean = problem.power.mean();
  if (!(mean > 0.0) || !std::isfinite(mean)) return density;
  problem.power /= mean;
  problem.floor = 1e-12;
  Eigen::Vector3d parts = fitted(problem, false);
  std::vector<int> there{0, 1};
  if (slow) {
    const Eigen::Vector3d with = fitted(problem, true);
    if (problem.cost(parts) - problem.cost(with) > 7.0) parts = with, there.push_back(2);
  }
  const Eigen::Vector3d scale(mean, mean / (top * top), mean * top);
  const Eigen::MatrixXd inverse = (0.5 * information(problem, parts)(there, there))
                                      .eval()
                                      .ldlt()
                                      .solve(Eigen::MatrixXd::Identity(static_cast<Eigen::Index>(there.size()),
                                                                       static_cast<Eigen::Index>(there.size())));
  for (std::size_t i = 0; i < there.size(); ++i)
    for (std::size_t j = 0; j < there.size(); ++j)
      density.covariance(there[i], there[j]) =
          inverse(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) * scale[there[i]] * scale[there[j]];
  const Eigen::Vector3d found = parts.cwiseProduct(scale);
  density.white = found[0], density.blue = found[1], density.slow = found[2];
  return density;
}

double at(const DensityAtZero& d, double f) { return d.white + d.blue * f * f + d.slow / f; }

/// Of the projections at the lowest frequencies, each over the root of its density.
Matrix correlation_of(const std::vector<std::vector<double>>& x, const std::vector<DensityAtZero>& density,
                      std::size_t n) {
  const auto m = static_cast<Eigen::Index>(x.size());
  const auto lowest = static_cast<Eigen::Index>(std::min<std::size_t>(40, x.front().size() - first_ordinate));
  Eigen::MatrixXd z(m, lowest);
  for (Eigen::Index s = 0; s < m; ++s)
    for (Eigen::Index i = 0; i < lowest; ++i) {
      const std::size_t k = first_ordinate + static_cast<std::size_t>(i);
      const double f = static_cast<double>(k) / static_cast<double>(2 * n);
      const double variance = at(density[static_cast<std::size_t>(s)], f);
      z(s, i) = variance > 0.0 ? x[static_cast<std::size_t>(s)][k] / std::sqrt(variance) : 0.0;
    }
  const Eigen::MatrixXd products = z * z.transpose();
  Matrix correlation(x.size(), x.size());
  for (Eigen::Index i = 0; i < m; ++i)
    for (Eigen::Index j = 0; j < m; ++j) {
      const double size = std::sqrt(products(i, i) * products(j, j));
      correlation(static_cast<std::size_t>(i), static_cast<std::size_t>(j)) =
          i == j ? 1.0 : (size > 0.0 ? products(i, j) / size : 0.0);
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
    variance += gain[i] * std::max(part[i], i == 0 ? 0.3 * std::sqrt(density.covariance(0, 0)) : 0.0);
    for (std::size_t j = 0; j < 3; ++j) of_variance += gain[i] * gain[j] * density.covariance(i, j);
  }
  if (!(variance > 0.0)) return {0.0, 1.0};
  return {variance, std::max(1.0, 2.0 * variance * variance / of_variance)};
}

LongRun long_run(const std::vector<std::span<const double>>& series, double highest, bool slow) {
  LongRun out;
  if (series.empty()) return out;
  const std::size_t size = series.front().size();
  if (size < fewest_samples)
    throw Error(Error::Kind::bad_data, "fewer than 64 samples: no spectral density to be had from them");
  const std::size_t n = smooth_length(size);
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
