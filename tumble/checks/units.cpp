#include <algorithm>

#include "tumble/checks/check.hpp"
#include "tumble/math/extremes.hpp"

namespace tumble::checks {

namespace {

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
  const double lowest = extremes_of(channel.values).lowest;
  if (channel.unit.offset() != 0.0 && lowest < 0.0)
    findings.push_back(
        {Finding::Severity::warning, "below_absolute_zero", {{"lowest", lowest, channel.unit}}, channel.name});
  else if (channel.unit.offset() == 0.0 && lowest < 120.0 && promise_of(channel.name) != nullptr)
    findings.push_back(
        {Finding::Severity::warning, "implausibly_cold", {{"lowest", lowest, channel.unit}}, channel.name});
}

Findings run(const Recording& recording, const Plan* plan) {
  Findings findings;
  for (const Channel& channel : recording.channels) {
    std::vector<std::string> names;
    if (plan != nullptr)
      for (const auto& [role, choices] : plan->channels)
        if (std::ranges::find(choices, channel.name, &ChannelChoice::channel) != choices.end()) names.push_back(role);
    if (names.empty()) names.push_back(channel.name);
    for (const auto& name : names) look_at_unit(channel, name, findings);
    look_at_temperature(channel, findings);
  }
  return findings;
}

}  // namespace

extern const Check units{"units", "units that do not fit the purpose of the channel, and impossible temperatures", run};

}  // namespace tumble::checks
