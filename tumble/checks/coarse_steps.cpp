#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <set>
#include <vector>

#include "tumble/checks/check.hpp"
#include "tumble/checks/grain.hpp"
#include "tumble/checks/support/each_channel.hpp"
#include "tumble/checks/support/signals.hpp"

namespace tumble::checks::coarse_steps {

namespace {

using namespace support;

/// That counts have a common factor by chance: 1/n for each further number that differs. Chosen: one in ten million.
constexpr double chance = 1e-7;
/// [pulse] a common factor from which on few different numbers suffice where the counts keep changing between them: a unit
/// in rebalance by single pulses, which gives -1, 0 and 1, has no such step.
constexpr long long least_of_few = 4;

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

/// Changes of a count from one sample to the next, both ways: a unit that is counted pulse by pulse passes what lies between.
/// Fewer are those of a rig that goes from one position to another.
bool keeps_changing(const Channel& channel, std::size_t segments) {
  constexpr std::size_t least = 32, of_segment = 4;
  std::size_t up = 0, down = 0;
  for (std::size_t i = 1; i < channel.values.size(); ++i) {
    up += channel.values[i] > channel.values[i - 1];
    down += channel.values[i] < channel.values[i - 1];
  }
  return std::min(up, down) > least + of_segment * segments;
}

/// Counts that are whole multiples of a number of pulses: a divider, or an interface that drops bits.
Findings of_counts(const Channel& channel, std::size_t segments) {
  constexpr std::size_t most = 64;
  std::set<long long> different;
  for (const double value : channel.values) {
    if (std::isnan(value)) continue;
    if (!(std::abs(value) < 9e15) || value != std::round(value)) return {};
    if (different.size() < most) different.insert(std::llround(value));
  }
  long long common = 0;
  for (const long long count : different) common = std::gcd(common, count);
  if (common < 2) return {};
  const double unlikely = static_cast<double>(different.size() - 1) * std::log(static_cast<double>(common));
  if (!(unlikely > -std::log(chance)) && !(common >= least_of_few && keeps_changing(channel, segments))) return {};
  const bool all = std::ranges::all_of(channel.values, [&](double value) {
    return std::isnan(value) || std::fmod(value, static_cast<double>(common)) == 0.0;
  });
  if (!all) return {};
  return {{Finding::Severity::warning, "counts_in_steps", {{"step", common}}, channel.name}};
}

Findings run(const Recording& recording, const Plan* plan) {
  return findings_of_each(recording, [&](const Channel& channel) {
    if (!is_signal(channel, plan)) return Findings{};
    return channel.kind == QuantityKind::count ? of_counts(channel, recording.marks.size()) : of_values(channel);
  });
}

}  // namespace

extern const Check coarse_steps{"coarse_steps", "outputs whose steps are greater than their noise", run};

}  // namespace tumble::checks::coarse_steps
