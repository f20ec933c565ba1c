#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "tumble/rigs/rig.hpp"
#include "tumble/station/station_file/draft.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"
#include "tumble/wire/instruments.hpp"

namespace tumble {
namespace station_file {
namespace {

using MotionKind = Motion::Kind;
using Kind = StationAxis::Kind;

/// What is asked, and what is wrong with it.
struct Checking {
  const Plan& plan;
  const Station& station;
  const StationRequest& request;
  std::vector<std::string> problems;

  void add(const std::string& problem) {
    if (std::find(problems.begin(), problems.end(), problem) == problems.end()) problems.push_back(problem);
  }
};

bool contains(const std::vector<std::string>& list, const std::string& word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

Unit unit_of(Kind kind, bool difference) {
  if (kind == Kind::angle) return Unit::parse("deg");
  if (kind == Kind::acceleration) return Unit::parse("m/s^2");
  return Unit::parse(difference ? "K" : "degC");
}

void check_axes_of_rig(Checking& checking) {
  const auto& plan = checking.plan;
  if (plan.rig_kind.empty()) return;
  const auto axes = find_rig(plan.rig_kind).axes();
  std::vector<std::string> names;
  for (const auto& axis : axes) names.push_back(axis.name);
  const auto lacks = [&](const std::string& name) {
    if (contains(names, name)) return false;
    checking.add(fmt::format("the station moves '{}', but the rig {} of the plan has no such axis{} (axes: {})", name,
                             plan.rig_kind, did_you_mean(name, names), fmt::join(names, ", ")));
    return true;
  };
  for (const auto& axis : checking.station.by_hand) lacks(axis);
  for (const auto& axis : checking.station.axes) {
    if (lacks(axis.name)) continue;
    const auto& of_rig =
        *std::find_if(axes.begin(), axes.end(), [&](const Axis& one) { return one.name == axis.name; });
    if (Unit::parse(of_rig.unit).dimension() != unit_of(axis.kind, false).dimension())
      checking.add(fmt::format("the axis '{}' of the rig {} is given in {}: another value of `moves` is needed",
                               axis.name, plan.rig_kind, of_rig.unit));
  }
}

/// The verb by which a controller carries out a motion.
const char* verb_of(const StationAxis& axis, const Motion& motion) {
  switch (motion.kind) {
    case MotionKind::rate:
      return "rate";
    case MotionKind::sine:
      return "sine";
    case MotionKind::sweep:
      return "sweep";
    case MotionKind::random:
      return "random";
    default:
      return axis.kind == Kind::temperature ? "set_temperature" : axis.kind == Kind::angle ? "position" : "stop";
  }
}

void check_verbs(Checking& checking, const Segment& segment, const StationAxis& axis, const Motion& motion) {
  const auto& device = checking.station.devices[axis.device];
  const std::string verb = verb_of(axis, motion);
  std::vector<std::string> needed{verb};
  if (axis.kind != Kind::acceleration) needed.emplace_back("read");
  if (axis.kind != Kind::temperature) needed.emplace_back("stop");
  for (const auto& one : needed)
    if (!device.verbs.empty() && !device.can(one))
      checking.add(fmt::format("segment '{}': {} needs the verb '{}', which the controller {} lacks", segment.label,
                               axis.name, one, device.controller));
  if (motion.kind == MotionKind::slew && !device.may_carry(verb, "rate"))
    checking.add(
        fmt::format("segment '{}': {} slews at a speed, which the verb '{}' of the controller {} does not carry",
                    segment.label, axis.name, verb, device.controller));
}

/// Limits of the station for one motion of the plan. `stands_at`: where the axis stands before it, where that is known.
class MotionLimits {
 public:
  MotionLimits(Checking& checking, const Segment& segment, const StationAxis& axis, std::optional<double> stands_at)
      : checking_(checking), segment_(segment), axis_(axis), stands_at_(stands_at) {}

  void check(const Motion& motion) const {
    switch (motion.kind) {
      case MotionKind::hold:
      case MotionKind::dwell:
        return place(motion.value);
      case MotionKind::ramp:
      case MotionKind::slew:
        place(motion.to);
        return rate(motion.value);
      case MotionKind::rate:
        rate(motion.value);
        return turning(motion.value);
      case MotionKind::sine:
        return oscillation(motion.amplitude, motion.frequency);
      case MotionKind::sweep:
        return oscillation(motion.amplitude, std::max(motion.frequency, motion.to_frequency));
      case MotionKind::random:
        return;
    }
  }

 private:
  void beyond(double value, double limit, const Unit& unit) const {
    checking_.add(fmt::format("segment '{}': {}: {:.6g} {} is beyond the station's {:.6g} {}", segment_.label,
                              axis_.name, unit.from_si(value), unit.text(), unit.from_si(limit), unit.text()));
  }
  void place(double value) const {
    const Unit unit = unit_of(axis_.kind, false);
    const double rounding = 1e-12 * (1.0 + std::abs(value));
    if (axis_.lowest && value < *axis_.lowest - rounding) beyond(value, *axis_.lowest, unit);
    if (axis_.highest && value > *axis_.highest + rounding) beyond(value, *axis_.highest, unit);
  }
  void rate(double value) const {
    const Unit unit = axis_.kind == Kind::temperature ? Unit::parse("K/min") : Unit::parse("deg/s");
    if (axis_.max_rate && std::abs(value) > *axis_.max_rate * (1.0 + 1e-9)) beyond(value, *axis_.max_rate, unit);
  }
  void travel(double value) const {
    if (axis_.lowest && axis_.highest && value > *axis_.highest - *axis_.lowest)
      beyond(value, *axis_.highest - *axis_.lowest, unit_of(axis_.kind, true));
  }
  /// A rate goes on while the axis settles and soaks, and for the duration.
  void turning(double rate) const {
    const double way = rate * (axis_.settle.hold + axis_.settle.soak + segment_.duration);
    travel(std::abs(way));
    if (stands_at_) place(*stands_at_ + way);
  }
  void oscillation(double amplitude, double frequency) const {
    const double w = two_pi * frequency;
    if (axis_.kind == Kind::acceleration) return acceleration(amplitude, Unit::parse("m/s^2"));
    travel(2.0 * amplitude);
    if (stands_at_) place(*stands_at_ - amplitude), place(*stands_at_ + amplitude);
    rate(amplitude * w);
    acceleration(amplitude * w * w, Unit::parse("deg/s^2"));
  }
  void acceleration(double value, const Unit& unit) const {
    if (axis_.max_acceleration && value > *axis_.max_acceleration * (1.0 + 1e-9))
      beyond(value, *axis_.max_acceleration, unit);
  }

  Checking& checking_;
  const Segment& segment_;
  const StationAxis& axis_;
  std::optional<double> stands_at_;
};

/// Where an axis stands after a motion of the plan; nothing: not known.
std::optional<double> place_after(const Motion& motion) {
  if (motion.kind == MotionKind::hold || motion.kind == MotionKind::dwell) return motion.value;
  if (motion.kind == MotionKind::ramp || motion.kind == MotionKind::slew) return motion.to;
  return std::nullopt;
}

void check_schedule(Checking& checking) {
  const auto& station = checking.station;
  if (checking.plan.schedule.empty()) checking.add("the plan has no schedule that could be carried out");
  std::set<std::string> unmoved;
  std::map<std::string, std::optional<double>> places;
  for (const auto& segment : checking.plan.schedule)
    for (const auto& [name, motion] : segment.axes) {
      if (contains(station.by_hand, name)) {
        if (motion.kind != MotionKind::hold)
          checking.add(fmt::format("segment '{}': {} is moved by hand, which can only hold", segment.label, name));
        continue;
      }
      const auto axis = std::find_if(station.axes.begin(), station.axes.end(),
                                     [&](const StationAxis& one) { return one.name == name; });
      if (axis == station.axes.end()) {
        if (unmoved.insert(name).second)
          checking.add(fmt::format("segment '{}': no device of the station moves {}: add it to a device, or to by_hand",
                                   segment.label, name));
        continue;
      }
      check_verbs(checking, segment, *axis, motion);
      MotionLimits(checking, segment, *axis, places[name]).check(motion);
      places[name] = place_after(motion);
    }
}

bool is_blank(const std::string& text) { return text.find_first_not_of(" \t") == std::string::npos; }

void check_units(Checking& checking) {
  const auto& units = checking.request.units;
  std::vector<std::string> slots;
  for (const auto& instrument : checking.station.instruments) {
    slots.push_back(instrument.slot);
    const auto found = units.find(instrument.slot);
    if (found == units.end() || is_blank(found->second))
      checking.add(fmt::format("slot '{0}': the unit has no serial number: --unit {0}=SERIAL", instrument.slot));
  }
  std::map<std::string, std::string> slot_of;
  for (const auto& [slot, serial] : units) {
    if (!contains(slots, slot))
      checking.add(fmt::format("the station has no slot '{}'{} (slots: {})", slot, did_you_mean(slot, slots),
                               slots.empty() ? "none" : fmt::format("{}", fmt::join(slots, ", "))));
    if (is_blank(serial)) continue;
    const auto [other, is_new] = slot_of.emplace(serial, slot);
    if (!is_new) checking.add(fmt::format("the unit {} is in slot '{}' and in slot '{}'", serial, other->second, slot));
  }
}

/// [Hz] of a stream: as the station states it, otherwise as its declaration does; 0: nobody does.
double rate_of(const StationInstrument& instrument) {
  if (instrument.rate > 0.0 || instrument.frames.empty()) return instrument.rate;
  const auto choice = parse_instrument(instrument.frames);
  if (choice.name.ends_with(".toml")) return 0.0;
  return codec_of(find_instrument(choice.name), choice.variants).rate;
}

void check_rates(Checking& checking) {
  const double wanted = checking.plan.sample_rate;
  for (const auto& instrument : checking.station.instruments) {
    const double rate = rate_of(instrument);
    if (wanted > 0.0 && rate > 0.0 && std::abs(rate - wanted) > 1e-6 * wanted)
      checking.add(fmt::format("slot '{}': the instrument sends at {:.6g} Hz, the plan expects {:.6g} Hz",
                               instrument.slot, rate, wanted));
  }
}

void check_equipment(Checking& checking) {
  const auto& date = checking.request.date;
  if (checking.request.rehearsed) return;
  if (!is_date(date)) return checking.add(fmt::format("'{}' is no date; \"2026-11-24\" is expected", date));
  if (!checking.request.accept_expired.empty()) return;
  for (const auto& equipment : checking.station.equipment)
    if (!equipment.due.empty() && equipment.due < date)
      checking.add(fmt::format("{} {}: its calibration{} was due on {}: calibrate it, or state --accept-expired REASON",
                               equipment.name, equipment.serial,
                               equipment.certificate.empty() ? "" : " " + equipment.certificate, equipment.due));
}

}  // namespace
}  // namespace station_file

std::vector<std::string> check_station(const Plan& plan, const Station& station, const StationRequest& request) {
  station_file::Checking checking{plan, station, request, {}};
  station_file::check_axes_of_rig(checking);
  station_file::check_schedule(checking);
  station_file::check_units(checking);
  station_file::check_rates(checking);
  station_file::check_equipment(checking);
  return std::move(checking.problems);
}

}  // namespace tumble
