#include "tumble/math/regression/sine_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/fourier.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr std::size_t longest_product = 32;  ///< samples whose waves are products: their rounding is less than 1e-14
constexpr double even_within = 1e-9;         ///< [samples] by which even samples may differ
constexpr double last_cycles = 4e-15;        ///< [cycles of the span] of the last step: rounding
constexpr int most_rounds_of_frequency = 20;
constexpr double longest_step_of_frequency = 0.4;  ///< [1/span] within the main lobe
/// Neighbours of the line where its noise is measured [1/span]: up to 0.3 of the frequency, at least 4 and at most 11.
constexpr double neighbours_of_line = 0.3, fewest_neighbours = 4.0, most_neighbours = 11.0;
constexpr double least_wave = 0.05;      ///< [samples] squares of a wave without the columns of the fit
constexpr double fewest_of_noise = 4.0;  ///< waves: with fewer the residual gives the noise
constexpr double least_cycles = 0.9;     ///< in the span, of the line and of half the rate less the line
constexpr double fewest_for_line = 8.0;  ///< samples
constexpr double moves_of_mean = 1e-14;  ///< [1] of the mean: a smaller motion is rounding

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
      throw Error(Error::Kind::bad_data, say("sine fit: sample {} is not finite", i));
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
void waves(const Samples& s, double frequency, std::span<double> cosine, std::span<double> sine) {
  const std::complex<double> turn = std::polar(1.0, two_pi * frequency * s.step);
  std::complex<double> now;
  for (std::size_t i = 0; i < s.time.size(); ++i) {
    const bool next = i % longest_product != 0 && std::abs(s.time[i] - s.time[i - 1] - s.step) < even_within * s.step;
    now = next ? now * turn : std::polar(1.0, std::fmod(frequency * s.time[i], 1.0) * two_pi);
    cosine[i] = now.real();
    sine[i] = now.imag();
  }
}

Matrix design(const Samples& s, double frequency, const SineFitOptions& how) {
  const std::size_t n = s.time.size(), waves_end = 2 * static_cast<std::size_t>(how.harmonics);
  Matrix x(n, waves_end + static_cast<std::size_t>(how.polynomial) + 1, 1.0);
  for (std::size_t k = 0; k < waves_end; k += 2)
    waves(s, 0.5 * static_cast<double>(k + 2) * frequency, column(x, k), column(x, k + 1));
  for (std::size_t p = waves_end + 1; p < x.columns; ++p)
    for (std::size_t i = 0; i < n; ++i) x(i, p) = x(i, p - 1) * (s.time[i] * (2.0 / s.span));
  return x;
}

/// Derivative by the number of cycles over half of the span.
std::vector<double> by_frequency(const Samples& s, const Matrix& x, const std::vector<double>& b,
                                 const SineFitOptions& how) {
  std::vector<double> d(x.rows);
  for (std::size_t k = 0; k < static_cast<std::size_t>(how.harmonics); ++k) {
    const double factor = static_cast<double>(k + 1) * two_pi * (2.0 / s.span);
    for (std::size_t i = 0; i < x.rows; ++i)
      d[i] += factor * s.time[i] * (b[2 * k + 1] * x(i, 2 * k) - b[2 * k] * x(i, 2 * k + 1));
  }
  return d;
}

struct Solved {
  HouseholderQr factors;  ///< of the design, with the derivative by frequency last, where it is fitted
  std::vector<double> b, residual;
  double frequency = 0.0;
};

Solved solve(const Samples& s, double start, const SineFitOptions& how) {
  Solved now;
  now.frequency = start;
  for (int round = 0;; ++round) {
    const Matrix x = design(s, now.frequency, how);
    now.factors = householder_qr(x);
    now.b = solve(now.factors, s.value);
    now.residual = difference(s.value, x * now.b);
    if (!how.fit_frequency) return now;
    now.factors = householder_qr(beside(x, as_column(by_frequency(s, x, now.b, how))));
    const double cycles = solve(now.factors, now.residual).back();  // over half of the span
    if (std::abs(cycles) < last_cycles * std::max(1.0, now.frequency * s.span) || round == most_rounds_of_frequency)
      return now;
    now.frequency += std::clamp(cycles, -longest_step_of_frequency, longest_step_of_frequency) * 2.0 / s.span;
    if (std::abs(now.frequency - start) * s.span > 1.0)
      throw Error(Error::Kind::bad_data,
                  say("sine fit: no line near {:.6g} Hz, the search ran away to {:.6g} Hz", start, now.frequency));
  }
}

