#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/methods/rlg_north_finder/faults.hpp"

namespace tumble::rlg_north_finder {
namespace {

using Severity = Finding::Severity;

/// What stands upright at a stay, as an accelerometer pair sees it.
enum class Upright { x_up, x_down, y_up, y_down, z };

const char* name(Upright state) {
  switch (state) {
    case Upright::x_up:
      return "x up";
    case Upright::x_down:
      return "x down";
    case Upright::y_up:
      return "y up";
    case Upright::y_down:
      return "y down";
    case Upright::z:
      return "z up or down";
  }
  return "";
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
  double x = 0.0, y = 0.0;  ///< outputs over their greatest, middle taken off
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

/// One way in which accelerometers can be read.
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

/// What the gyro says of the stays with x up and down, and of those with y up and down: 1 as planned, -1 the other way
/// round, 0 it does not say.
struct ByGyro {
  int x = 0, y = 0;
};

/// Pulses for an angle by the rotations about x; 0: there are none.
double scale_of(std::span<const linear::SegmentSummary> segments, const Path& path) {
  double sum = 0.0;
  int count = 0;
  for (const auto& one : path.rotations)
    if (one.axis == 0) sum += segments[one.segment].measured / segments[one.segment].felt.rate.x, ++count;
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
  return std::abs(std::abs(ratio) - 1.0) > 0.3 ? 0 : ratio > 0.0 ? 1 : -1;
}

ByGyro by_gyro(std::span<const linear::SegmentSummary> segments) {
  const Path path = path_of({segments.begin(), segments.end()});
  const double scale = scale_of(segments, path);
  if (scale == 0.0) return {};
  return {sense_of(segments, path, 0, scale), sense_of(segments, path, 1, scale)};
}

std::string meaning_of_exchange(const Reading& reading) {
  const std::string what = "accelerometer_x and accelerometer_y are exchanged";
  if (reading.x_sign > 0 && reading.y_sign > 0) return what + ": name the other channel for each in [channels]";
  return what + (reading.y_sign > 0   ? ", and the first is reversed"
                 : reading.x_sign > 0 ? ", and the second is reversed"
                                      : ", and both are reversed");
}

/// Reversed outputs and positions taken the other way round look alike to the accelerometers; the gyro tells them
/// apart. An axis that turns the other way throughout reverses the scale factor of the gyro too, so that the other pair
/// of stays is the one that does not fit it.
struct Meaning {
  int x_sign, y_sign;
  ByGyro gyro;  ///< 0, 0: it does not say
  const char* text;
};

const Meaning meanings[] = {
    {-1, 1, {1, 1}, "the sign of accelerometer_x is inverted, the gyro fits the plan: reverse its counts"},
    {-1,
     1,
     {-1, 1},
     "x up and x down (positions 2 and 4) are exchanged, the gyro shows it too: put the plan into the "
     "order that was gone through"},
    {-1,
     1,
     {-1, -1},
     "the first turn and those about z went the other way, the gyro shows it too: let the plan have "
     "the angles that were gone to"},
    {-1, 1, {0, 0}, "the sign of accelerometer_x is inverted, or x up and x down (positions 2 and 4) are exchanged"},
    {1, -1, {1, 1}, "the sign of accelerometer_y is inverted, the gyro fits the plan: reverse its counts"},
    {1,
     -1,
     {1, -1},
     "the turns about z went the other way, so that y up and y down (positions 3 and 5) are exchanged, "
     "the gyro shows it too: let the plan's inner angles be the ones that were gone to"},
    {1,
     -1,
     {-1, 1},
     "the inner axis turns the other way than the plan or its recorded angle says, the gyro shows it "
     "too: reverse its angles"},
    {1,
     -1,
     {0, 0},
     "the turns about z went the other way, so that y up and y down (positions 3 and 5) are exchanged, "
     "or the sign of accelerometer_y is inverted: let the plan's inner angles be the ones that were gone "
     "to, or reverse the counts"},
    {-1, -1, {1, 1}, "the signs of both accelerometers are inverted, the gyro fits the plan: reverse their counts"},
    {-1,
     -1,
     {-1, 1},
     "the first turn went the other way, so that x up and x down (positions 2 and 4) and y up and y "
     "down (3 and 5) are exchanged, the gyro shows it too: let the plan's outer angle be +90 deg there"},
    {-1,
     -1,
     {-1, -1},
     "x up and x down (positions 2 and 4) are exchanged and y up and y down (3 and 5), the gyro shows "
     "it too: put the plan into the order that was gone through"},
    {-1,
     -1,
     {1, -1},
     "the outer axis turns the other way than the plan or its recorded angle says, the gyro shows it "
     "too: reverse its angles"},
    {-1,
     -1,
     {0, 0},
     "the first turn went the other way, so that x up and x down (positions 2 and 4) and y up and y "
     "down (3 and 5) are exchanged, or the signs of both accelerometers are inverted: let the plan's "
     "outer angle be +90 deg there, or reverse the counts"}};

std::string meaning_of(const Reading& reading, const ByGyro& gyro) {
  if (reading.exchanged) return meaning_of_exchange(reading);
  const Meaning* unknown = nullptr;
  for (const auto& one : meanings) {
    if (one.x_sign != reading.x_sign || one.y_sign != reading.y_sign) continue;
    if (one.gyro.x == gyro.x && one.gyro.y == gyro.y) return one.text;
    unknown = &one;  // the last of each
    if (one.gyro.x == 0) break;
  }
  return unknown->text;
}

std::string label_of(const std::vector<Stay>& stays, std::size_t s) {
  return fmt::format("'{}' shows {} instead of {}", stays[s].label, name(state_of(stays[s].x, stays[s].y)),
                     name(stays[s].planned));
}

/// Two stays that each show what the other should.
std::string exchange_of(const std::vector<Stay>& stays, const std::vector<std::size_t>& off) {
  if (off.size() != 2) return "";
  const Stay &a = stays[off[0]], &b = stays[off[1]];
  if (state_of(a.x, a.y) != b.planned || state_of(b.x, b.y) != a.planned) return "";
  return fmt::format(": '{}' and '{}' look exchanged; the plan fits with these two in the other order", a.label,
                     b.label);
}

}  // namespace

Findings order_faults(const Summaries& segments) {
  const auto stays = stays_of(segments);
  const auto as_planned = unlike(stays, readings[0]);
  if (as_planned.empty()) return {};
  for (const auto& reading : readings) {
    if (!unlike(stays, reading).empty()) continue;
    const std::string meaning = meaning_of(reading, by_gyro(segments[gyro]));
    const bool inverted = meaning.find("inverted") != std::string::npos;
    return {{Severity::error,
             fmt::format("the accelerometers do not fit the plan: {}{}", meaning,
                         inverted ? " (specific force reads +1 g upwards, gravity pulls down)" : ""),
             ""}};
  }
  std::vector<std::string> all;
  for (const std::size_t s : as_planned) all.push_back(label_of(stays, s));
  return {{Severity::error,
           fmt::format("the positions were taken in another order than the plan says, or a channel is not what it is "
                       "called: {}{}",
                       fmt::join(all, ", "), exchange_of(stays, as_planned)),
           ""}};
}

}  // namespace tumble::rlg_north_finder
