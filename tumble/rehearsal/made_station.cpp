#include "tumble/rehearsal/made_station.hpp"

#include <algorithm>

#include "tumble/rehearsal/soak.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr double shortest_off = 5.0;  ///< [s]
constexpr double soaked = 1e-3;       ///< [K] what may remain of a change of temperature: less than sensors resolve

StationAxis::Kind kind_of(const Axis& axis) {
  const Unit unit = Unit::parse(axis.unit);
  if (unit.dimension() == Unit::parse("K").dimension()) return StationAxis::Kind::temperature;
  return unit.dimension() == Unit::parse("rad").dimension() ? StationAxis::Kind::angle
                                                            : StationAxis::Kind::acceleration;
}

SettleRule settle_rule(StationAxis::Kind kind) {
  SettleRule rule;
  if (kind == StationAxis::Kind::temperature) {
    rule.value = 0.5;
    rule.hold = 60.0;
    rule.timeout = 12.0 * hour;
  } else {
    rule.value = 0.01 * degree;
    rule.rate = 0.01 * degree;
    rule.relative_rate = 1e-3;
    rule.timeout = 600.0;
  }
  return rule;
}

StationDevice device_for(const Axis& axis, StationAxis::Kind kind) {
  StationDevice device;
  device.name = axis.name;
  const bool chamber = kind == StationAxis::Kind::temperature;
  device.controller = chamber ? "espec_p300" : "scpi_like";
  if (kind == StationAxis::Kind::acceleration) device.settings = {{"amplitude_unit", "m/s^2"}};
  device.poll = chamber ? 5.0 : 0.1;
  device.timeout = chamber ? 2.0 : 0.25;
  device.lost_after = chamber ? 15.0 : 0.6;  // one reply that is lost is asked for again
  if (!chamber) device.prepare = {ControllerVerb::enable};
  return device;
}

}  // namespace

Station station_for(const Plan& plan) {
  if (plan.rig_kind.empty())
    throw Error(Error::Kind::bad_input, "the plan names no rig that could be rehearsed: [rig]");
  Station station;
  station.name = "rehearsal";
  for (const Axis& axis : find_rig(plan.rig_kind).axes()) {
    if (is_mount_axis(axis.name)) {
      station.by_hand.push_back(axis.name);
      continue;
    }
    StationAxis driven;
    driven.name = axis.name;
    driven.kind = kind_of(axis);
    driven.device = station.devices.size();
    driven.settle = settle_rule(driven.kind);
    driven.turns = driven.kind == StationAxis::Kind::angle ? StationAxis::Turns::counted : StationAxis::Turns::limited;
    station.devices.push_back(device_for(axis, driven.kind));
    SafeCommand stop;
    stop.device = driven.device;
    stop.request.verb = ControllerVerb::stop;
    station.safe.push_back(stop);
    station.axes.push_back(driven);
  }
  StationDevice supply;
  supply.name = "supply";
  supply.controller = "scpi_supply";
  supply.poll = 1.0;
  supply.timeout = 2.0;
  supply.lost_after = 10.0;
  station.power.device = station.devices.size();
  station.power.off_time = std::max(shortest_off, soak_time_of(plan, soaked));
  station.devices.push_back(supply);
  station.instruments.push_back({.slot = "unit", .frames = std::string(made_frames_name), .rate = plan.sample_rate});
  return station;
}

}  // namespace tumble
