#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/methods/rlg_north_finder/faults.hpp"

namespace tumble::rlg_north_finder {
namespace {

constexpr double seen_within = 0.3;  ///< [1] of the planned change, within which the Earth's rate is seen

/// Axis that is upright at a stay, as an accelerometer pair shows it.
enum class Upright { x_up, x_down, y_up, y_down, z };

Phrase phrase_of(Upright state) {
  switch (state) {
    case Upright::x_up:
      return Phrase{"x_up"};
    case Upright::x_down:
      return Phrase{"x_down"};
    case Upright::y_up:
      return Phrase{"y_up"};
    case Upright::y_down:
      return Phrase{"y_down"};
    case Upright::z:
      break;
  }
  return Phrase{"z_up_or_down"};
}

Upright state_of(double x, double y) {
  constexpr double least = 0.5;
  if (std::abs(x) < least && std::abs(y) < least) return Upright::z;
  if (std::abs(x) > std::abs(y)) return x > 0.0 ? Upright::x_up : Upright::x_down;
  return y > 0.0 ? Upright::y_up : Upright::y_down;
}

/// One stay: planned, and as the accelerometers show it.
struct Stay {
  std::string label;
  Upright planned = Upright::z;
  double x = 0.0, y = 0.0;  ///< outputs less their middle, over their greatest
};

/// Outputs of one accelerometer from -1 to 1.
std::vector<double> normal(std::span<const linear::SegmentSummary> segments) {
  double low = INFINITY, high = -INFINITY;
  for (const auto& segment : segments) low = std::min(low, segment.measured), high = std::max(high, segment.measured);
  std::vector<double> out;
  for (const auto& segment : segments)
    out.push_back(high > low ? (2.0 * segment.measured - high - low) / (high - low) : 0.0);
  return out;
}

std::vector<Stay> stays_of(const Summaries& segments) {
  std::vector<Stay> stays;
  const auto &first = segments[accelerometer_x], second = segments[accelerometer_y];
  const auto x = normal(first), y = normal(second);
  for (std::size_t s = 0; s < first.size(); ++s)
    for (std::size_t t = 0; t < second.size(); ++t) {
      if (first[s].label != second[t].label || first[s].run != second[t].run) continue;
      const Vector3 f = first[s].felt.specific_force;
      const double g = norm(f);
      stays.push_back({first[s].label, state_of(f.x / g, f.y / g), x[s], y[t]});
      break;
    }
  return stays;
}

/// A way to read the accelerometers.
struct Reading {
  int x_sign, y_sign;
  bool exchanged;
};

std::vector<std::size_t> unlike(const std::vector<Stay>& stays, const Reading& reading) {
  std::vector<std::size_t> out;
  for (std::size_t s = 0; s < stays.size(); ++s) {
    const double x = reading.x_sign * (reading.exchanged ? stays[s].y : stays[s].x);
    const double y = reading.y_sign * (reading.exchanged ? stays[s].x : stays[s].y);
    if (state_of(x, y) != stays[s].planned) out.push_back(s);
  }
  return out;
}

const Reading readings[] = {{1, 1, false}, {-1, 1, false}, {1, -1, false}, {-1, -1, false},
                            {1, 1, true},  {-1, 1, true},  {1, -1, true},  {-1, -1, true}};

/// Sense of the stays with x up and down, and of those with y up and down, by the gyro: 1 as planned, -1 the other way
/// round, 0 the gyro does not show it.
struct ByGyro {
  int x = 0, y = 0;
};

/// Pulses for an angle by the rotations about x; 0: there are none.
double scale_of(std::span<const linear::SegmentSummary> segments, const Path& path) {
  double sum = 0.0;
  int count = 0;
  for (const auto& turning : path.rotations)
    if (turning.axis == 0) sum += segments[turning.segment].measured / segments[turning.segment].felt.rate.x, ++count;
  return count > 0 ? sum / count : 0.0;
}

int sense_of(std::span<const linear::SegmentSummary> segments, const Path& path, std::size_t axis, double scale) {
  double measured = 0.0, planned = 0.0;
  const auto add = [&](const std::vector<std::size_t>& stays, double sign) {
    const double weight = sign / static_cast<double>(std::max<std::size_t>(stays.size(), 1));
    for (const std::size_t s : stays)
      measured += weight * segments[s].measured, planned += weight * segments[s].felt.rate.x;
  };
  if (path.up[axis].empty() || path.down[axis].empty()) return 0;
  add(path.up[axis], 1.0);
  add(path.down[axis], -1.0);
  const double ratio = measured / (scale * planned);  // 1 or -1 where the Earth's rate is seen
  return std::abs(std::abs(ratio) - 1.0) > seen_within ? 0 : ratio > 0.0 ? 1 : -1;
}

ByGyro by_gyro(std::span<const linear::SegmentSummary> segments) {
  const Path path = path_of({segments.begin(), segments.end()});
  const double scale = scale_of(segments, path);
  if (scale == 0.0) return {};
  return {sense_of(segments, path, 0, scale), sense_of(segments, path, 1, scale)};
}

Phrase meaning_of_exchange(const Reading& reading) {
  if (reading.x_sign > 0 && reading.y_sign > 0) return Phrase{"accelerometers_exchanged"};
  if (reading.y_sign > 0) return Phrase{"accelerometers_exchanged_first_reversed"};
  return reading.x_sign > 0 ? Phrase{"accelerometers_exchanged_second_reversed"}
                            : Phrase{"accelerometers_exchanged_both_reversed"};
}

/// Reversed outputs and positions taken in the other sense look alike to the accelerometers; the gyro distinguishes
/// them. An axis that turns in the other sense throughout reverses the scale factor of the gyro too, so that the other
/// pair of stays is the one that does not fit it.
struct Meaning {
  int x_sign, y_sign;
  ByGyro gyro;  ///< 0, 0: it does not show any
  Phrase phrase;
};

/// Meanings of these signs, the one for a gyro that shows nothing last.
const std::vector<Meaning>& meanings() {
  static const std::vector<Meaning> all{{-1, 1, {1, 1}, Phrase{"x_reversed"}},
                                        {-1, 1, {-1, 1}, Phrase{"x_positions_exchanged"}},
                                        {-1, 1, {-1, -1}, Phrase{"first_turn_and_turns_about_z_reversed"}},
                                        {-1, 1, {0, 0}, Phrase{"x_reversed_or_x_positions_exchanged"}},
                                        {1, -1, {1, 1}, Phrase{"y_reversed"}},
                                        {1, -1, {1, -1}, Phrase{"turns_about_z_reversed"}},
                                        {1, -1, {-1, 1}, Phrase{"inner_axis_reversed"}},
                                        {1, -1, {0, 0}, Phrase{"turns_about_z_or_y_reversed"}},
                                        {-1, -1, {1, 1}, Phrase{"x_and_y_reversed"}},
                                        {-1, -1, {-1, 1}, Phrase{"first_turn_reversed"}},
                                        {-1, -1, {-1, -1}, Phrase{"x_and_y_positions_exchanged"}},
                                        {-1, -1, {1, -1}, Phrase{"outer_axis_reversed"}},
                                        {-1, -1, {0, 0}, Phrase{"first_turn_or_x_and_y_reversed"}}};
  return all;
}

Phrase meaning_of(const Reading& reading, const ByGyro& gyro) {
  if (reading.exchanged) return meaning_of_exchange(reading);
  const Meaning* unknown = nullptr;
  for (const auto& meaning : meanings()) {
    if (meaning.x_sign != reading.x_sign || meaning.y_sign != reading.y_sign) continue;
    if (meaning.gyro.x == gyro.x && meaning.gyro.y == gyro.y) return meaning.phrase;
    unknown = &meaning;
  }
  return unknown->phrase;
}

Upright shown_by(const Stay& stay) { return state_of(stay.x, stay.y); }

/// The stays that show another axis upright than planned; two that show each what the other should.
Finding wrong_positions(const std::vector<Stay>& stays, const std::vector<std::size_t>& off) {
  const Stay& first = stays[off.front()];
  if (const Stay& last = stays[off.back()];
      off.size() == 2 && shown_by(first) == last.planned && shown_by(last) == first.planned)
    return {Finding::Severity::error, "positions_look_exchanged", {{"position", first.label}, {"other", last.label}}};
  std::vector<std::string> labels;
  for (const std::size_t s : off) labels.push_back(stays[s].label);
  return {Finding::Severity::error,
          "positions_not_as_planned",
          {{"positions", fmt::format("'{}'", fmt::join(labels, "', '"))},
           {"shown", phrase_of(shown_by(first))},
           {"planned", phrase_of(first.planned)}},
          "",
          {off.size(), first.label, {}}};
}

}  // namespace

Findings order_faults(const Summaries& segments) {
  const auto stays = stays_of(segments);
  const auto as_planned = unlike(stays, readings[0]);
  if (as_planned.empty()) return {};
  for (const auto& reading : readings)
    if (unlike(stays, reading).empty())
      return {{Finding::Severity::error,
               "accelerometers_do_not_fit_plan",
               {{"meaning", meaning_of(reading, by_gyro(segments[gyro]))}}}};
  return {wrong_positions(stays, as_planned)};
}

}  // namespace tumble::rlg_north_finder
