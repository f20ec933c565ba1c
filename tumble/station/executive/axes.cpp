#include <fmt/format.h>

#include <cmath>

#include "tumble/station/executive/turn.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/unit.hpp"

namespace tumble::executive {
namespace {

const char* quantity_of(Demand demand) {
  switch (demand) {
    case Demand::position:
      return "position";
    case Demand::rate:
      return "rate";
    case Demand::temperature:
      return "temperature";
    default:
      return "";
  }
}

double turned_difference(const StationAxis& axis, double difference) {
  return axis.kind == StationAxis::Kind::angle && axis.turns != StationAxis::Turns::limited
             ? std::remainder(difference, two_pi)
             : difference;
}

/// Departure of what is read from what is demanded; absent while nothing is read.
std::optional<double> departure(const StationAxis& axis, const AxisProgress& progress, std::optional<double> observed) {
  if (!observed) return std::nullopt;
  const double difference = *observed - progress.value;
  return progress.demand == Demand::position ? turned_difference(axis, difference) : difference;
}

std::optional<double> own_reading(const AxisProgress& progress) {
  switch (progress.demand) {
    case Demand::position:
      return progress.position;
    case Demand::rate:
      return progress.rate;
    case Demand::temperature:
      return progress.temperature;
    default:
      return std::nullopt;
  }
}

std::optional<double> tolerance_of(const StationAxis& axis, const AxisProgress& progress) {
  const auto& rule = axis.settle;
  if (progress.demand != Demand::rate) return rule.value;
  if (!rule.rate) return std::nullopt;
  return rate_tolerance(axis, progress.value);
}

std::optional<double> slope_tolerance(const StationAxis& axis, const AxisProgress& progress) {
  return progress.demand == Demand::rate ? axis.settle.rate_slope : axis.settle.rate;
}

bool is_within(const StationAxis& axis, const AxisProgress& progress, double difference) {
  const auto tolerance = tolerance_of(axis, progress);
  return !tolerance || std::abs(difference) <= *tolerance;
}

double slope_of(const SettleWindow& w) { return (w.n * w.tx - w.t * w.x) / (w.n * w.tt - w.t * w.t); }

/// An angle is the same after a whole turn; an axis that counts them, and has not begun to unwind, is not there yet.
bool is_at_goal(const StationAxis& axis, const AxisProgress& progress) {
  const bool counts = axis.turns == StationAxis::Turns::counted && progress.demand == Demand::position;
  return !counts || !progress.goal || !progress.position || std::abs(*progress.position - *progress.goal) < pi;
}

/// One more reading of what is demanded. An axis has settled when all readings of the hold time lay within tolerance,
/// and the line through them is flat enough.
void settle(const StationAxis& axis, AxisProgress& progress, double time, double difference) {
  auto& window = progress.window;
  if (!is_within(axis, progress, difference)) {
    window = {};
    progress.settled = false;
    return;
  }
  if (window.n == 0.0) window.begin = time;
  const double t = time - window.begin;
  window.n += 1.0;
  window.t += t;
  window.x += difference;
  window.tt += t * t;
  window.tx += t * difference;
  if (progress.settled || t < axis.settle.hold || window.n < 2.0) return;
  const auto slope = slope_tolerance(axis, progress);
  progress.settled = !slope || t == 0.0 || std::abs(slope_of(window)) <= *slope;
  progress.arrived = progress.arrived || (progress.settled && is_at_goal(axis, progress));
  if (!progress.settled) window = {};
}

/// A reading of what is demanded, from the axis itself or from the channel that the settle rule names.
void take_observation(Turn& turn, std::size_t index, std::optional<double> observed) {
  const auto& axis = turn.station().axes[index];
  auto& progress = turn.state.axes[index];
  if (*quantity_of(progress.demand) == '\0') return;
  const auto difference = departure(axis, progress, observed);
  if (!difference) return;
  progress.outside = is_within(axis, progress, *difference) ? 0 : progress.outside + 1;
  settle(axis, progress, turn.now(), *difference);
  if (!turn.state.recording) return;
  progress.sum += *difference;
  progress.count += 1.0;
}

/// One more position of an axis whose controller reads no rate. Returned: the slope of the line through those of the
/// last second, at least three; one resolution of the controller, or one late reply, weighs less than in a difference.
std::optional<double> rate_of_positions(const StationAxis& axis, AxisProgress& progress, double time, double position) {
  constexpr double span = 1.0;  // [s]
  constexpr std::size_t least = 3;
  auto& all = progress.turned_at;
  if (!all.empty() && time <= all.back().first) return progress.rate;
  if (!all.empty()) position = all.back().second + turned_difference(axis, position - all.back().second);
  all.emplace_back(time, position);
  while (all.size() > least && all.front().first < time - span) all.pop_front();
  SettleWindow line;
  for (const auto& [t, x] : all) {
    line.n += 1.0;
    line.t += t - time;
    line.x += x - position;
    line.tt += (t - time) * (t - time);
    line.tx += (t - time) * (x - position);
  }
  return all.size() < 2 ? progress.rate : std::optional(slope_of(line));
}

/// Whether the reply says where the axis is. Replies to commands repeat what was sent, and a state may be a number.
bool is_reading(const ControllerReply& reply) {
  if (reply.verb == ControllerVerb::read) return !reply.values.empty();
  return reply.verb == ControllerVerb::state &&
         (reply.values.contains("position") || reply.values.contains("rate") || reply.values.contains("temperature"));
}

/// [rad] by which the axis goes on at least, whatever it is told: to the next reading where a rate is demanded, and the
/// way of its brakes where the station states its greatest acceleration.
double way_ahead(const StationDevice& device, const StationAxis& axis, const AxisProgress& progress) {
  const double rate = *progress.rate;
  double way = progress.demand == Demand::rate ? rate * device.poll : 0.0;
  if (axis.max_acceleration) way += 0.5 * rate * std::abs(rate) / *axis.max_acceleration;
  return way;
}

/// Readings beyond the travel of the axis, or so near to its end that it cannot stop before it, one after the other,
/// while it goes on outwards. An axis that overshoots its last position comes back, and a wrapped one has no end.
void note_travel(const StationDevice& device, const StationAxis& axis, AxisProgress& progress) {
  constexpr double margin = 0.01;  // [1] of the travel
  const bool ends = axis.kind == StationAxis::Kind::angle && axis.turns != StationAxis::Turns::wrapped;
  if (!ends || !progress.position || !progress.rate) return;
  const double span = axis.lowest && axis.highest ? *axis.highest - *axis.lowest : two_pi;
  const double there = *progress.position + way_ahead(device, axis, progress);
  const double over = axis.highest ? there - *axis.highest : -1.0, under = axis.lowest ? *axis.lowest - there : -1.0;
  const double zero = zero_rate(axis);
  const bool outwards =
      (over > margin * span && *progress.rate > zero) || (under > margin * span && *progress.rate < -zero);
  progress.beyond = outwards ? progress.beyond + 1 : 0;
}

/// Values of the controller for the rig. The rate is that of the controller, or follows from positions.
void convert(Turn& turn, const StationAxis& axis, AxisProgress& progress, const ControllerReply& reply) {
  const auto value = [&](const char* name) -> std::optional<double> {
    const auto found = reply.values.find(name);
    if (found == reply.values.end()) return std::nullopt;
    return found->second;
  };
  if (const auto position = value("position")) progress.position = axis.sign * *position + axis.offset;
  if (const auto temperature = value("temperature")) progress.temperature = axis.sign * *temperature + axis.offset;
  if (const auto rate = value("rate"))
    progress.rate = axis.sign * *rate;
  else if (value("position"))
    progress.rate = rate_of_positions(axis, progress, turn.now(), *progress.position);
  progress.read_at = turn.now();
  if (!progress.rate || !(value("rate") || value("position"))) return;
  progress.at_rest = std::abs(*progress.rate) <= zero_rate(axis) ? progress.at_rest + 1 : 0;
  note_travel(turn.station().devices[axis.device], axis, progress);
  watch_rate(turn, axis, progress, !value("rate"));
}

void publish(Turn& turn, const std::string& channel, const std::optional<double>& value) {
  if (value) turn.state.channels[channel] = {*value, turn.now()};
}

bool needs_rest_reading(const StationAxis& axis, const AxisProgress& progress) {
  return progress.demand == Demand::rest && axis.kind == StationAxis::Kind::angle;
}

bool is_settled(Turn& turn, const StationAxis& axis, const AxisProgress& progress) {
  if (progress.demand == Demand::none || progress.demand == Demand::moving) return true;
  if (progress.demand == Demand::rest)
    return !needs_rest_reading(axis, progress) || progress.at_rest >= readings_at_rest;
  if (progress.demand == Demand::sine)
    return turn.reached(turn.state.entered + std::max(axis.settle.hold, 2.0 * progress.period));
  return progress.settled;
}

/// In units for people.
Name in_words(const StationAxis& axis, Demand what, double si) {
  if (what == Demand::temperature) return {fmt::format("{:.4g} K", si)};
  if (axis.kind == StationAxis::Kind::acceleration) return {fmt::format("{:.4g} m/s^2", si)};
  const Unit unit = Unit::parse(what == Demand::rate ? "deg/s" : "deg");
  return {fmt::format("{:.4g} {}", unit.difference_from_si(si), unit.text())};
}

std::map<std::string, double> by_channel(const Turn& turn, bool means) {
  std::map<std::string, double> values;
  for (std::size_t i = 0; i < turn.state.axes.size(); ++i) {
    const auto& progress = turn.state.axes[i];
    const auto& axis = turn.station().axes[i];
    const std::string quantity = quantity_of(progress.demand);
    if (quantity.empty() || (means && progress.count == 0.0)) continue;
    values[axis.name + "." + quantity] = progress.value + (means ? progress.sum / progress.count : 0.0);
  }
  return values;
}

}  // namespace

double zero_rate(const StationAxis& axis) { return axis.settle.rate.value_or(standard_zero); }

void take_reading(Turn& turn, std::size_t device, int number, const ControllerReply& reply) {
  bool is_axis = false;
  for (std::size_t i = 0; i < turn.station().axes.size(); ++i) {
    const auto& axis = turn.station().axes[i];
    if (axis.device != device || axis.number != number) continue;
    is_axis = true;
    if (!is_reading(reply)) continue;
    auto& progress = turn.state.axes[i];
    convert(turn, axis, progress, reply);
    publish(turn, axis.name + ".position", progress.position);
    publish(turn, axis.name + ".rate", progress.rate);
    publish(turn, axis.name + ".temperature", progress.temperature);
    if (axis.settle.channel.empty()) take_observation(turn, i, own_reading(progress));
  }
  if (is_axis) return;
  for (const auto& [key, value] : reply.values)
    turn.state.channels[turn.station().devices[device].name + "." + key] = {value, turn.now()};
}

void take_values(Turn& turn, const ChannelValues& values) {
  for (const auto& [channel, value] : values.values) turn.state.channels[channel] = {value, turn.now()};
  for (const auto& [channel, word] : values.words) turn.state.channels[channel] = {word, turn.now()};
  for (std::size_t i = 0; i < turn.station().axes.size(); ++i) {
    const auto found = values.values.find(turn.station().axes[i].settle.channel);
    if (found != values.values.end()) take_observation(turn, i, found->second);
  }
}

ChannelReading reading_of(const Turn& turn, const std::string& channel, double stale) {
  const auto found = turn.state.channels.find(channel);
  if (found == turn.state.channels.end() || turn.now() - found->second.time >= stale) return {};
  return found->second.value;
}

bool has_effect(const Turn& turn, std::size_t device, const ControllerRequest& request) {
  for (std::size_t i = 0; i < turn.station().axes.size(); ++i) {
    const auto& axis = turn.station().axes[i];
    const auto& progress = turn.state.axes[i];
    if (axis.device != device || axis.number != request.axis || !progress.rate) continue;
    if (request.verb == ControllerVerb::stop) return std::abs(*progress.rate) <= zero_rate(axis);
    if (request.verb == ControllerVerb::rate) {
      const double wanted = axis.sign * request.values.at("rate");
      return std::abs(*progress.rate - wanted) <= axis.settle.rate.value_or(0.0);
    }
    if (request.verb == ControllerVerb::position && progress.position && std::abs(*progress.rate) <= zero_rate(axis)) {
      const double wanted = axis.sign * request.values.at("position") + axis.offset;
      return std::abs(turned_difference(axis, *progress.position - wanted)) <= axis.settle.value.value_or(0.0);
    }
  }
  return false;
}

bool all_at_rest(const Turn& turn) {
  for (std::size_t i = 0; i < turn.state.axes.size(); ++i)
    if (needs_rest_reading(turn.station().axes[i], turn.state.axes[i]) && turn.state.axes[i].at_rest < readings_at_rest)
      return false;
  return true;
}

void restart_settling(Turn& turn) {
  turn.state.settle_by = turn.now() + settle_timeout(turn);
  using Power = ExecutiveState::Power;
  if (turn.state.power == Power::wait) turn.state.power = Power::off;  // the unit soaks where the axes are at rest
  for (auto& progress : turn.state.axes) {
    progress.window = {};
    progress.settled = false;
    progress.outside = 0;
  }
}

bool all_settled(Turn& turn) {
  bool all = true;
  for (std::size_t i = 0; i < turn.state.axes.size(); ++i)
    all = is_settled(turn, turn.station().axes[i], turn.state.axes[i]) && all;
  return all;
}

Sentence left_tolerance(const Turn& turn, int readings) {
  for (std::size_t i = 0; i < turn.state.axes.size(); ++i)
    if (turn.state.axes[i].outside >= readings) {
      const auto& axis = turn.station().axes[i];
      const auto& progress = turn.state.axes[i];
      return say("{} left its tolerance of {} about the demand", Name{axis.name},
                 in_words(axis, progress.demand, tolerance_of(axis, progress).value_or(0.0)));
    }
  return {};
}

Sentence why_not_settled(const Turn& turn) {
  std::vector<Sentence> all;
  for (std::size_t i = 0; i < turn.state.axes.size(); ++i) {
    const auto& axis = turn.station().axes[i];
    const auto& progress = turn.state.axes[i];
    if (progress.demand == Demand::none || progress.demand == Demand::moving || progress.settled) continue;
    const auto read = own_reading(progress);
    all.push_back(say("{} has not settled within {:.4g} s", Name{axis.name}, axis.settle.timeout));
    if (const auto difference = departure(axis, progress, read); difference && axis.settle.channel.empty())
      all.back() = say("{}: it reads {} from the demand, the tolerance is {}", all.back(),
                       in_words(axis, progress.demand, *difference),
                       in_words(axis, progress.demand, tolerance_of(axis, progress).value_or(0.0)));
  }
  return all.size() == 1 ? all.front() : in_a_row(all, "; ");
}

double settle_timeout(const Turn& turn) {
  double longest = 1.0;
  for (std::size_t i = 0; i < turn.state.axes.size(); ++i)
    if (const auto& progress = turn.state.axes[i]; progress.demand != Demand::none) {
      const double way = progress.ramping ? std::abs(progress.ramp_to - progress.ramp_from) / progress.ramp_rate : 0.0;
      longest = std::max(longest, turn.station().axes[i].settle.timeout + way);
    }
  return longest;
}

double soak_time(const Turn& turn) {
  double longest = 0.0;
  for (const auto& axis : turn.station().axes)
    if (turn.segment().axes.contains(axis.name)) longest = std::max(longest, axis.settle.soak);
  return longest;
}

void begin_means(Turn& turn) {
  for (auto& progress : turn.state.axes) progress.sum = progress.count = 0.0;
}

std::map<std::string, double> demanded(const Turn& turn) { return by_channel(turn, false); }
std::map<std::string, double> achieved(const Turn& turn) { return by_channel(turn, true); }

}  // namespace tumble::executive
