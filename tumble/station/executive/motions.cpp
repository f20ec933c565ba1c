#include <cmath>

#include "tumble/station/executive/turn.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::executive {
namespace {

using Kind = Motion::Kind;

/// Values of the rig for the controller. A difference, a rate or an amplitude has no offset.
double to_controller(const StationAxis& axis, double value) { return axis.sign * (value - axis.offset); }
double to_controller_rate(const StationAxis& axis, double value) { return axis.sign * value; }

/// The angle to demand for a position of the plan. A plan counts turns, except those that motions at a rate have made:
/// after these the axis takes the nearest of the angles that differ by whole turns, or goes on from there (`nearest`
/// false), as profile_of() of the rigs does.
double position_of(const StationAxis& axis, AxisProgress& progress, double wanted, bool nearest) {
  if (axis.turns != StationAxis::Turns::counted || !progress.position) return wanted;
  if (progress.turned) progress.turns = two_pi * std::round((*progress.position - (nearest ? wanted : 0.0)) / two_pi);
  progress.turned = false;
  return wanted + progress.turns;
}

void demand(AxisProgress& progress, Demand what, double value) {
  const bool other = progress.demand != what || progress.value != value;
  const double rate = progress.rate.value_or(0.0), way = progress.watch.fastest.value_or(0.0);
  // A further attempt at the same motion is no reason for the rate that the axis has.
  if (other) progress.watch = {.low = std::min(rate, -way), .high = std::max(rate, way)};
  progress.arrived = false;
  progress.demand = what;
  progress.value = value;
  progress.window = {};
  progress.settled = false;
  progress.outside = 0;
  progress.turned_at.clear();
}

void send_motion(Turn& turn, std::size_t index, ControllerVerb verb, std::map<std::string, double> values,
                 Purpose purpose = Purpose::motion) {
  const auto& axis = turn.station().axes[index];
  ask(turn, axis.device, {{verb, std::move(values), axis.number}, purpose});
}

/// The controller keeps to the limit of the station where its command can carry it.
void limit_acceleration(const Turn& turn, const StationAxis& axis, ControllerVerb verb,
                        std::map<std::string, double>& values) {
  const auto& device = turn.station().devices[axis.device];
  const bool known = device.takes.contains(verb);  // else the value could be refused
  if (axis.max_acceleration && known && device.may_carry(verb, "acceleration"))
    values["acceleration"] = *axis.max_acceleration;
}

std::map<std::string, double> position_values(const Turn& turn, const StationAxis& axis, double position,
                                              std::optional<double> speed) {
  std::map<std::string, double> values{{"position", to_controller(axis, position)}};
  if (speed && turn.station().devices[axis.device].may_carry(ControllerVerb::position, "rate")) values["rate"] = *speed;
  limit_acceleration(turn, axis, ControllerVerb::position, values);
  return values;
}

bool turns(const AxisProgress& progress) {
  return progress.demand == Demand::rate || progress.demand == Demand::sine || progress.demand == Demand::moving;
}

bool goes(const AxisProgress& progress) {
  return turns(progress) || (progress.demand == Demand::position && !progress.settled);
}

void rest_axis(Turn& turn, std::size_t index, Purpose purpose) {
  const auto& axis = turn.station().axes[index];
  auto& progress = turn.state.axes[index];
  if (axis.kind == StationAxis::Kind::temperature) {
    progress.ramping = false;
    if (progress.demand == Demand::moving) progress.demand = Demand::none;
    return;
  }
  demand(progress, Demand::rest, 0.0);
  progress.at_rest = 0;
  send_motion(turn, index, ControllerVerb::stop, {}, purpose);
}

/// A rate that the command carries is the greatest of its way.
void note_fastest(Turn& turn, std::size_t index, const std::map<std::string, double>& values) {
  if (const auto rate = values.find("rate"); rate != values.end())
    turn.state.axes[index].watch.fastest = std::abs(rate->second);
}

void send_position(Turn& turn, std::size_t index, double position, std::optional<double> speed) {
  auto values = position_values(turn, turn.station().axes[index], position, speed);
  note_fastest(turn, index, values);
  turn.state.axes[index].goal = position;
  send_motion(turn, index, ControllerVerb::position, std::move(values));
}

/// A vibration that goes on until it is stopped.
void send_vibration(Turn& turn, std::size_t index, const Motion& motion) {
  const auto& axis = turn.station().axes[index];
  auto& progress = turn.state.axes[index];
  if (motion.kind == Kind::random) {
    demand(progress, Demand::sine, rms_of(motion));
    progress.period = 1.0 / motion.psd_frequency.front();
    return send_motion(turn, index, ControllerVerb::random, {{"rms", progress.value}});
  }
  demand(progress, Demand::sine, motion.amplitude);
  progress.period = 1.0 / motion.frequency;
  progress.watch.fastest = two_pi * motion.frequency * std::abs(motion.amplitude);
  std::map<std::string, double> values{{"amplitude", to_controller_rate(axis, motion.amplitude)},
                                       {"frequency", motion.frequency}};
  if (motion.phase != 0.0) values["phase"] = motion.phase;
  send_motion(turn, index, ControllerVerb::sine, std::move(values));
}

void set_ramp_point(Turn& turn, std::size_t index) {
  const auto& axis = turn.station().axes[index];
  auto& progress = turn.state.axes[index];
  const double span = progress.ramp_to - progress.ramp_from;
  const double gone = progress.ramp_rate * (turn.now() - progress.ramp_begin + axis.ramp_step);
  const double point = gone >= std::abs(span) ? progress.ramp_to : progress.ramp_from + std::copysign(gone, span);
  send_motion(turn, index, ControllerVerb::set_temperature, {{"temperature", to_controller(axis, point)}});
  progress.next_set = turn.now() + axis.ramp_step;
  if (point == progress.ramp_to) progress.ramping = false;
}

/// Brings a chamber to a temperature: at once, or by set points that do not go faster than the station allows.
void approach(Turn& turn, std::size_t index, double temperature) {
  const auto& axis = turn.station().axes[index];
  auto& progress = turn.state.axes[index];
  const double from = progress.temperature.value_or(temperature);
  demand(progress, Demand::temperature, temperature);
  progress.ramp_from = from;
  progress.ramp_to = temperature;
  progress.ramp_begin = turn.now();
  progress.ramping = axis.max_rate.has_value();
  progress.ramp_rate = axis.max_rate.value_or(0.0);
  if (progress.ramping) return set_ramp_point(turn, index);
  send_motion(turn, index, ControllerVerb::set_temperature, {{"temperature", to_controller(axis, temperature)}});
}

/// The motion of one axis before recording.
void send_axis(Turn& turn, std::size_t index, const Motion& motion) {
  const auto& axis = turn.station().axes[index];
  auto& progress = turn.state.axes[index];
  if (motion.kind == Kind::rate) {
    demand(progress, Demand::rate, motion.value);
    progress.turned = true;
    std::map<std::string, double> values{{"rate", to_controller_rate(axis, motion.value)}};
    limit_acceleration(turn, axis, ControllerVerb::rate, values);
    send_motion(turn, index, ControllerVerb::rate, std::move(values));
  } else if (motion.kind == Kind::sine || motion.kind == Kind::random) {
    send_vibration(turn, index, motion);
  } else if (axis.kind == StationAxis::Kind::acceleration) {
    rest_axis(turn, index, Purpose::motion);
  } else if (axis.kind == StationAxis::Kind::temperature) {
    approach(turn, index, motion.value);
  } else {
    demand(progress, Demand::position, motion.value);
    send_position(turn, index, position_of(axis, progress, motion.value, true), axis.speed);
  }
}

void begin_sweep(Turn& turn, std::size_t index, const Motion& motion) {
  const auto& axis = turn.station().axes[index];
  demand(turn.state.axes[index], Demand::sine, motion.amplitude);
  turn.state.axes[index].period = 1.0 / motion.frequency;
  turn.state.axes[index].watch.fastest =
      two_pi * std::max(motion.frequency, motion.to_frequency) * std::abs(motion.amplitude);
  send_motion(turn, index, ControllerVerb::sweep,
              {{"amplitude", to_controller_rate(axis, motion.amplitude)},
               {"frequency", motion.frequency},
               {"to_frequency", motion.to_frequency},
               {"duration", motion.lasts > 0.0 ? motion.lasts : turn.segment().duration}});
}

}  // namespace

