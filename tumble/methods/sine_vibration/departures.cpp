#include <algorithm>
#include <cmath>
#include <vector>

#include "tumble/methods/sine_vibration/describe.hpp"
#include "tumble/reduce/rig_effects.hpp"
#include "tumble/rigs/error_names.hpp"

namespace tumble::sine_vibration {
namespace {

constexpr double levels_apart_sd = 3.0;  ///< [sd] of reference and plan: p = 0.3 %

}  // namespace

void compare_levels(const Evidence& evidence, const vibration::Data& data, const Measured& measured,
                    Findings& findings) {
  const double amplitude_sd = rig_sd(evidence.plan, error_names::shake_amplitude).value_or(0.0);
  if (!measured.reference || !(amplitude_sd > 0.0)) return;
  if (std::ranges::find(findings, "level_differs_from_plan", &Finding::code) != findings.end()) return;
  double difference = 0.0, planned = 0.0, shown = 0.0, tones = 0.0;
  for (const Point& point : measured.points) {
    const double plan = data.series[point.series].shake.amplitude;
    if (std::isnan(point.distortion) || !(plan > 0.0)) continue;  // without a line of the reference
    difference += std::log(point.level / plan);
    planned += plan;
    shown += point.level;
    ++tones;
  }
  const double sd = std::hypot(amplitude_sd, evidence.plan.settings.number("reference_gain_sd"));
  if (tones == 0.0 || std::abs(difference / tones) < levels_apart_sd * sd) return;
  findings.push_back({Finding::Severity::warning,
                      "level_differs_from_plan",
                      {{"planned", planned / tones, "g"}, {"measured", shown / tones, "g"}}});
}

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
