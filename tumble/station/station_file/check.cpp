#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <set>

#include "tumble/rigs/rig.hpp"
#include "tumble/station/station_file/draft.hpp"
#include "tumble/station/station_file/motion_limits.hpp"
#include "tumble/tasks/stopping_rule.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"
#include "tumble/units/text_parts.hpp"
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
  Problems problems;

  void add(const Problem& problem) {
    if (std::find(problems.begin(), problems.end(), problem) == problems.end()) problems.push_back(problem);
  }
};

bool contains(const std::vector<std::string>& list, const std::string& word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

Unit unit_of(Kind kind) {
  if (kind == Kind::angle) return Unit::parse("deg");
  return Unit::parse(kind == Kind::acceleration ? "m/s^2" : "degC");
}

void check_axes_of_rig(Checking& checking) {
  const auto& plan = checking.plan;
  if (plan.rig_kind.empty()) return;
  const auto axes = find_rig(plan.rig_kind).axes();
  std::vector<std::string> names;
  for (const auto& axis : axes) names.push_back(axis.name);
  const auto lacks = [&](const std::string& name) {
    if (contains(names, name)) return false;
    checking.add(say("the station moves '{}', but the rig {} of the plan has no such axis{} (axes: {})", name,
                     Name{plan.rig_kind}, did_you_mean(name, names), fmt::join(names, ", ")));
    return true;
  };
  for (const auto& axis : checking.station.by_hand) lacks(axis);
  for (const auto& axis : checking.station.axes) {
    if (lacks(axis.name)) continue;
    const auto& of_rig =
        *std::find_if(axes.begin(), axes.end(), [&](const Axis& one) { return one.name == axis.name; });
    if (Unit::parse(of_rig.unit).dimension() != unit_of(axis.kind).dimension())
      checking.add(say("the axis '{}' of the rig {} is given in {}: another value of `moves` is needed", axis.name,
                       Name{plan.rig_kind}, Name{of_rig.unit}));
  }
}

/// The verb by which a controller carries out a motion.
ControllerVerb verb_of(const StationAxis& axis, const Motion& motion) {
  switch (motion.kind) {
    case MotionKind::rate:
      return ControllerVerb::rate;
    case MotionKind::sine:
      return ControllerVerb::sine;
    case MotionKind::sweep:
      return ControllerVerb::sweep;
    case MotionKind::random:
      return ControllerVerb::random;
    default:
      return axis.kind == Kind::temperature ? ControllerVerb::set_temperature
             : axis.kind == Kind::angle     ? ControllerVerb::position
                                            : ControllerVerb::stop;
  }
}

/// The values of the request by which the executive commands a motion (executive/motions.cpp), which omits those of
/// speed and acceleration that a controller does not take.
std::vector<std::string> values_of(const StationDevice& device, const StationAxis& axis, const Motion& motion,
                                   ControllerVerb verb) {
  std::vector<std::string> values;
  if (axis.max_acceleration && device.may_carry(verb, "acceleration")) values.emplace_back("acceleration");
  const auto with = [&](std::initializer_list<const char*> more) {
    values.insert(values.end(), more.begin(), more.end());
    return values;
  };
  if (verb == ControllerVerb::position)
    return axis.speed && device.may_carry(verb, "rate") ? with({"position", "rate"}) : with({"position"});
  if (verb == ControllerVerb::rate) return with({"rate"});
  if (verb == ControllerVerb::set_temperature) return {"temperature"};
  if (verb == ControllerVerb::random) return {"rms"};
  if (verb == ControllerVerb::sweep) return {"amplitude", "frequency", "to_frequency", "duration"};
  if (verb != ControllerVerb::sine) return {};
  return motion.phase != 0.0 ? std::vector<std::string>{"amplitude", "frequency", "phase"}
                             : std::vector<std::string>{"amplitude", "frequency"};
}

/// What a request would carry that the controller does not take, or lacks what it needs.
void check_values(Checking& checking, const StationAxis& axis, const Motion& motion) {
  const auto& device = checking.station.devices[axis.device];
  const ControllerVerb verb = verb_of(axis, motion);
  if (!device.takes.contains(verb) || !device.needs.contains(verb)) return;
  const auto values = values_of(device, axis, motion, verb);
  for (const auto& value : values)
    if (!device.may_carry(verb, value))
      checking.add(say("{}: '{}' of the controller {} takes no {}", Name{axis.name}, name(verb),
                       Name{device.controller}, Name{value}));
  for (const auto& value : device.needs.at(verb))
    if (!contains(values, value))
      checking.add(say("{}: '{}' of the controller {} needs {}{}", Name{axis.name}, name(verb), Name{device.controller},
                       Name{value},
                       verb == ControllerVerb::position && value == "rate" ? ": add `speed` to the axis" : ""));
}

void check_verbs(Checking& checking, const Segment& segment, const StationAxis& axis, const Motion& motion) {
  const auto& device = checking.station.devices[axis.device];
  const ControllerVerb verb = verb_of(axis, motion);
  std::vector<ControllerVerb> needed{verb};
  if (axis.kind != Kind::acceleration) needed.push_back(ControllerVerb::read);
  if (axis.kind != Kind::temperature) needed.push_back(ControllerVerb::stop);
  for (const auto& one : needed)
    if (!device.verbs.empty() && !device.can(one))
      checking.add(say("segment '{}': {} needs the verb '{}', which the controller {} lacks", segment.label,
                       Name{axis.name}, name(one), Name{device.controller}));
  if (motion.kind == MotionKind::slew && !device.may_carry(verb, "rate"))
    checking.add(say("segment '{}': {} slews at a speed, which the verb '{}' of the controller {} does not carry",
                     segment.label, Name{axis.name}, name(verb), Name{device.controller}));
}

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
          checking.add(say("segment '{}': {} is moved by hand, which can only hold", segment.label, Name{name}));
        continue;
      }
      const auto axis = std::find_if(station.axes.begin(), station.axes.end(),
                                     [&](const StationAxis& one) { return one.name == name; });
      if (axis == station.axes.end()) {
        if (unmoved.insert(name).second)
          checking.add(say("segment '{}': no device of the station moves {}: add it to a device, or to by_hand",
                           segment.label, Name{name}));
        continue;
      }
      check_verbs(checking, segment, *axis, motion);
      check_values(checking, *axis, motion);
      for (const auto& problem : beyond_limits(segment, *axis, motion, places[name])) checking.add(problem);
      places[name] = place_after(motion);
    }
}

