#include "tumble/rehearsal/virtual_device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace tumble {
namespace {

using Kind = Motion::Kind;

/// One request at one axis, and the reply that is being written.
struct Asked {
  VirtualRig& rig;
  double time;
  VirtualDevice& device;
  const ControllerRequest& request;
  std::string axis;
  ControllerReply reply;

  /// A value of the request [SI]; a missing one is refused.
  double need(const std::string& name) {
    const auto found = request.values.find(name);
    if (found != request.values.end() && std::isfinite(found->second)) return found->second;
    refuse(say("{} needs a value of {}", Name{tumble::name(request.verb)}, Name{name}));
    return 0.0;
  }
  double value_or(const std::string& name, double otherwise) const {
    const auto found = request.values.find(name);
    return found == request.values.end() ? otherwise : found->second;
  }
  void refuse(const std::string& why) {
    if (why.empty()) return;
    reply.refused = true;
    reply.text = reply.text.empty() ? say("{}", Name{why}) : say("{}; {}", reply.text, Name{why});
  }
  void order(const Motion& motion) {
    if (!reply.refused) refuse(rig.command(time, axis, motion));
  }
};

void answer_position(Asked& asked) {
  const double position = asked.need("position"), rate = asked.value_or("rate", 0.0);
  asked.order(rate > 0.0 ? Motion{.kind = Kind::slew, .value = rate, .to = position} : Motion{.value = position});
}

void answer_rate(Asked& asked) { asked.order({.kind = Kind::rate, .value = asked.need("rate")}); }

void answer_sine(Asked& asked) {
  const double amplitude = asked.need("amplitude"), frequency = asked.need("frequency");
  asked.order(
      {.kind = Kind::sine, .amplitude = amplitude, .frequency = frequency, .phase = asked.value_or("phase", 0.0)});
}

void answer_sweep(Asked& asked) {
  const double amplitude = asked.need("amplitude"), from = asked.need("frequency"), to = asked.need("to_frequency");
  asked.order({.kind = Kind::sweep,
               .amplitude = amplitude,
               .frequency = from,
               .to_frequency = to,
               .lasts = asked.need("duration")});
}

/// The shaker has the profiles of the plan; that of this level is played.
void answer_random(Asked& asked) {
  const double rms = asked.need("rms");
  const auto& profiles = asked.device.profiles;
  const auto found = std::ranges::find_if(
      profiles, [&](const Motion& profile) { return std::abs(rms_of(profile) - rms) <= 1e-3 * std::abs(rms); });
  if (found == profiles.end()) return asked.refuse("there is no profile of this level");
  asked.order(*found);
}

void answer_home(Asked& asked) { asked.order({.value = 0.0}); }

void answer_stop(Asked& asked) { asked.refuse(asked.rig.stop(asked.time, asked.axis)); }

void answer_enable(Asked& asked) { asked.rig.enable(asked.time, asked.axis, true); }

void answer_disable(Asked& asked) { asked.rig.enable(asked.time, asked.axis, false); }

void answer_clear(Asked& asked) { asked.rig.clear_fault(asked.time, asked.axis); }

/// Sends the chamber to its set point.
void go_to_set_point(Asked& asked) {
  const auto& memory = asked.device.memory[asked.axis];
  if (memory.off || !memory.set_point) return;
  asked.order(memory.ramp > 0.0 ? Motion{.kind = Kind::ramp, .value = memory.ramp, .to = *memory.set_point}
                                : Motion{.kind = Kind::dwell, .value = *memory.set_point});
}

void answer_temperature(Asked& asked) {
  const double temperature = asked.need("temperature");
  if (asked.reply.refused || !asked.rig.obeys(asked.axis)) return;
  auto& memory = asked.device.memory[asked.axis];
  const auto before = memory.set_point;
  memory.set_point = temperature;
  memory.ramp = asked.value_or("ramp", memory.ramp);
  go_to_set_point(asked);
  if (asked.reply.refused) memory.set_point = before;
}

void answer_ramp(Asked& asked) {
  const double ramp = asked.need("ramp");
  if (!asked.reply.refused) asked.device.memory[asked.axis].ramp = std::abs(ramp);
}

void answer_start(Asked& asked) {
  asked.device.memory[asked.axis].off = false;
  go_to_set_point(asked);
}

/// Also of a table: it stops.
void answer_off(Asked& asked) {
  asked.device.memory[asked.axis].off = true;
  answer_stop(asked);
}

/// Where all axes of the controller are: replies of any verb may carry it.
void add_readings(Asked& asked) {
  const auto add = [&](const std::string& axis, const std::string& tail) {
    auto& values = asked.reply.values;
    const AxisReading now = asked.rig.reading(asked.time, axis);
    if (asked.rig.is_temperature(axis)) {
      values["temperature" + tail] = now.value;
      values["set_point" + tail] = asked.device.memory[axis].set_point.value_or(now.value);
      if (asked.request.verb == ControllerVerb::set_point) values["temperature" + tail] = values["set_point" + tail];
    } else {
      values["position" + tail] = now.value;
      values["rate" + tail] = now.rate;
    }
  };
  add(asked.axis, "");
  for (std::size_t i = 0; i < asked.device.axes.size(); ++i)
    if (!asked.device.axes[i].empty()) add(asked.device.axes[i], "." + std::to_string(i + 1));
  for (const auto& [name, value] : asked.request.values) asked.reply.values[name] = value;  // some repeat what was sent
}

void answer_state(Asked& asked) {
  const AxisReading now = asked.rig.reading(asked.time, asked.axis);
  const bool chamber = asked.rig.is_temperature(asked.axis), off = asked.device.memory[asked.axis].off;
  const char* state = !now.fault.empty() ? "fault"
                      : !now.enabled     ? "disabled"
                      : chamber          ? (off ? "off" : "running")
                      : now.moving       ? "moving"
                                         : "ready";
  asked.reply.words = {{"state", state},
                       {"moving", now.moving ? "yes" : "no"},
                       {"ready", now.reached && now.enabled && now.fault.empty() ? "yes" : "no"},
                       {"fault", now.fault.empty() ? "none" : now.fault}};
}

void answer_identify(Asked& asked) { asked.reply.words = {{"identity", "virtual rig, " + asked.device.name}}; }

void acknowledge(Asked&) {}

using CarryOut = void (*)(Asked&);

const std::map<ControllerVerb, CarryOut>& verbs() {
  static const std::map<ControllerVerb, CarryOut> all{
      {ControllerVerb::identify, answer_identify}, {ControllerVerb::take, acknowledge},
      {ControllerVerb::release, acknowledge},      {ControllerVerb::enable, answer_enable},
      {ControllerVerb::disable, answer_disable},   {ControllerVerb::home, answer_home},
      {ControllerVerb::rate, answer_rate},         {ControllerVerb::position, answer_position},
      {ControllerVerb::sine, answer_sine},         {ControllerVerb::sweep, answer_sweep},
      {ControllerVerb::random, answer_random},     {ControllerVerb::stop, answer_stop},
      {ControllerVerb::read, acknowledge},         {ControllerVerb::state, answer_state},
      {ControllerVerb::clear_fault, answer_clear}, {ControllerVerb::set_temperature, answer_temperature},
      {ControllerVerb::set_ramp, answer_ramp},     {ControllerVerb::start, answer_start},
      {ControllerVerb::hold, answer_stop},         {ControllerVerb::off, answer_off},
      {ControllerVerb::resume, answer_start},      {ControllerVerb::set_point, acknowledge},
      {ControllerVerb::alarm, acknowledge},        {ControllerVerb::set_voltage, acknowledge},
      {ControllerVerb::set_current, acknowledge},  {ControllerVerb::set_limits, acknowledge}};
  return all;
}

/// The supply of the instruments.
void answer_supply(Asked& asked) {
  const ControllerVerb verb = asked.request.verb;
  VirtualDevice& supply = asked.device;
  if (verb == ControllerVerb::set_voltage) supply.voltage = asked.need("voltage");
  if (verb == ControllerVerb::set_current) supply.current = asked.need("current");
  if (verb == ControllerVerb::enable || verb == ControllerVerb::start) asked.rig.power(asked.time, true);
  if (verb == ControllerVerb::disable || verb == ControllerVerb::off || verb == ControllerVerb::stop)
    asked.rig.power(asked.time, false);
  const bool on = asked.rig.power_up() > 0;
  asked.reply.values = {{"voltage", on ? supply.voltage : 0.0}, {"current", on ? supply.current : 0.0}};
  asked.reply.words = {{"state", on ? "running" : "off"}, {"fault", "none"}};
  if (verb == ControllerVerb::identify) answer_identify(asked);
}

}  // namespace

std::vector<std::string> virtual_verbs() {
  std::vector<std::string> names;
  for (const auto& [verb, carry_out] : verbs()) names.push_back(name(verb));
  std::ranges::sort(names);
  return names;
}

ControllerReply answer(VirtualRig& rig, double time, VirtualDevice& device, const ControllerRequest& request) {
  Asked asked{rig, time, device, request, {}, {.verb = request.verb, .axis = request.axis}};
  const auto verb = verbs().find(request.verb);
  const auto axis = static_cast<std::size_t>(request.axis - 1);
  if (verb == verbs().end()) {
    asked.refuse(say("{} does not know '{}'", Name{device.name}, name(request.verb)));
  } else if (request.axis < 1 || axis >= device.axes.size()) {
    asked.refuse(say("{} has no axis {}", Name{device.name}, request.axis));
  } else {
    asked.axis = device.axes[axis];
    if (asked.axis == "power")
      answer_supply(asked);
    else {
      verb->second(asked);
      add_readings(asked);
    }
  }
  return std::move(asked.reply);
}

}  // namespace tumble
