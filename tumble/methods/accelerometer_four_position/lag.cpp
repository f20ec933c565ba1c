#include "tumble/methods/accelerometer_four_position/lag.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/lack_of_fit.hpp"
#include "tumble/math/square.hpp"
#include "tumble/methods/accelerometer_four_position/halves.hpp"

namespace tumble::accelerometer_four_position {
namespace {

/// The thermometer's readings behind a lag, at the same samples. The unit has them at power-on.
std::vector<double> behind(const Channel& thermometer, const std::vector<double>& power_ons, double lag) {
  std::vector<double> out(thermometer.values.size(), std::nan(""));
  double late = std::nan(""), last = 0.0;
  auto next = power_ons.begin();
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double time = thermometer.time(i), reading = thermometer.values[i];
    if (!std::isfinite(reading)) continue;
    bool begins = std::isnan(late);
    for (; next != power_ons.end() && *next <= time; ++next) begins = true;
    late = begins ? reading : late + (1.0 - std::exp(-(time - last) / lag)) * (reading - late);
    last = time;
    out[i] = late;
  }
  return out;
}

/// Of all positions, behind one lag [s]; 0: as read.
std::vector<Halves> temperatures(const Bench& bench, double lag) {
  std::vector<Halves> out(bench.positions.size(), {std::nan(""), 0.0});
  const auto& stretches = bench.evidence.test.stretches;
  for (std::size_t r = 0; r < bench.measured->recordings.size(); ++r) {
    const Channel* thermometer = channel_for(*bench.measured, bench.measured->recordings[r], "temperature");
    std::vector<double> power_ons;
    for (const auto& stretch : stretches)
      if (stretch.recording == r) power_ons.push_back(stretch.power_on);
    std::ranges::sort(power_ons);
    power_ons.erase(std::ranges::unique(power_ons).begin(), power_ons.end());
    if (thermometer == nullptr) continue;
    const auto values = lag > 0.0 ? behind(*thermometer, power_ons, lag)
                                  : std::vector<double>(thermometer->values.begin(), thermometer->values.end());
    for (std::size_t i = 0; i < out.size(); ++i)
      if (const Stretch& stretch = stretches[bench.positions[i].stretch]; stretch.recording == r)
        out[i] = halves_of(*thermometer, values, stretch);
  }
  return out;
}

/// Standard uncertainty of a quantity by its polynomial, and its slope [1/K].
struct AtTemperature {
  double sd = 0.0, slope = 0.0;
};

AtTemperature at_temperature(const Reduced& reduced, Quantity quantity, double temperature) {
  const Polynomial& p = reduced.polynomial[quantity];
  const auto here = powers(temperature, p.count), above = powers(temperature + 0.5, p.count),
             below = powers(temperature - 0.5, p.count);
  std::vector<double> weights(reduced.parameters.size(), 0.0);
  AtTemperature out;
  for (std::size_t j = 0; j < p.count; ++j) {
    weights[p.first + j] = here[j];
    out.slope += (above[j] - below[j]) * reduced.parameters[p.first + j];
  }
  out.sd = std::sqrt(std::max(0.0, quadratic_form(weights, reduced.covariance)));
  return out;
}

/// dE/dT of each position [m/s^2/K] by the polynomials.
std::vector<double> sensitivities(const Bench& bench, const Reduced& reduced) {
  std::vector<double> out;
  for (const Position& position : bench.positions) {
    const double force = bench.rows.segments[position.stretch].felt.specific_force.x;
    out.push_back(at_temperature(reduced, bias, position.temperature).slope -
                  force * at_temperature(reduced, scale_factor_error, position.temperature).slope);
  }
  return out;
}

bool all_known(const std::vector<Halves>& halves) {
  return std::ranges::all_of(halves, [](const Halves& h) { return std::isfinite(h.mean); });
}

/// How much of this lag the changes within the positions show, beside a drift that all share.
LackOfFit shown_by(const std::vector<ChangeWithin>& changes, const std::vector<double>& sensitivities,
                   const std::vector<Halves>& read, const std::vector<Halves>& late) {
  const std::size_t n = changes.size();
  Matrix together(n, 1), more(n, 1);
  std::vector<double> values, variances;
  for (std::size_t i = 0; i < n; ++i) {
    together(i, 0) = 1.0;
    more(i, 0) = sensitivities[i] * (late[i].change - read[i].change);
    values.push_back(changes[i].value - sensitivities[i] * read[i].change);
    variances.push_back(square(changes[i].sd));
  }
  return lack_of_fit(together, more, values, diagonal(variances));
}

}  // namespace

std::optional<LateUnit> late_unit(const Bench& bench, const Reduced& reduced, const std::vector<ChangeWithin>& changes,
                                  double lag) {
  constexpr double rare = 1e-5, excluded = 3.0, times_sd = 2.0;
  if (!bench.measured_temperature || bench.measured == nullptr || bench.group_temperature.size() < 2) return {};
  const auto read = temperatures(bench, 0.0), late = temperatures(bench, lag);
  if (!all_known(read) || !all_known(late)) return {};
  const auto fit = shown_by(changes, sensitivities(bench, reduced), read, late);
  const bool shown = fit.probability < rare && fit.coefficient > 0.0;
  if (!shown && fit.freedom > 0.0 && fit.coefficient + excluded * fit.sd < 1.0) return {};
  std::optional<LateUnit> worst;
  double most = times_sd;
  for (std::size_t i = 0; i < read.size(); ++i)
    for (const Quantity quantity : {bias, scale_factor_error}) {
      const auto [sd, slope] = at_temperature(reduced, quantity, read[i].mean);
      const double behind = late[i].mean - read[i].mean, shift = slope * behind;
      if (!(std::abs(shift) > most * sd)) continue;
      most = std::abs(shift) / sd;
      worst = {shown, behind, bench.positions[i].label, quantity, shift};
    }
  return worst;
}

}  // namespace tumble::accelerometer_four_position
