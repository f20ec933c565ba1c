#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <set>
#include <vector>

#include "tumble/checks/check.hpp"
#include "tumble/checks/support/each_channel.hpp"
#include "tumble/checks/support/grain.hpp"
#include "tumble/checks/support/signals.hpp"

namespace tumble::checks::coarse_steps {

namespace {

using namespace support;

/// That counts have a common factor by chance: 1/n for each further number that differs. Chosen: one in ten million.
constexpr double chance = 1e-7;

/// Whether each value is beyond the one before, on one side: a ramp of more than a step from sample to sample shows no rounding.
bool is_ramp(const std::vector<double>& values) {
  return std::ranges::adjacent_find(values, std::ranges::greater_equal()) == values.end() ||
         std::ranges::adjacent_find(values, std::ranges::less_equal()) == values.end();
}

/// Samples of the unit that are rounded one by one.
Findings of_values(const Channel& channel) {
  const Grain grain = grain_of(channel.values);
  if (!is_coarse(grain) || is_ramp(channel.values)) return {};
  const Unit unit = channel.unit.offset() == 0.0 ? channel.unit : Unit::parse("K");
  return {{Finding::Severity::warning,
           "steps_exceed_noise",
           {{"step", grain.step, unit}, {"noise", grain.scatter, unit}},
           channel.name}};
}

/// Counts that are whole multiples of a number of pulses: a divider, or an interface that drops bits.
Findings of_counts(const Channel& channel) {
  constexpr std::size_t most = 64;
  std::set<long long> different;
  for (const double value : channel.values) {
    if (std::isnan(value)) continue;
    if (!(std::abs(value) < 9e15) || value != std::round(value)) return {};
    if (different.size() < most) different.insert(std::llround(value));
  }
  long long common = 0;
  for (const long long count : different) common = std::gcd(common, count);
  if (common < 2 ||
      !(static_cast<double>(different.size() - 1) * std::log(static_cast<double>(common)) > -std::log(chance)))
    return {};
  const bool all = std::ranges::all_of(channel.values, [&](double value) {
    return std::isnan(value) || std::fmod(value, static_cast<double>(common)) == 0.0;
  });
  if (!all) return {};
  return {{Finding::Severity::warning, "counts_in_steps", {{"step", common}}, channel.name}};
}

Findings run(const Recording& recording, const Plan* plan) {
  return findings_of_each(recording, [&](const Channel& channel) {
    if (!is_signal(channel, plan)) return Findings{};
    return channel.kind == QuantityKind::count ? of_counts(channel) : of_values(channel);
  });
}

}  // namespace

extern const Check coarse_steps{"coarse_steps", "outputs whose steps are greater than their noise", run};

}  // namespace tumble::checks::coarse_steps
