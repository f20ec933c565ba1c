#include "tumble/methods/dtg_centrifuge/angles.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/units/constants.hpp"

namespace tumble::dtg_centrifuge {
namespace {

constexpr double same_rate = 1e-12;        ///< [1] by which the rates of two clocks that are one may differ: rounding
constexpr double same_instant = 1e-4;      ///< [sample intervals] by which the stamps of one instant may differ
constexpr double full_turn = 1.001;        ///< [turns] a wrapped angle has no greater range; an unwrapped one soon has
constexpr std::size_t fewest_angles = 32;  ///< samples of a level, with which its rate is determined

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

/// The sample of `other` taken when sample `first` of `channel` was, if both have one clock; else nothing.
bool same_clock(const Channel& channel, std::size_t first, std::size_t count, const Channel& other, double shift,
                std::size_t& at) {
  if (!channel.timeline.uniform() || !other.timeline.uniform()) {
    at = first;
    return channel.timeline.stamps == other.timeline.stamps && shift == 0.0 && first + count <= other.values.size();
  }
  const double rate = other.timeline.rate;
  if (std::abs(channel.timeline.rate - rate) > same_rate * rate) return false;
  const double position = (channel.time(first) + shift - other.timeline.start) * rate;
  const double index = std::round(position);
  at = static_cast<std::size_t>(std::max(0.0, index));
  return std::abs(position - index) < same_instant && index >= 0.0 && at + count <= other.values.size();
}

/// Whether readings start at zero every turn: they stay within one turn and jump by more than half of one.
bool jumps(const Channel& channel, std::size_t first, std::size_t last) {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (std::size_t i = first; i < last; ++i) {
    least = channel.values[i] < least ? channel.values[i] : least;
    most = channel.values[i] > most ? channel.values[i] : most;
  }
  if (!(most - least < full_turn * two_pi)) return false;
  for (std::size_t i = first + 1; i < last; ++i)
    if (std::abs(channel.values[i] - channel.values[i - 1]) > 0.5 * two_pi) return true;
  return false;
}

/// Readings without the jumps of whole turns.
std::vector<double> without_jumps(const Channel& channel, std::size_t first, std::size_t last) {
  std::vector<double> out;
  double turns = 0.0, before = nothing;
  for (std::size_t i = first; i < last; ++i) {
    const double v = channel.values[i];
    if (std::abs(v - before) > 0.5 * two_pi) turns += v < before ? 1.0 : -1.0;
    if (!std::isnan(v)) before = v;
    out.push_back(v + two_pi * turns);
  }
  return out;
}

}  // namespace

Angles::Axis Angles::axis_of(const Channel& channel, double offset, double begin, double end) {
  Axis axis;
  axis.channel = &channel;
  axis.offset = offset;
  const std::size_t first = index_at(channel, begin);
  const std::size_t last = std::min(index_at(channel, end), channel.values.size());
  if (last < first + fewest_angles) {
    axis.rate = axis.unsteady = nothing;
    return axis;
  }
  if (jumps(channel, first, last)) {
    axis.first = first > 0 ? first - 1 : 0;
    axis.unwound = without_jumps(channel, axis.first, std::min(last + 1, channel.values.size()));
  }
  const auto rate = [&](std::size_t a, std::size_t b) {
    while (a < b && std::isnan(axis.value(a))) ++a;
    while (b > a && std::isnan(axis.value(b))) --b;
    return b > a ? (axis.value(b) - axis.value(a)) / (channel.time(b) - channel.time(a)) : nothing;
  };
  axis.rate = rate(first, last - 1);
  constexpr std::size_t parts = 16;
  for (std::size_t k = 0; k < parts; ++k) {
    const double of_part = rate(first + k * (last - 1 - first) / parts, first + (k + 1) * (last - 1 - first) / parts);
    if (!std::isnan(of_part)) axis.unsteady = std::max(axis.unsteady, std::abs(of_part / axis.rate - 1.0));
  }
  return axis;
}

Angles::Angles(const Channels& channels, bool in_middle, double begin, double end)
    : arm_(axis_of(*channels.arm, in_middle ? 0.5 * channels.arm_step : 0.0, begin, end)),
      table_(axis_of(*channels.table, in_middle ? 0.5 * channels.table_step : 0.0, begin, end)) {}

Angles::Angles(double arm_rate, double table_rate, double centre) : centre_(centre) {
  arm_.rate = arm_rate;
  table_.rate = table_rate;
}

double Angles::unsteady() const { return std::max(arm_.unsteady, table_.unsteady); }

const double* Angles::of(const Axis& axis, const Channel& channel, double middle, std::size_t first, std::size_t count,
                         double* work) const {
  if (axis.channel == nullptr) {
    for (std::size_t i = 0; i < count; ++i) work[i] = axis.rate * (channel.time(first + i) + middle - centre_);
    return work;
  }
  const Channel& encoder = *axis.channel;
  std::size_t at = 0;
  if (same_clock(channel, first, count, encoder, middle - axis.offset, at) && axis.unwound.empty())
    return encoder.values.data() + at;
  const std::size_t n = encoder.values.size();
  const std::size_t low = axis.first, high = axis.unwound.empty() ? n : axis.first + axis.unwound.size();
  std::size_t k = std::max(low, index_at(encoder, channel.time(first) + middle - axis.offset));
  for (std::size_t i = 0; i < count; ++i) {
    const double time = channel.time(first + i) + middle - axis.offset;
    while (k < high && encoder.time(k) < time) ++k;
    // half a sample beyond the readings the turning goes on
    const std::size_t b = std::clamp<std::size_t>(k, low + 1, high - 1), a = b - 1;
    const double gap = encoder.time(b) - encoder.time(a), share = (time - encoder.time(a)) / gap;
    work[i] = share < -1.0 || share > 2.0 ? nothing : axis.value(a) + share * (axis.value(b) - axis.value(a));
  }
  return work;
}

void Angles::at(const Channel& channel, double step, std::size_t first, std::size_t count, std::vector<double>& work,
                const double*& arm, const double*& table) const {
  if (work.size() < 2 * count) work.resize(2 * count);
  arm = of(arm_, channel, 0.5 * step, first, count, work.data());
  table = of(table_, channel, 0.5 * step, first, count, work.data() + count);
}

}  // namespace tumble::dtg_centrifuge
