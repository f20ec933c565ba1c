#include "tumble/reduce/vibration/scale.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/reduce/accelerometer/output.hpp"
#include "tumble/units/error.hpp"

namespace tumble::vibration {
namespace {

struct Entry {
  std::string unit, scale;
};

std::string trimmed(std::string text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

/// "S1: 2 V/g, S2: 3 V/g" taken apart; a text without colon is one entry for all units.
std::vector<Entry> entries_of(const Settings& settings) {
  std::vector<Entry> entries;
  if (!settings.has("scale_factor")) return entries;
  std::string text = settings.word("scale_factor");
  while (!trimmed(text).empty()) {
    const auto comma = text.find(',');
    const std::string part = trimmed(text.substr(0, comma));
    const auto colon = part.find(':');
    if (colon == std::string::npos)
      entries.push_back({"", part});
    else
      entries.push_back({trimmed(part.substr(0, colon)), trimmed(part.substr(colon + 1))});
    text = comma == std::string::npos ? "" : text.substr(comma + 1);
  }
  return entries;
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
  std::vector<std::string> seen, twice;
  for (const auto& entry : entries_of(settings)) {
    if (std::ranges::find(seen, entry.unit) != seen.end()) twice.push_back(entry.unit);
    seen.push_back(entry.unit);
  }
  return twice;
}

std::optional<double> given_scale(const Settings& settings, const UnitUnderTest& unit, const Channel& channel) {
  const auto entries = entries_of(settings);
  auto found = std::ranges::find(entries, unit.name, &Entry::unit);
  if (found == entries.end()) found = std::ranges::find(entries, "", &Entry::unit);
  if (found == entries.end()) return {};
  const Reading reading = reading_of(channel);
  if (reading == Reading::force || reading == Reading::velocity) return {};
  const double scale = parse_si(found->scale, accelerometer::output_of(channel).scale_factor);
  if (!(std::abs(scale) > 0.0) || !std::isfinite(scale))
    throw Error(Error::Kind::bad_input, "[settings] scale_factor must be finite and not zero");
  return scale;
}

std::optional<RestScale> scale_at_rest(const std::vector<const Series*>& at_rest, double bias_sd) {
  double with = 0.0, squares = 0.0, sum = 0.0;
  for (const Series* series : at_rest) {
    if (!std::isfinite(series->rest) || std::abs(series->rest) < si(0.2, "g")) continue;
    const Mean mean = mean_of(*series, 0.0);
    if (mean.windows == 0) continue;
    with += series->rest * mean.value;
    squares += series->rest * series->rest;
    sum += series->rest;
  }
  if (squares == 0.0 || with == 0.0) return {};
  // Even where bias cancels between both orientations, misalignment and level leave parts in ten thousand.
  return RestScale{with / squares, std::hypot(bias_sd * std::abs(sum) / squares, 1e-4)};
}

}  // namespace tumble::vibration
