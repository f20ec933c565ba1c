#include <algorithm>
#include <cmath>
#include <vector>

#include "tumble/methods/sine_vibration/describe.hpp"
#include "tumble/reduce/rig_effects.hpp"
#include "tumble/rigs/error_names.hpp"

namespace tumble::sine_vibration {

void report_rests(const Evidence& evidence, const vibration::Data& data, const Measured& measured, Estimate& estimate) {
  const double level_sd = measured.reference ? evidence.plan.settings.number("reference_gain_sd")
                                             : rig_sd(evidence.plan, error_names::shake_amplitude).value_or(0.0);
  const std::size_t units = data.units.size();
  std::vector<double> log_gain(units, std::nan("")), uncertainty(units, level_sd);
  for (std::size_t u = 0; u < units; ++u) {
    const auto lowest = std::ranges::find(measured.points, u, &Point::unit);  // points are by unit, then by frequency
    if (lowest != measured.points.end()) {
      log_gain[u] = std::log(lowest->gain);
      uncertainty[u] = std::hypot(level_sd, std::sqrt(lowest->line.log_variance));
    }
  }
  vibration::report_departures(data, log_gain, uncertainty, estimate);
}

}  // namespace tumble::sine_vibration