/// Where projections for the noise may lie: about the (aliased) line, clear of zero, of half of the rate and of lines.
std::vector<double> neighbours(const Samples& s, double frequency, const SineFitOptions& how) {
  const double rate = 1.0 / s.step, bin = 1.0 / s.span, here = aliased_frequency(frequency, rate);
  const double most = std::clamp(neighbours_of_line * here * s.span, fewest_neighbours, most_neighbours);
  std::vector<double> found;
  for (int m = 2; m <= static_cast<int>(most); ++m) {
    for (const double side : {-1.0, 1.0}) {
      const double f = here + side * m * bin;
      bool clear = f > clear_of_line * bin && f < 0.5 * rate - clear_of_line * bin;
      for (int k = 2; clear && k <= how.harmonics; ++k)
        clear = std::abs(f - aliased_frequency(k * frequency, rate)) > clear_of_line * bin;
      if (clear) found.push_back(f);
    }
  }
  return found;
}

void find_noise(const Samples& s, const Solved& solved, const SineFitOptions& how, SineFit& fit) {
  const std::size_t n = solved.factors.packed.rows, p = solved.factors.packed.columns;
  const double squares = dot(solved.residual, solved.residual);
  fit.residual_rms = std::sqrt(squares / static_cast<double>(n));
  fit.degrees_of_freedom = static_cast<double>(n - p);
  fit.noise_variance = squares / fit.degrees_of_freedom;
  const auto places = neighbours(s, solved.frequency, how);
  if (2 * places.size() < 4 || static_cast<double>(2 * places.size()) > 0.5 * fit.degrees_of_freedom) return;
  Matrix q(n, p), pair(n, 2);
  set_block(q, 0, 0, identity(p));
  q = q_product(solved.factors, std::move(q));
  double sum = 0.0, count = 0.0;
  for (const double f : places) {
    waves(s, f, column(pair, 0), column(pair, 1));
    pair -= q * transposed_product(q, pair);
    for (std::size_t c = 0; c < 2; ++c) {
      const auto wave = column(pair, c);
      const double square = dot(wave, wave);
      if (square < least_wave * static_cast<double>(n)) continue;
      const double r = dot(wave, solved.residual);
      sum += r * r / square;
      ++count;
    }
  }
  if (count < fewest_of_noise) return;
  fit.noise_variance = sum / count;
  fit.degrees_of_freedom = count;
}

void refuse(const Samples& s, double frequency, const SineFitOptions& how) {
  const auto parameters = 2 * static_cast<std::size_t>(how.harmonics) + static_cast<std::size_t>(how.polynomial) + 2;
  if (s.time.size() < parameters + 4)
    throw Error(Error::Kind::bad_data,
                say("sine fit: {} samples are too few for {} parameters", s.time.size(), parameters));
  if (!(frequency > 0.0) || !std::isfinite(frequency))
    throw Error(Error::Kind::bad_input, say("sine fit: a frequency of {} Hz", frequency));
  if (frequency * s.span < 1.0)
    throw Error(Error::Kind::bad_data,
                say("sine fit: {:.4g} s hold less than one cycle of {:.6g} Hz", s.span, frequency));
  const double rate = 1.0 / s.step, here = aliased_frequency(frequency, rate);
  if (std::min(here, 0.5 * rate - here) * s.span < least_cycles)
    throw Error(Error::Kind::bad_data,
                say("sine fit: {:.6g} Hz lies within one cycle over {:.4g} s of a multiple of half of the "
                    "sampling rate {:.6g} Hz, where sine and cosine cannot be distinguished",
                    frequency, s.span, rate));
}

Matrix covariance_of(const HouseholderQr& factors, double variance) {
  const Matrix upper = upper_of(factors);
  return variance * gram(transposed(solve_upper(upper, identity(upper.rows))));
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
  const auto polynomial = solved.b.begin() + 2 * static_cast<std::ptrdiff_t>(options.harmonics);
  for (auto b = solved.b.begin(); b != polynomial; b += 2) fit.line.emplace_back(b[0], -b[1]);
  fit.polynomial.assign(polynomial, solved.b.end());
  find_noise(samples, solved, options, fit);
  fit.covariance = covariance_of(solved.factors, fit.noise_variance);
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
  if (count < fewest_for_line) throw Error(Error::Kind::bad_data, "fewer than 8 samples: no line can be looked for");
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
  if (!(greatest > moves_of_mean * std::abs(mean)) || greatest == 0.0)
    throw Error(Error::Kind::bad_data, "the signal does not move: there is no line in it");
  std::vector<std::complex<double>> spectrum;
  real_transform(signal, spectrum);
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
