#include "tumble/rigs/chain/oven.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/rigs/chain/carrier.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::chain {
namespace {

using Kind = Motion::Kind;

constexpr const char* axis_name = "temperature";
constexpr double freezing = 273.15;  ///< [K]
constexpr double nothing = 1e-3;  ///< [K] by which the instrument may differ from air that stands: then it has soaked
constexpr double soaked = 0.05;   ///< [K], the same for `settled`

const Motion* commanded(const Segment& segment) {
  const auto found = segment.axes.find(axis_name);
  return found == segment.axes.end() ? nullptr : &found->second;
}

bool used(const Schedule& run) {
  return std::ranges::any_of(run, [](const Segment& segment) { return commanded(segment) != nullptr; });
}

/// The air as commanded, piece by piece; the instrument is not looked at yet.
struct Air {
  double begin, temperature, slope;
};

double target_of(const Motion& motion) { return motion.kind == Kind::ramp ? motion.to : motion.value; }

std::vector<Air> air_of(const Schedule& run, const Settings& options) {
  const Motion* first = commanded(run.front());
  double now = first && first->kind != Kind::ramp ? first->value : options.number("temperature");
  std::vector<Air> air{{0.0, now, 0.0}};
  for (const AxisCommand& command : commands_to(run, axis_name)) {
    const double begin = command.begin;
    if (const Motion* motion = command.motion) {
      const double target = target_of(*motion);
      const double speed = motion->kind == Kind::ramp ? motion->value : options.number("oven_ramp_limit");
      const double needed = std::abs(target - now) / speed;
      if (needed > 0.0) {
        const double slope = std::copysign(speed, target - now), length = std::min(needed, command.duration);
        air.push_back({begin, now, slope});
        now = length < needed ? now + slope * length : target;
        air.push_back({begin + length, now, 0.0});
      }
    }
  }
  return air;
}

/// (T - 0 degC) grows by the scale, all by the offset.
double true_of(const Oven& oven, double reading) { return reading + oven.offset + oven.scale * (reading - freezing); }

/// The instrument's lag behind air of this slope after `time`, from what it was.
double behind_after(double behind, double slope, double time_constant, double time) {
  const double steady = -slope * time_constant;
  return steady + (behind - steady) * std::exp(-time / time_constant);
}

/// When the instrument is within `near` of air that stands [s after the piece begins].
double time_to_soak(double behind, double near, double time_constant) {
  return std::abs(behind) <= near ? 0.0 : time_constant * std::log(std::abs(behind) / near);
}

void add_piece(Oven& oven, const Air& air, double next) {
  OvenPiece piece{air.begin, true_of(oven, air.temperature), air.slope * (1.0 + oven.scale)};
  if (!oven.pieces.empty()) {
    const OvenPiece& last = oven.pieces.back();
    if (last.lagging) piece.behind = behind_after(last.behind, last.slope, oven.time_constant, air.begin - last.begin);
  }
  piece.lagging = piece.slope != 0.0 || std::abs(piece.behind) > nothing;
  oven.pieces.push_back(piece);
  if (!piece.lagging || piece.slope != 0.0) return;
  const double end = air.begin + time_to_soak(piece.behind, nothing, oven.time_constant);
  if (end < next) oven.pieces.push_back({end, piece.air});
}

/// When the instrument is at the temperature that the segment commands, to `soaked`.
double settled_at(const Oven& oven, double begin, double end, const Motion* motion) {
  if (!motion || motion->kind == Kind::ramp) return begin;
  for (auto piece = oven.pieces.rbegin(); piece != oven.pieces.rend(); ++piece) {
    if (piece->begin >= end || piece->slope != 0.0) continue;
    // the first piece of the air that stands at the end of the segment
    auto first = piece;
    while (first + 1 != oven.pieces.rend() && (first + 1)->slope == 0.0 && (first + 1)->air == piece->air) ++first;
    const double time = first->begin + time_to_soak(first->behind, soaked, oven.time_constant);
    return std::clamp(time, begin, end);
  }
  return end;
}

void check_segment(const Segment& segment, double& now, const Settings& options, Problems& problems) {
  const Motion* motion = commanded(segment);
  if (!motion) return;
  const Unit celsius = Unit::parse("degC"), speed_unit = Unit::parse("K/min");
  const double target = target_of(*motion), limit = options.number("oven_ramp_limit");
  const double low = options.number("oven_lowest"), high = options.number("oven_highest");
  const auto refuse = [&](const Sentence& why) { problems.push_back(within(place_of_segment(segment.label), why)); };
  if (target < low || target > high)
    refuse(say("{:.6g} degC is outside of the oven's {:.6g} to {:.6g} degC", celsius.from_si(target),
               celsius.from_si(low), celsius.from_si(high)));
  const double speed = motion->kind == Kind::ramp ? motion->value : limit;
  if (speed > limit * (1.0 + 1e-12))
    refuse(say("{:.6g} K/min is more than the oven_ramp_limit of {:.6g} K/min", speed_unit.from_si(speed),
               speed_unit.from_si(limit)));
  const double needed = std::abs(target - now) / speed;
  if (needed > segment.duration * (1.0 + 1e-9))
    refuse(say("from {:.6g} to {:.6g} degC takes {:.6g} s, and the segment lasts {:.6g} s", celsius.from_si(now),
               celsius.from_si(target), needed, segment.duration));
  now = target;
}

}  // namespace

