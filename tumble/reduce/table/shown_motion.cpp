#include "tumble/reduce/table/shown_motion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tumble/math/regression/sine_fit.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::table {
namespace {

constexpr double least_resultant = 0.9;        ///< of residuals of 26 deg rms
constexpr double explained_by_readings = 6.0;  ///< standard deviations between the halves of a segment

std::optional<Phase> phase_of_rate(double rate, const Angles& angles) {
  std::complex<double> sum;
  double times = 0.0;
  for (std::size_t i = 0; i < angles.times.size(); ++i) {
    sum += std::polar(1.0, angles.values[i] - rate * angles.times[i]);
    times += angles.times[i];
  }
  const auto count = static_cast<double>(angles.times.size());
  if (angles.times.empty() || std::abs(sum) < least_resultant * count) return {};
  return Phase{std::arg(sum), times / count, {}};
}

std::optional<SineFit> fitted(const Angles& angles, double frequency, bool free) try {
  return fit_sine(angles.times, unwrapped(angles.values), frequency, {.polynomial = 0, .fit_frequency = free});
} catch (const Error& error) {
  if (error.kind != Error::Kind::bad_data) throw;
  return {};
}

std::optional<Phase> phase_of_sine(const Motion& motion, const Angles& angles) {
  const auto fit = fitted(angles, motion.frequency, false);
  if (!fit) return {};
  constexpr std::complex<double> j(0.0, 1.0);
  const auto to_begin = std::polar(1.0, -two_pi * motion.frequency * fit->centre);
  return Phase{fit->polynomial[0], 0.0, j * fit->line[0] * to_begin / motion.amplitude};
}

/// The slope of `residuals` over the times of the same indices, begin <= i < end.
RateDeparture slope_of(const Angles& angles, const std::vector<double>& residuals, std::size_t begin, std::size_t end) {
  const auto count = static_cast<double>(end - begin);
  double mean_t = 0.0, mean_x = 0.0, tt = 0.0, tx = 0.0, xx = 0.0;
  for (std::size_t i = begin; i < end; ++i) {
    mean_t += angles.times[i] / count;
    mean_x += residuals[i] / count;
  }
  for (std::size_t i = begin; i < end; ++i) {
    const double t = angles.times[i] - mean_t, x = residuals[i] - mean_x;
    tt += t * t;
    tx += t * x;
    xx += x * x;
  }
  const double slope = tx / tt;
  return {slope, std::sqrt(std::max(xx - slope * tx, 0.0) / (count - 2.0) / tt)};
}

/// The frequency of the highest line of the readings [Hz]; nothing where they do not move.
std::optional<double> strongest_of(const Angles& angles) try {
  const double span = angles.times.back() - angles.times.front();
  return strongest_frequency(unwrapped(angles.values), static_cast<double>(angles.times.size() - 1) / span);
} catch (const Error& error) {
  if (error.kind != Error::Kind::bad_data) throw;
  return {};
}

}  // namespace

std::vector<double> unwrapped(std::vector<double> values) {
  for (std::size_t i = 1; i < values.size(); ++i)
    values[i] = values[i - 1] + std::remainder(values[i] - values[i - 1], two_pi);
  return values;
}

std::optional<Phase> phase_of(const Motion& motion, const Angles& angles) {
  return motion.kind == Motion::Kind::rate ? phase_of_rate(motion.value, angles) : phase_of_sine(motion, angles);
}

std::optional<RateDeparture> departure_of_rate(double rate, const Angles& angles, double tolerance) {
  constexpr std::size_t least = 10;
  const std::size_t count = angles.times.size();
  if (count < least) return {};
  std::vector<double> residuals;
  for (std::size_t i = 0; i < count; ++i) residuals.push_back(angles.values[i] - rate * angles.times[i]);
  residuals = unwrapped(std::move(residuals));
  const auto all = slope_of(angles, residuals, 0, count), first = slope_of(angles, residuals, 0, count / 2),
             second = slope_of(angles, residuals, count / 2, count);
  // An encoder that resolves little shows one step in an hour: such a step is a slope of up to 1.5 step/time.
  double step = 0.0;
  for (std::size_t i = 1; i < count; ++i)
    step =
        std::max(step, std::abs(residuals[i] - residuals[i - 1] - all.rate * (angles.times[i] - angles.times[i - 1])));
  const double apart = std::abs(first.rate - second.rate);
  return RateDeparture{all.rate, std::max(all.sd, 0.5 * step / (angles.times.back() - angles.times.front())),
                       apart <= tolerance + explained_by_readings * std::hypot(first.sd, second.sd)};
}

std::optional<ShownOscillation> oscillation_of(const Motion& motion, const Angles& angles) {
  constexpr std::size_t least = 10;
  if (angles.times.size() < least || !fitted(angles, motion.frequency, false)) return {};
  auto fit = fitted(angles, motion.frequency, true);
  if (const auto strongest = fit ? std::nullopt : strongest_of(angles)) fit = fitted(angles, *strongest, true);
  if (!fit) return {};
  const double amplitude = std::abs(fit->line[0] / motion.amplitude);
  return ShownOscillation{fit->frequency, fit->frequency_sd, amplitude,
                          amplitude * std::sqrt(fit->log_gain_variance())};
}

}  // namespace tumble::table
