#include "tumble/methods/allan_noise/windows.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tumble/language/say.hpp"
#include "tumble/units/error.hpp"

namespace tumble::allan_noise {
namespace {

constexpr std::size_t most_curves = 6;  ///< averaging times drawn in a figure

double time_of(const ChannelNoise& channel, std::size_t sample) {
  return channel.begin + static_cast<double>(sample) / channel.rate;
}

Finding changed(const ChannelNoise& channel) {
  const DynamicStability& stability = *channel.windows;
  const StabilityWindow& window = stability.windows[stability.worst_window];
  return {Finding::Severity::warning,
          "deviation_changes_along_record",
          {{"from", time_of(channel, window.first), "s"},
           {"to", time_of(channel, window.first + window.size), "s"},
           {"tau", stability.whole[stability.worst_factor].tau, "s"},
           {"ratio", std::sqrt(stability.worst_ratio)},
           {"p", std::max(stability.chance, 1e-6)},
           {"comparisons", stability.tests}},
          channel.label};
}

void add_window_curves(const ChannelNoise& channel, std::vector<Curve>& curves) {
  const DynamicStability& stability = *channel.windows;
  const std::size_t stride = (stability.whole.size() + most_curves - 1) / most_curves;
  for (std::size_t i = 0; i < stability.whole.size(); i += stride) {
    const double whole = stability.whole[i].deviation;
    Curve curve;
    curve.name = fmt::format("{} at {}", channel.label, say_seconds(stability.whole[i].tau));
    curve.figure = "deviation along the record " + channel.label;
    curve.x = {"time", Unit::parse("s"), {}};
    curve.y = {"deviation over that of the record", Unit(), {}};
    curve.band = fmt::format("{:g} % confidence", 100.0 * channel.confidence);
    for (const auto& window : stability.windows) {
      const DeviationPoint& point = window.points[i];
      if (point.count == 0 || !(whole > 0.0)) continue;
      curve.x.values.push_back(time_of(channel, window.first + window.size / 2));
      curve.y.values.push_back(point.deviation / whole);
      curve.lower.push_back(point.lower / whole);
      curve.upper.push_back(point.upper / whole);
    }
    if (!curve.x.values.empty()) curves.push_back(std::move(curve));
  }
}

void add_window_rows(const ChannelNoise& channel, Table& table) {
  const DynamicStability& stability = *channel.windows;
  const Unit unit = Unit::parse(rate_unit(channel.kind));
  for (std::size_t i = 0; i < stability.whole.size(); ++i) {
    for (const auto& window : stability.windows) {
      const DeviationPoint& point = window.points[i];
      if (point.count == 0) continue;
      const auto text = [&](double value) { return fmt::format("{:.4g}", unit.difference_from_si(value)); };
      table.rows.push_back({channel.label, point.tau, time_of(channel, window.first),
                            time_of(channel, window.first + window.size), text(point.deviation),
                            text(point.lower) + " to " + text(point.upper), unit.text(),
                            std::round(10.0 * point.edf) / 10.0});
    }
  }
}

}  // namespace

void add_windows(const EvenSignal& signal, const Settings& settings, ChannelNoise& result) {
  const int windows = settings.integer("windows");
  if (windows == 0) return;
  try {
    result.windows = dynamic_allan(signal.values, signal.rate, static_cast<std::size_t>(windows), result.confidence);
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_data) throw;
    result.findings.push_back(
        {Finding::Severity::warning, "no_deviation_along_record", {{"reason", reason_of(error)}}, result.label});
    return;
  }
  if (result.windows->chance < settings.number("significance")) result.findings.push_back(changed(result));
}

void describe_windows(const std::vector<ChannelNoise>& channels, Estimate& estimate) {
  Table table{"windows",
              "deviation along the record",
              {{"channel", Unit()},
               {"averaging time", Unit::parse("s")},
               {"from", Unit::parse("s")},
               {"to", Unit::parse("s")},
               {"deviation", Unit()},
               {"limits", Unit()},
               {"unit", Unit()},
               {"degrees of freedom", Unit()}},
              {}};
  for (const auto& channel : channels) {
    if (!channel.windows || !channel.failure.empty()) continue;
    add_window_curves(channel, estimate.curves);
    add_window_rows(channel, table);
  }
  if (!table.rows.empty()) estimate.tables.push_back(std::move(table));
}

}  // namespace tumble::allan_noise
