#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tumble/methods/sine_vibration/describe.hpp"
#include "tumble/reduce/rig_effects.hpp"
#include "tumble/rigs/error_names.hpp"

namespace tumble::sine_vibration {
namespace {

/// The names of the parameters that rest on the scale factor of one unit: its own, and those that compare units.
std::vector<std::string> resting_on(const vibration::UnitUnderTest& unit, bool first, const Estimate& estimate) {
  std::vector<std::string> names;
  for (const Parameter& p : estimate.parameters) {
    const bool compares =
        p.name == "gain_spread" || (first && (p.name.find(".gain_ratio") != std::string::npos ||
                                              p.name.find(".rectification_difference") != std::string::npos));
    if (compares || p.name.starts_with(unit.prefix)) names.push_back(p.name);
  }
  return names;
}

}  // namespace

void report_rests(const Evidence& evidence, const vibration::Data& data, const Measured& measured, Estimate& estimate) {
  const double level_sd = measured.reference ? evidence.plan.settings.number("reference_gain_sd")
                                             : rig_sd(evidence.plan, error_names::shake_amplitude).value_or(0.0);
  const std::size_t units = data.units.size();
  std::vector<double> log_gain(units, std::nan("")), uncertainty(units, level_sd);
  std::vector<std::vector<std::string>> parameters;
  for (std::size_t u = 0; u < units; ++u) {
    const auto lowest = std::ranges::find(measured.points, u, &Point::unit);  // points are by unit, then by frequency
    if (lowest != measured.points.end()) {
      log_gain[u] = std::log(lowest->gain);
      uncertainty[u] = std::hypot(level_sd, std::sqrt(lowest->line.log_variance));
    }
    parameters.push_back(resting_on(data.units[u], u == 0, estimate));
  }
  vibration::report_departures(data, log_gain, uncertainty, parameters, estimate.findings);
}

}  // namespace tumble::sine_vibration