/// A run keeps its plan, to be carried on with it.
void check_rules(Checking& checking) {
  if (!checking.plan.file.empty() && !checking.plan.text)
    checking.add("the plan is longer than 100 kB: a run keeps a copy of its plan, which may be as long as that");
  try {
    stopping_rules(checking.plan);
  } catch (const Error& error) {
    for (const auto& problem : error.problems) checking.add(problem);
  }
}

void check_units(Checking& checking) {
  const auto& units = checking.request.units;
  std::vector<std::string> slots;
  for (const auto& instrument : checking.station.instruments) {
    slots.push_back(instrument.slot);
    const auto found = units.find(instrument.slot);
    if (found == units.end() || is_blank(found->second))
      checking.add(say("slot '{0}': the unit has no serial number: --unit {0}=SERIAL", Name{instrument.slot}));
  }
  std::map<std::string, std::string> slot_of;
  for (const auto& [slot, serial] : units) {
    if (!contains(slots, slot))
      checking.add(say("the station has no slot '{}'{} (slots: {})", slot, did_you_mean(slot, slots),
                       slots.empty() ? Sentence("none") : say("{}", fmt::join(slots, ", "))));
    if (is_blank(serial)) continue;
    const auto [other, is_new] = slot_of.emplace(serial, slot);
    if (!is_new) checking.add(say("the unit {} is in slot '{}' and in slot '{}'", Name{serial}, other->second, slot));
  }
}

/// [Hz] of a stream: as the station states it, otherwise as its declaration does; 0: nobody does.
double rate_of(const StationInstrument& instrument) {
  if (instrument.rate > 0.0 || instrument.frames.empty()) return instrument.rate;
  const auto choice = parse_instrument(instrument.frames);
  if (std::filesystem::path(choice.name).extension() == ".toml") return 0.0;
  return codec_of(find_instrument(choice.name), choice.variants).rate;
}

void check_rates(Checking& checking) {
  const double wanted = checking.plan.sample_rate;
  for (const auto& instrument : checking.station.instruments) {
    const double rate = rate_of(instrument);
    if (wanted > 0.0 && rate > 0.0 && std::abs(rate - wanted) > 1e-6 * wanted)
      checking.add(say("slot '{}': the instrument sends at {:.6g} Hz, the plan expects {:.6g} Hz", instrument.slot,
                       rate, wanted));
  }
}

void check_equipment(Checking& checking) {
  const auto& date = checking.request.date;
  if (checking.request.rehearsed) return;
  if (!is_date(date)) return checking.add(say("'{}' is no date; \"2026-11-24\" is expected", date));
  if (!checking.request.accept_expired.empty()) return;
  for (const auto& expired : expired_equipment(checking.station, date))
    checking.add(say("{}: calibrate it, or state --accept-expired REASON", expired));
}

}  // namespace
}  // namespace station_file

std::vector<Sentence> expired_equipment(const Station& station, const std::string& date) {
  std::vector<Sentence> expired;
  for (const auto& equipment : station.equipment) {
    if (equipment.due.empty() || equipment.due >= date) continue;
    const Name name{equipment.name}, serial{equipment.serial}, certificate{equipment.certificate}, due{equipment.due};
    expired.push_back(certificate.text.empty()
                          ? say("{} {}: its calibration was due on {}", name, serial, due)
                          : say("{} {}: its calibration {} was due on {}", name, serial, certificate, due));
  }
  return expired;
}

Problems check_station(const Plan& plan, const Station& station, const StationRequest& request) {
  station_file::Checking checking{plan, station, request, {}};
  station_file::check_axes_of_rig(checking);
  station_file::check_schedule(checking);
  station_file::check_rules(checking);
  station_file::check_units(checking);
  station_file::check_rates(checking);
  station_file::check_equipment(checking);
  return std::move(checking.problems);
}

}  // namespace tumble
