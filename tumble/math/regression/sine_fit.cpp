#include "tumble/math/regression/sine_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/FFT>

#include "tumble/math/eigen/dense.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using Columns = Eigen::MatrixXd;
using Column = Eigen::VectorXd;

/// The samples there are, with times from the middle.
struct Samples {
  std::vector<double> time, value;
  double centre = 0.0, span = 0.0, step = 0.0;
};

Samples usable(std::span<const double> times, std::span<const double> values, double rate) {
  Samples s;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    if (!std::isfinite(values[i]) || !std::isfinite(times[i]))
      throw Error(Error::Kind::bad_data, fmt::format("sine fit: sample {} is not finite", i));
    s.time.push_back(times[i]);
    s.value.push_back(values[i]);
  }
  if (s.time.size() < 2) throw Error(Error::Kind::bad_data, "sine fit: fewer than two samples");
  const double length = s.time.back() - s.time.front();
  s.step = rate > 0.0 ? 1.0 / rate : length / static_cast<double>(s.time.size() - 1);
  s.span = length + s.step;
  s.centre = 0.5 * (s.time.front() + s.time.back());
  for (double& t : s.time) t -= s.centre;
  return s;
}

/// exp(i 2 pi f t): by products over runs of even samples, afresh every 32 and at every gap.
void waves(const Samples& s, double frequency, Eigen::Ref<Column> cosine, Eigen::Ref<Column> sine) {
  const std::complex<double> turn = std::polar(1.0, two_pi * frequency * s.step);
  std::complex<double> now;
  for (std::size_t i = 0; i < s.time.size(); ++i) {
    const bool next = i % 32 != 0 && std::abs(s.time[i] - s.time[i - 1] - s.step) < 1e-9 * s.step;
    now = next ? now * turn : std::polar(1.0, std::fmod(frequency * s.time[i], 1.0) * two_pi);
    const auto row = static_cast<Eigen::Index>(i);
    cosine[row] = now.real();
    sine[row] = now.imag();
  }
}

Columns design(const Samples& s, double frequency, const SineFitOptions& how) {
  const auto n = static_cast<Eigen::Index>(s.time.size());
  Columns x(n, 2 * how.harmonics + how.polynomial + 1);
  for (int k = 0; k < how.harmonics; ++k) waves(s, (k + 1) * frequency, x.col(2 * k), x.col(2 * k + 1));
  const Column u = Eigen::Map<const Column>(s.time.data(), n) * (2.0 / s.span);
  Column power = Column::Ones(n);
  for (int p = 0; p <= how.polynomial; ++p, power.array() *= u.array()) x.col(2 * how.harmonics + p) = power;
  return x;
}

/// Derivative by the number of cycles over half of the span.
Column by_frequency(const Samples& s, const Columns& x, const Column& b, const SineFitOptions& how) {
  Column d = Column::Zero(x.rows());
  for (int k = 0; k < how.harmonics; ++k)
    d += (k + 1) * two_pi * (b[2 * k + 1] * x.col(2 * k) - b[2 * k] * x.col(2 * k + 1));
  return d.array() * Eigen::Map<const Column>(s.time.data(), x.rows()).array() * (2.0 / s.span);
}

struct Solved {
  Columns x;  ///< with the derivative by frequency last, where it is fitted
  Column b, residual;
  double frequency = 0.0;
};

Solved solve(const Samples& s, double start, const SineFitOptions& how) {
  Solved now;
  now.frequency = start;
  const Column y = Eigen::Map<const Column>(s.value.data(), static_cast<Eigen::Index>(s.value.size()));
  for (int round = 0;; ++round) {
    now.x = design(s, now.frequency, how);
    now.b = now.x.householderQr().solve(y);
    now.residual = y - now.x * now.b;
    if (!how.fit_frequency) return now;
    Columns wider(now.x.rows(), now.x.cols() + 1);
    wider << now.x, by_frequency(s, now.x, now.b, how);
    const Column step = wider.householderQr().solve(now.residual);
    const double cycles = step[step.size() - 1];  // over half of the span
    now.x = std::move(wider);
    if (std::abs(cycles) < 4e-15 * std::max(1.0, now.frequency * s.span) || round == 20) return now;
    now.frequency += std::clamp(cycles, -0.4, 0.4) * 2.0 / s.span;
    if (std::abs(now.frequency - start) * s.span > 1.0)
      throw Error(
          Error::Kind::bad_data,
          fmt::format("sine fit: no line near {:.6g} Hz, the search ran away to {:.6g} Hz", start, now.frequency));
  }
}

