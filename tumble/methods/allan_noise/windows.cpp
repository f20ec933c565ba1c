#include "tumble/methods/allan_noise/windows.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/language/say.hpp"
#include "tumble/methods/allan_noise/words.hpp"
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
           {"p", std::max(stability.chance, least_shown_p)},
           {"comparisons", stability.tests}},
          channel.label};
}

void add_window_curves(const ChannelNoise& channel, std::vector<Curve>& curves) {
  const DynamicStability& stability = *channel.windows;
  const std::size_t stride = (stability.whole.size() + most_curves - 1) / most_curves;
  for (std::size_t i = 0; i < stability.whole.size(); i += stride) {
    const double whole = stability.whole[i].deviation;
    Curve curve{.name = fmt::format("{} at {}", channel.label, say_seconds(stability.whole[i].tau)),
                .figure = "deviation along the record " + channel.label,
                .x = {"time", Unit::parse("s")},
                .y = {"deviation over that of the record", Unit()},
                .band = fmt::format("{:g} % confidence", 100.0 * channel.confidence)};
    for (const auto& window : stability.windows) {
      const DeviationPoint& point = window.points[i];
      if (point.count > 0 && whole > 0.0)
        add_point(curve, time_of(channel, window.first + window.size / 2), point.deviation / whole, point.lower / whole,
                  point.upper / whole);
    }
    if (!curve.x.values.empty()) curves.push_back(std::move(curve));
  }
}

/// The deviation of a channel in a window at one averaging time.
struct WindowPoint {
  const ChannelNoise& channel;
  const StabilityWindow& window;
  const DeviationPoint& point;

  std::string unit() const { return rate_unit(channel.kind); }
  std::string text(double value) const { return fmt::format("{:.4g}", Unit::parse(unit()).difference_from_si(value)); }
};

Table windows_table(const std::vector<const ChannelNoise*>& channels) {
  std::vector<WindowPoint> points;
  for (const auto* channel : channels)
    for (std::size_t i = 0; i < channel->windows->whole.size(); ++i)
      for (const auto& window : channel->windows->windows)
        if (window.points[i].count > 0) points.push_back({*channel, window, window.points[i]});
  const auto limits = [](const WindowPoint& p) { return p.text(p.point.lower) + " to " + p.text(p.point.upper); };
  return tabulate("windows", "deviation along the record", points,
                  {{"channel", [](const WindowPoint& p) { return p.channel.label; }},
                   {"averaging time", "s", [](const WindowPoint& p) { return p.point.tau; }},
                   {"from", "s", [](const WindowPoint& p) { return time_of(p.channel, p.window.first); }},
                   {"to", "s", [](const WindowPoint& p) { return time_of(p.channel, p.window.first + p.window.size); }},
                   {"deviation", [](const WindowPoint& p) { return p.text(p.point.deviation); }},
                   {"limits", limits},
                   {"unit", &WindowPoint::unit},
                   {"degrees of freedom", [](const WindowPoint& p) { return std::round(10.0 * p.point.edf) / 10.0; }}});
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
  std::vector<const ChannelNoise*> described;
  for (const auto& channel : channels) {
    if (!channel.windows || !channel.failure.empty()) continue;
    add_window_curves(channel, estimate.curves);
    described.push_back(&channel);
  }
  add_unless_empty(estimate.tables, windows_table(described));
}

}  // namespace tumble::allan_noise
