#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tumble/checks/check.hpp"
#include "tumble/math/extremes.hpp"
#include "tumble/math/median.hpp"

namespace tumble::checks::units {

namespace {

/// [K] below which a temperature in kelvin was meant in degC. Chosen: instruments are tested from -55 degC (218 K) to
/// about 120 degC. Doubled, tests in the cold would be accused.
constexpr double coldest = 120.0;
/// [K] between which all values lie of a temperature in degC that was meant in kelvin: -73 degC to 150 degC, shifted by 273.15 K.
/// Chosen: sensors are tested at 200 degC at most, and a test whose coldest sample is hotter would be accused.
constexpr double coldest_of_kelvin = 473.15, hottest_of_kelvin = 696.3;

bool raw_output(const Unit& unit) {
  static const Dimension raw[] = {Unit::parse("count").dimension(), Unit::parse("V").dimension(),
                                  Unit::parse("A").dimension(), Unit::parse("Hz").dimension(),
                                  Unit::parse("ohm").dimension()};
  return std::find(std::begin(raw), std::end(raw), unit.dimension()) != std::end(raw);
}

/// What the name of a role or channel promises: its first word says the instrument.
struct Promise {
  std::string_view beginning;
  std::vector<QuantityKind> kinds;
  Phrase expected;
};

const std::vector<Promise>& promises() {
  using enum QuantityKind;
  static const std::vector<Promise> all{
      {"gyro", {angular_rate, angle}, Phrase{"rate_or_angle"}},
      {"reference_gyro", {angular_rate, angle}, Phrase{"rate_or_angle"}},
      {"accelerometer", {specific_force, velocity}, Phrase{"force_or_velocity"}},
      {"temperature", {temperature}, Phrase{"temperature"}},
      {"table_angle", {angle}, Phrase{"angle"}},
      {"arm_angle", {angle}, Phrase{"angle"}},
  };
  return all;
}

const Promise* promise_of(std::string_view name) {
  for (const Promise& promise : promises())
    if (name.starts_with(promise.beginning) &&
        (name.size() == promise.beginning.size() || name[promise.beginning.size()] == '.' ||
         name[promise.beginning.size()] == '_'))
      return &promise;
  return nullptr;
}

void look_at_unit(const Channel& channel, std::string_view name, Findings& findings) {
  const Promise* promise = promise_of(name);
  if (promise == nullptr || raw_output(channel.unit)) return;
  if (std::find(promise->kinds.begin(), promise->kinds.end(), kind_of(channel.unit)) != promise->kinds.end()) return;
  findings.push_back({Finding::Severity::warning,
                      channel.unit.dimension() == Dimension{} ? "no_unit" : "unexpected_unit",
                      {{"unit", channel.unit.text()}, {"name", std::string(name)}, {"expected", promise->expected}},
                      channel.name});
}

void look_at_temperature(const Channel& channel, Findings& findings) {
  if (channel.kind != QuantityKind::temperature) return;
  const auto [lowest, highest, present, at_lowest, at_highest] = extremes_of(channel.values);
  if (present == 0) return;
  if (channel.unit.offset() != 0.0 && lowest > coldest_of_kelvin && highest < hottest_of_kelvin)
    findings.push_back({Finding::Severity::warning,
                        "probably_kelvin",
                        {{"lowest", lowest, channel.unit}, {"unit", channel.unit.text()}},
                        channel.name});
  else if (channel.unit.offset() != 0.0 && lowest < 0.0)
    findings.push_back(
        {Finding::Severity::warning, "below_absolute_zero", {{"lowest", lowest, channel.unit}}, channel.name});
  else if (channel.unit.offset() == 0.0 && lowest < coldest && promise_of(channel.name) != nullptr)
    findings.push_back(
        {Finding::Severity::warning, "implausibly_cold", {{"lowest", lowest, channel.unit}}, channel.name});
}

/// The decimal place of which all counts are whole multiples, and by a few of which they change: counts in thousands.
/// Means of counts have as many digits as they were written with, and change by far more of the last one.
void look_at_counts(const Channel& channel, Findings& findings) {
  constexpr double most_steps = 100.0, digits = 1e-6;
  constexpr std::size_t least_changes = 16;
  if (channel.kind != QuantityKind::count) return;
  const auto& x = channel.values;
  const auto whole = [&](double factor) {
    return std::ranges::all_of(x, [&](double value) {
      return std::isnan(value) || std::abs(value * factor - std::round(value * factor)) < digits;
    });
  };
  if (whole(1.0)) return;
  for (const double factor : {10.0, 100.0, 1e3, 1e6}) {
    if (!whole(factor)) continue;
    std::vector<double> changes;
    for (std::size_t i = 1; i < x.size(); ++i)
      if (const double change = std::abs(x[i] - x[i - 1]); !std::isnan(change)) changes.push_back(change);
    if (changes.size() < least_changes || median(std::move(changes)) * factor > most_steps) return;
    findings.push_back({Finding::Severity::warning,
                        "counts_not_whole",
                        {{"step", 1.0 / factor}, {"factor", static_cast<long long>(factor)}},
                        channel.name});
    return;
  }
}

using Triad = std::array<const Channel*, 3>;

/// Channels named accelerometer.x, .y, .z (or _x, _y, _z) behind one beginning, which may be a topic.
std::vector<Triad> accelerometer_triads(const Recording& recording) {
  std::vector<Triad> triads;
  for (const Channel& x : recording.channels) {
    if (!x.name.ends_with("accelerometer.x") && !x.name.ends_with("accelerometer_x")) continue;
    const std::string beginning = x.name.substr(0, x.name.size() - 1);
    const Triad triad{&x, find_channel(recording, beginning + "y"), find_channel(recording, beginning + "z")};
    const bool whole = std::ranges::all_of(triad, [&](const Channel* channel) {
      return channel != nullptr && channel->kind == QuantityKind::specific_force &&
             channel->values.size() == x.values.size();
    });
    if (whole) triads.push_back(triad);
  }
  return triads;
}

/// A triad feels 9.8 m/s^2 in every position. A steady 1.0 m/s^2 is g, as some drivers write it where m/s^2 is stated.
void look_at_gravity(const Triad& triad, Findings& findings) {
  constexpr std::size_t least = 10, most = 1000;
  constexpr double near = 0.1, steady = 0.1;  // m/s^2
  const std::size_t count = triad[0]->values.size(), step = count / most + 1;
  double number = 0.0, sum = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < count; i += step) {
    const double magnitude = std::hypot(triad[0]->values[i], triad[1]->values[i], triad[2]->values[i]);
    if (!std::isfinite(magnitude)) continue;
    number += 1.0;
    sum += magnitude;
    squares += (magnitude - 1.0) * (magnitude - 1.0);
  }
  const double mean = sum / number, variance = squares / number - (mean - 1.0) * (mean - 1.0);
  if (number < least || std::abs(mean - 1.0) > near || variance > steady * steady) return;
  findings.push_back({Finding::Severity::warning,
                      "force_probably_in_g",
                      {{"magnitude", mean, "m/s^2"}, {"unit", triad[0]->unit.text()}},
                      triad[0]->name});
}

Findings run(const Recording& recording, const Plan* plan) {
  Findings findings;
  for (const Triad& triad : accelerometer_triads(recording)) look_at_gravity(triad, findings);
  for (const Channel& channel : recording.channels) {
    std::vector<std::string> names;
    if (plan != nullptr)
      for (const auto& [role, choices] : plan->channels)
        if (std::ranges::find(choices, channel.name, &ChannelChoice::channel) != choices.end()) names.push_back(role);
    if (names.empty()) names.push_back(channel.name);
    for (const auto& name : names) look_at_unit(channel, name, findings);
    look_at_temperature(channel, findings);
    look_at_counts(channel, findings);
  }
  return findings;
}

}  // namespace

extern const Check units{"units",
                         "units that do not fit the purpose of the channel, impossible temperatures, counts that are "
                         "not whole, and g written "
                         "as m/s^2",
                         run};

}  // namespace tumble::checks::units