/// Where projections for the noise may lie: about the (aliased) line, clear of zero, of half of the rate and of lines.
std::vector<double> neighbours(const Samples& s, double frequency, const SineFitOptions& how) {
  const double rate = 1.0 / s.step, bin = 1.0 / s.span, here = aliased_frequency(frequency, rate);
  const double most = std::clamp(0.3 * here * s.span, 4.0, 11.0);
  std::vector<double> found;
  for (int m = 2; m <= static_cast<int>(most); ++m) {
    for (const double side : {-1.0, 1.0}) {
      const double f = here + side * m * bin;
      bool clear = f > 1.4 * bin && f < 0.5 * rate - 1.4 * bin;
      for (int k = 2; clear && k <= how.harmonics; ++k)
        clear = std::abs(f - aliased_frequency(k * frequency, rate)) > 1.4 * bin;
      if (clear) found.push_back(f);
    }
  }
  return found;
}

void find_noise(const Samples& s, const Solved& solved, const SineFitOptions& how, SineFit& fit) {
  const Eigen::Index n = solved.x.rows(), p = solved.x.cols();
  const double squares = solved.residual.squaredNorm();
  fit.residual_rms = std::sqrt(squares / static_cast<double>(n));
  fit.degrees_of_freedom = static_cast<double>(n - p);
  fit.noise_variance = squares / fit.degrees_of_freedom;
  const auto places = neighbours(s, solved.frequency, how);
  if (2 * places.size() < 4 || static_cast<double>(2 * places.size()) > 0.5 * fit.degrees_of_freedom) return;
  const Columns q = solved.x.householderQr().householderQ() * Columns::Identity(n, p);
  Columns pair(n, 2);
  double sum = 0.0, count = 0.0;
  for (const double f : places) {
    waves(s, f, pair.col(0), pair.col(1));
    pair -= q * (q.transpose() * pair);
    for (Eigen::Index c = 0; c < 2; ++c) {
      const double norm = pair.col(c).squaredNorm();
      if (norm < 0.05 * static_cast<double>(n)) continue;
      const double r = pair.col(c).dot(solved.residual);
      sum += r * r / norm;
      ++count;
    }
  }
  if (count < 4.0) return;
  fit.noise_variance = sum / count;
  fit.degrees_of_freedom = count;
}

void refuse(const Samples& s, double frequency, const SineFitOptions& how) {
  const auto parameters = static_cast<std::size_t>(2 * how.harmonics + how.polynomial + 2);
  if (s.time.size() < parameters + 4)
    throw Error(Error::Kind::bad_data,
                fmt::format("sine fit: {} samples are too few for {} parameters", s.time.size(), parameters));
  if (!(frequency > 0.0) || !std::isfinite(frequency))
    throw Error(Error::Kind::bad_input, fmt::format("sine fit: a frequency of {} Hz", frequency));
  if (frequency * s.span < 1.0)
    throw Error(Error::Kind::bad_data,
                fmt::format("sine fit: {:.4g} s hold less than one cycle of {:.6g} Hz", s.span, frequency));
  const double rate = 1.0 / s.step, here = aliased_frequency(frequency, rate);
  if (std::min(here, 0.5 * rate - here) * s.span < 0.9)
    throw Error(Error::Kind::bad_data,
                fmt::format("sine fit: {:.6g} Hz lies within one cycle over {:.4g} s of a multiple of half of the "
                            "sampling rate {:.6g} Hz, where sine and cosine cannot be told apart",
                            frequency, s.span, rate));
}

Matrix covariance_of(const Columns& x, double variance) {
  const Eigen::Index p = x.cols();
  const Columns r = x.householderQr().matrixQR().topRows(p).triangularView<Eigen::Upper>();
  const Columns inverse = r.triangularView<Eigen::Upper>().solve(Columns::Identity(p, p));
  Matrix c(static_cast<std::size_t>(p), static_cast<std::size_t>(p));
  Eigen::Map<Columns>(c.values.data(), p, p) = variance * inverse * inverse.transpose();
  return c;
}

