
#include <algorithm>
#include <cmath>

#include "tumble/station/executive/turn.hpp"
#include "tumble/units/unit.hpp"

namespace tumble::executive {
namespace {

constexpr double polls_to_confirm = 3.0;

Name in_degrees(double si) { return {format_in(si, Unit::parse("degC")) + " degC"}; }

}  // namespace

void expect_set_point(Turn& turn, std::size_t device, const ControllerRequest& request) {
  const auto& setup = turn.station().devices[device];
  const auto value = request.values.find("temperature");
  if (request.verb != ControllerVerb::set_temperature || !setup.set_point_verb || value == request.values.end()) return;
  auto& progress = turn.state.devices[device];
  std::erase_if(progress.set_points, [&](const OpenSetPoint& one) { return one.axis == request.axis; });
  progress.set_points.push_back(
      {request.axis, value->second,
       turn.now() + polls_to_confirm * setup.poll + time_to_answer(setup, *setup.set_point_verb)});
  ask(turn, device, {{*setup.set_point_verb, {}, request.axis}});
}

std::vector<ControllerRequest> polls_of_set_points(const Turn& turn, std::size_t device) {
  std::vector<ControllerRequest> polls;
  for (const auto& one : turn.state.devices[device].set_points)
    polls.push_back({turn.station().devices[device].set_point_verb.value_or(ControllerVerb::set_point), {}, one.axis});
  return polls;
}

void take_set_point(Turn& turn, std::size_t device, int axis, const ControllerReply& reply) {
  const auto& setup = turn.station().devices[device];
  const auto value = reply.values.find("set_point");
  if (reply.verb != setup.set_point_verb || value == reply.values.end()) return;
  std::erase_if(turn.state.devices[device].set_points, [&](const OpenSetPoint& one) {
    return one.axis == axis && std::abs(value->second - one.value) <= setup.set_point_step;
  });
  turn.state.channels[setup.name + ".set_point"] = {value->second, turn.now()};
}

bool has_open_set_points(const Turn& turn) {
  return std::ranges::any_of(turn.state.devices, [](const DeviceProgress& one) { return !one.set_points.empty(); });
}

void check_set_points(Turn& turn, std::size_t device) {
  const auto& setup = turn.station().devices[device];
  auto& progress = turn.state.devices[device];
  std::erase_if(progress.set_points, [&](const OpenSetPoint& one) {
    if (!turn.reached(one.due)) return false;
    const auto read = turn.state.channels.find(setup.name + ".set_point");
    const auto* last = read == turn.state.channels.end() ? nullptr : std::get_if<double>(&read->second.value);
    turn.state.failures[setup.name] =
        say("{} has acknowledged a set point of {}, and {}", Name{setup.name}, in_degrees(one.value),
            last ? say("reads back {}", in_degrees(*last)) : Sentence("it could not be read back"));
    return true;
  });
}

}  // namespace tumble::executive