std::map<std::string, Motion> motions_before_recording(const Turn& turn) {
  const auto& schedule = turn.course.schedule;
  std::map<std::string, Motion> motions;
  for (std::size_t i = 0; i <= turn.state.segment; ++i) {
    if (schedule[i].run != turn.segment().run) continue;
    for (const auto& [axis, motion] : schedule[i].axes) {
      const bool goes = motion.kind == Kind::ramp || motion.kind == Kind::slew || motion.kind == Kind::sweep;
      const bool stays = motion.kind == Kind::hold || motion.kind == Kind::dwell;
      if (i == turn.state.segment) {
        if (!goes) motions[axis] = motion;
      } else if (motion.kind != Kind::sweep && (goes || stays)) {
        motions[axis] = {.kind = Kind::hold, .value = goes ? motion.to : motion.value};
      } else {
        motions.erase(axis);
      }
    }
  }
  return motions;
}

void send_motions(Turn& turn) {
  const auto motions = motions_before_recording(turn);
  for (std::size_t i = 0; i < turn.station().axes.size(); ++i) {
    const auto found = motions.find(turn.station().axes[i].name);
    auto& progress = turn.state.axes[i];
    progress.ramping = false;
    if (found == motions.end() && turns(progress)) rest_axis(turn, i, Purpose::motion);
  }
  // after the stops, which some controllers cannot give to one axis only
  for (std::size_t i = 0; i < turn.station().axes.size(); ++i)
    if (const auto found = motions.find(turn.station().axes[i].name); found != motions.end())
      send_axis(turn, i, found->second);
  turn.state.motions_sent = true;
}

