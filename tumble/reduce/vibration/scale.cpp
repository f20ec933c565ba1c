#include "tumble/reduce/vibration/scale.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/reduce/accelerometer/output.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::vibration {
namespace {

struct Entry {
  std::string unit, scale;
};

/// The entries of "S1: 2 V/g, S2: 3 V/g"; a text without colon is one entry for all units.
std::vector<Entry> entries_of(const Settings& settings) {
  std::vector<Entry> entries;
  if (!settings.has("scale_factor")) return entries;
  auto items = list_items(settings.word("scale_factor"));
  if (items.back().empty()) items.pop_back();
  for (const std::string& item : items) {
    const auto named = key_and_value(item, ':');
    if (named)
      entries.push_back({std::string(trimmed(named->first)), std::string(trimmed(named->second))});
    else
      entries.push_back({"", item});
  }
  return entries;
}

struct RestScale {
  double scale = 0.0;
  double relative_sd = 0.0;  ///< [1]
};

/// K_1 by least squares through zero over the segments at rest, whose `force` still holds values of the channel, per
/// second where it counts. `relative_sd`: of a bias of `bias_sd` [m/s^2] common to all of them. None: no such segment
/// with 0.2 g along the input axis.
std::optional<RestScale> scale_at_rest(const std::vector<const Series*>& at_rest, double bias_sd) {
  double with = 0.0, squares = 0.0, sum = 0.0;
  for (const Series* series : at_rest) {
    if (!std::isfinite(series->rest) || std::abs(series->rest) < si(along_input, "g")) continue;
    const Mean mean = mean_of(*series, 0.0);
    if (mean.windows == 0) continue;
    with += series->rest * mean.value;
    squares += series->rest * series->rest;
    sum += series->rest;
  }
  if (squares == 0.0 || with == 0.0) return {};
  // Even where bias cancels between both orientations, misalignment and level cause parts in ten thousand.
  return RestScale{with / squares, std::hypot(bias_sd * std::abs(sum) / squares, 1e-4)};
}

}  // namespace

Reading reading_of(const Channel& channel) {
  if (channel.unit.dimension() == Unit::parse("m/s").dimension()) return Reading::velocity;
  const auto output = accelerometer::output_of(channel);
  if (output.pulses) return Reading::pulses;
  return output.scale_factor.dimension() == Dimension{} ? Reading::force : Reading::electric;
}

std::vector<std::string> named_in_scale(const Settings& settings) {
  std::vector<std::string> names;
  for (const auto& entry : entries_of(settings))
    if (!entry.unit.empty()) names.push_back(entry.unit);
  return names;
}

std::vector<std::string> twice_in_scale(const Settings& settings) {
  std::vector<std::string> names, twice;
  for (const auto& entry : entries_of(settings)) {
    if (std::ranges::find(names, entry.unit) != names.end()) twice.push_back(entry.unit);
    names.push_back(entry.unit);
  }
  return twice;
}

std::optional<double> given_scale(const Settings& settings, const UnitUnderTest& unit, const Channel& channel) {
  const auto entries = entries_of(settings);
  auto entry = std::ranges::find(entries, unit.name, &Entry::unit);
  if (entry == entries.end()) entry = std::ranges::find(entries, "", &Entry::unit);
  if (entry == entries.end()) return {};
  const Reading reading = reading_of(channel);
  if (reading == Reading::force || reading == Reading::velocity) return {};
  const double scale = parse_si(entry->scale, accelerometer::output_of(channel).scale_factor);
  if (!(std::abs(scale) > 0.0) || !std::isfinite(scale))
    throw Error(Error::Kind::bad_input, "[settings] scale_factor must be finite and not zero");
  return scale;
}

void set_scale(const Settings& settings, const Channel& channel, std::size_t unit, Data& data) {
  UnitUnderTest& u = data.units[unit];
  const Reading reading = reading_of(channel);
  u.scale_relative_sd = settings.number("scale_factor_sd");
  double scale = 1.0;
  if (reading == Reading::pulses || reading == Reading::electric) {
    if (const auto given = given_scale(settings, u, channel)) {
      scale = *given;
    } else {
      std::vector<const Series*> rests;
      for (const auto& series : data.series)
        if (series.unit == unit && series.at_rest()) rests.push_back(&series);
      const auto at_rest = scale_at_rest(rests, settings.number("bias_sd"));
      if (!at_rest)
        throw Error(Error::Kind::bad_input,
                    say("'{}' is in {} and its scale factor is not known: set [settings] scale_factor, or add "
                        "segments at rest with the input axis along gravity",
                        channel.name, Name{channel.unit.text()}));
      scale = at_rest->scale;
      u.scale_relative_sd = at_rest->relative_sd;
      u.scale_from_rest = true;
      data.findings.push_back({Finding::Severity::info,
                               "scale_factor_from_rest",
                               {{"uncertainty", u.scale_relative_sd, "%"}, {"bias", settings.number("bias_sd"), "mg"}},
                               u.channel});
    }
  }
  if (reading == Reading::pulses) u.pulse = 1.0 / std::abs(scale);
  u.force_per_value = 1.0 / scale;
  for (auto& series : data.series)
    if (series.unit == unit)
      for (double& v : series.force) v *= u.force_per_value;
}

}  // namespace tumble::vibration
