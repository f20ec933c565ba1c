#include "tumble/methods/frequency_response/extent.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tumble/math/regression/sine_fit.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::frequency_response {
namespace {

constexpr std::size_t fewest_of_extent = 64, fewest_of_window = 12;  ///< samples
constexpr double no_tone = 0.2;  ///< [1] of the amplitude: what a tone leaves at most
/// [1] of the residual of the middle, and of the amplitude, that a window of the same tone leaves at most: another tone leaves 1.
constexpr double off_residual = 4.0, off_amplitude = 0.25;

/// Residual of a tone that goes on.
std::vector<double> residual_of(const Samples& s, const SineFit& fit) {
  std::vector<double> out;
  for (std::size_t i = 0; i < s.time.size(); ++i) {
    const double t = s.time[i] - fit.centre;
    double shown = fit.polynomial.empty() ? 0.0 : fit.polynomial.front();
    for (std::size_t k = 0; k < fit.line.size(); ++k)
      shown += (fit.line[k] * std::polar(1.0, two_pi * std::fmod(static_cast<double>(k + 1) * fit.frequency * t, 1.0)))
                   .real();
    out.push_back(s.value[i] - shown);
  }
  return out;
}

/// Root mean square of the samples from `first` to before `last` that are there.
double rms_between(const std::vector<double>& values, std::size_t first, std::size_t last) {
  double squares = 0.0, n = 0.0;
  for (std::size_t i = first; i < last; ++i)
    if (!std::isnan(values[i])) squares += values[i] * values[i], ++n;
  return n > 0.0 ? std::sqrt(squares / n) : 0.0;
}

}  // namespace

Extent extent_of(const Samples& reference, double frequency) {
  const std::size_t n = reference.time.size(), quarter = n / 4;
  Extent all{reference.time.front(), reference.time.back(), false};
  if (n < fewest_of_extent) return all;
  const auto part = [&](const std::vector<double>& values) {
    return std::vector<double>(values.begin() + static_cast<std::ptrdiff_t>(quarter),
                               values.end() - static_cast<std::ptrdiff_t>(quarter));
  };
  const std::vector<double> times = part(reference.time), values = part(reference.value);
  SineFit fit;
  try {
    fit = fit_sine(times, values, frequency, {.fit_frequency = true, .rate = reference.rate});
  } catch (const Error&) {
    return all;
  }
  const double amplitude = std::abs(fit.line.front());
  if (fit.residual_rms > no_tone * amplitude) return all;
  const std::vector<double> residual = residual_of(reference, fit);
  const auto window = std::max(fewest_of_window, static_cast<std::size_t>(reference.rate / fit.frequency));
  const double off = std::max(off_residual * fit.residual_rms, off_amplitude * amplitude);
  std::size_t last = n - quarter, first = quarter;
  while (last + window <= n && rms_between(residual, last, last + window) < off) last += window;
  while (first >= window && rms_between(residual, first - window, first) < off) first -= window;
  // what remains of a window that is not full, and one window of margin where the tone ends
  if (last + window <= n) all = {all.begin, reference.time[last - std::min(last, window)], true};
  if (first >= window) all = {reference.time[std::min(n - 1, first + window)], all.end, true};
  return all;
}

}  // namespace tumble::frequency_response