/// Gradient' Cov gradient for the first line, gradient (a, b) over Re a_1 and -Im a_1.
double along(const Matrix& c, double a, double b) { return a * a * c(0, 0) + 2.0 * a * b * c(0, 1) + b * b * c(1, 1); }

}  // namespace

double SineFit::log_gain_variance() const {
  const double power = std::norm(line[0]);
  return along(covariance, line[0].real() / power, -line[0].imag() / power);
}

double SineFit::phase_variance() const {
  const double power = std::norm(line[0]);
  return along(covariance, line[0].imag() / power, line[0].real() / power);
}

double aliased_frequency(double frequency, double rate) {
  return std::abs(frequency - rate * std::round(frequency / rate));
}

SineFit fit_sine(std::span<const double> times, std::span<const double> values, double frequency,
                 const SineFitOptions& options) {
  const Samples samples = usable(times, values, options.rate);
  refuse(samples, frequency, options);
  const Solved solved = solve(samples, frequency, options);
  SineFit fit;
  fit.frequency = solved.frequency;
  fit.centre = samples.centre;
  fit.span = samples.span;
  fit.samples = samples.time.size();
  for (int k = 0; k < options.harmonics; ++k) fit.line.emplace_back(solved.b[2 * k], -solved.b[2 * k + 1]);
  for (int p = 0; p <= options.polynomial; ++p) fit.polynomial.push_back(solved.b[2 * options.harmonics + p]);
  find_noise(samples, solved, options, fit);
  fit.covariance = covariance_of(solved.x, fit.noise_variance);
  if (!options.fit_frequency) return fit;
  const std::size_t last = fit.covariance.rows - 1;
  for (std::size_t i = 0; i <= last; ++i) {
    fit.covariance(i, last) *= 2.0 / samples.span;  // from cycles over half of the span to Hz
    fit.covariance(last, i) *= 2.0 / samples.span;
  }
  fit.frequency_sd = std::sqrt(fit.covariance(last, last));
  return fit;
}

double strongest_frequency(std::span<const double> values, double rate) {
  double mean = 0.0, count = 0.0;
  for (const double v : values) {
    if (std::isnan(v)) continue;
    if (!std::isfinite(v)) throw Error(Error::Kind::bad_data, "a sample is not finite");
    mean += v;
    ++count;
  }
  if (count < 8.0) throw Error(Error::Kind::bad_data, "fewer than 8 samples: no line can be looked for");
  mean /= count;
  std::size_t padded = 1;
  while (padded < 2 * values.size()) padded *= 2;
  std::vector<double> signal(padded, 0.0);
  double greatest = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double u = (static_cast<double>(i) + 0.5) / static_cast<double>(values.size());
    if (!std::isnan(values[i])) signal[i] = (values[i] - mean) * std::pow(std::sin(pi * u), 2);
    greatest = std::max(greatest, std::abs(signal[i]));
  }
  if (!(greatest > 1e-14 * std::abs(mean)) || greatest == 0.0)
    throw Error(Error::Kind::bad_data, "the signal does not move: there is no line in it");
  std::vector<std::complex<double>> spectrum;
  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  fft.fwd(spectrum, signal);
  // A Hann window leaves drift in the first two bins of the record.
  std::size_t best = 2 * padded / values.size();
  for (std::size_t k = best; k + 1 < spectrum.size(); ++k)
    if (std::norm(spectrum[k]) > std::norm(spectrum[best])) best = k;
  const auto level = [&](std::size_t k) { return std::log(std::abs(spectrum[k]) + 1e-300); };
  double shift = 0.0;
  if (best > 0 && best + 1 < spectrum.size()) {
    const double left = level(best - 1), here = level(best), right = level(best + 1);
    const double bend = left - 2.0 * here + right;
    if (bend < 0.0) shift = std::clamp(0.5 * (left - right) / bend, -0.5, 0.5);
  }
  return (static_cast<double>(best) + shift) * rate / static_cast<double>(padded);
}

}  // namespace tumble