void begin_ramps(Turn& turn) {
  for (std::size_t i = 0; i < turn.station().axes.size(); ++i) {
    const auto& axis = turn.station().axes[i];
    auto& progress = turn.state.axes[i];
    const auto found = turn.segment().axes.find(axis.name);
    if (found == turn.segment().axes.end()) continue;
    const Motion& motion = found->second;
    if (motion.kind == Kind::sweep) begin_sweep(turn, i, motion);
    if (motion.kind != Kind::ramp && motion.kind != Kind::slew) continue;
    const double from =
        progress.demand == Demand::temperature ? progress.value : progress.temperature.value_or(motion.to);
    demand(progress, Demand::moving, motion.to);
    if (motion.kind == Kind::slew) {
      send_position(turn, i, position_of(axis, progress, motion.to, false), motion.value);
      continue;
    }
    progress.ramp_from = from;
    progress.ramp_to = motion.to;
    progress.ramp_rate = motion.value;
    progress.ramp_begin = turn.now();
    progress.ramping = true;
    set_ramp_point(turn, i);
  }
}

void continue_ramps(Turn& turn) {
  for (std::size_t i = 0; i < turn.state.axes.size(); ++i)
    if (turn.state.axes[i].ramping && turn.reached(turn.state.axes[i].next_set)) {
      set_ramp_point(turn, i);
      if (turn.state.axes[i].ramping) turn.reached(turn.state.axes[i].next_set);
    }
}

void end_ramps(Turn& turn) {
  for (std::size_t i = 0; i < turn.state.axes.size(); ++i) {
    auto& progress = turn.state.axes[i];
    progress.ramping = false;
    if (progress.demand != Demand::moving) continue;
    const bool warms = turn.station().axes[i].kind == StationAxis::Kind::temperature;
    demand(progress, warms ? Demand::temperature : Demand::position, progress.value);
  }
}

bool is_in_motion(const Turn& turn) { return std::ranges::any_of(turn.state.axes, goes); }

void rest_axes(Turn& turn, Purpose purpose) {
  for (std::size_t i = 0; i < turn.state.axes.size(); ++i)
    if (goes(turn.state.axes[i])) rest_axis(turn, i, purpose);
}

}  // namespace tumble::executive