Axis oven_axis() {
  return {axis_name, "degC", {Kind::hold, Kind::dwell, Kind::ramp}, "set point of an oven about the instrument"};
}

std::vector<Option> oven_options() {
  return {quantity("oven_lowest", "degC").above(-273.15).otherwise("-60 degC").says("coldest set point of the oven"),
          quantity("oven_highest", "degC").above(-273.15).otherwise("90 degC").says("hottest set point"),
          quantity("oven_ramp_limit", "K/min").above(0).otherwise("5 K/min").says("fastest change of the oven's air"),
          quantity("oven_time", "min").above(0).otherwise("5 min").says("time in which the instrument follows the air"),
          quantity("thermometer_noise", "K")
              .at_least(0)
              .otherwise("0.01 K")
              .says("standard deviation of one reading of the temperature"),
          quantity("thermometer_quantum", "K").at_least(0).otherwise("0 K").says("step of the readings; 0: none")};
}

std::vector<Imperfection> oven_imperfections() {
  return {{quantity("thermometer_offset_sd", "K")
               .at_least(0)
               .otherwise("0.1 K")
               .says("offset of the thermometer, which regulates the oven"),
           {error_names::thermometer_offset}},
          {quantity("thermometer_scale_sd", "%")
               .at_least(0)
               .otherwise("0.1 %")
               .says("scale error of the thermometer, from 0 degC"),
           {error_names::thermometer_scale}}};
}

void check_oven(const Settings& options, Problems& problems) {
  check_order(options, "oven_lowest", "oven_highest", problems);
}

void check_oven_schedule(const Schedule& schedule, const Settings& options, Problems& problems) {
  for (const auto& run : runs_of(schedule)) {
    const Motion* first = commanded(run.front());
    double now = first && first->kind != Kind::ramp ? first->value : options.number("temperature");
    for (const auto& segment : run) check_segment(segment, now, options, problems);
  }
}

Oven oven_of(const Schedule& run, const Settings& options, const ErrorValues& errors) {
  Oven oven{options.number("oven_time"),
            errors(error_names::thermometer_offset),
            errors(error_names::thermometer_scale),
            {},
            {}};
  if (!used(run)) return oven;
  const auto air = air_of(run, options);
  for (std::size_t k = 0; k < air.size(); ++k)
    add_piece(oven, air[k], k + 1 < air.size() ? air[k + 1].begin : std::numeric_limits<double>::infinity());
  double begin = 0.0;
  for (const auto& segment : run) {
    oven.settled.push_back(settled_at(oven, begin, begin + segment.duration, commanded(segment)));
    begin += segment.duration;
  }
  return oven;
}

Warmth at(const Oven& oven, double time, std::size_t& piece) {
  while (piece > 0 && oven.pieces[piece].begin > time) --piece;
  while (piece + 1 < oven.pieces.size() && oven.pieces[piece + 1].begin <= time) ++piece;
  const OvenPiece& now = oven.pieces[piece];
  if (!now.lagging) return {now.air, 0.0};
  const double since = std::max(0.0, time - now.begin);
  const double behind = behind_after(now.behind, now.slope, oven.time_constant, since);
  return {now.air + now.slope * since + behind, -behind / oven.time_constant};
}

double shown_by(const Oven& oven, double temperature) {
  return freezing + (temperature - freezing - oven.offset) / (1.0 + oven.scale);
}

double steady_until(const Oven& oven, double time) {
  if (oven.pieces.empty()) return std::numeric_limits<double>::infinity();
  std::size_t piece = 0;
  at(oven, time, piece);
  if (oven.pieces[piece].lagging) return time;
  return piece + 1 < oven.pieces.size() ? oven.pieces[piece + 1].begin : std::numeric_limits<double>::infinity();
}

}  // namespace tumble::chain
