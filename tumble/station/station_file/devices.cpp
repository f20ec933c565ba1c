#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "tumble/station/station_file/draft.hpp"
#include "tumble/units/error.hpp"

namespace tumble::station_file {
namespace {

using Kind = StationAxis::Kind;

/// In which units the file speaks of an axis. A temperature is a point on a scale, its tolerances are differences.
struct AxisScale {
  explicit AxisScale(Kind kind)
      : point(Unit::parse(kind == Kind::angle         ? "deg"
                          : kind == Kind::temperature ? "degC"
                                                      : "m/s^2")),
        difference(Unit::parse(kind == Kind::angle         ? "deg"
                               : kind == Kind::temperature ? "K"
                                                           : "m/s^2")),
        rate(Unit::parse("(" + difference.text() + ")/s")),
        acceleration(Unit::parse(kind == Kind::acceleration ? "m/s^2" : "(" + difference.text() + ")/s^2")) {}
  Unit point, difference, rate, acceleration;
};

void must_be_positive(Section& section, const std::string& key, std::optional<double> value) {
  if (value && !(*value > 0.0)) section.problem_at(key, "must be above zero");
}

void read_settle(Section& axis_section, const toml::table& table, const AxisScale& scale, StationAxis& axis,
                 FileProblems& problems) {
  Section section(table, axis_section.name() + " settle", problems);
  auto& rule = axis.settle;
  const Unit second = Unit::parse("s");
  const std::string value_key = axis.kind == Kind::temperature ? "temperature" : "position";
  rule.value = section.quantity(value_key, scale.difference);
  rule.rate = section.quantity("rate", scale.rate);
  rule.relative_rate = section.quantity("relative_rate", Unit()).value_or(0.0);
  if (axis.kind == Kind::angle) rule.rate_slope = section.quantity("rate_slope", scale.acceleration);
  rule.hold = section.quantity("hold", second).value_or(rule.hold);
  rule.timeout = section.quantity("timeout", second).value_or(axis.kind == Kind::temperature ? 4e3 : rule.timeout);
  rule.soak = section.quantity("soak", second).value_or(0.0);
  rule.channel = section.text("channel").value_or("");
  must_be_positive(section, value_key, rule.value);
  must_be_positive(section, "rate", rule.rate);
  must_be_positive(section, "rate_slope", rule.rate_slope);
  must_be_positive(section, "timeout", rule.timeout);
  if (rule.relative_rate < 0.0) section.problem_at("relative_rate", "must not be negative");
  if (rule.hold < 0.0) section.problem_at("hold", "must not be negative");
  if (rule.soak < 0.0) section.problem_at("soak", "must not be negative");
  if (rule.timeout <= rule.hold) section.problem_at("timeout", "must be longer than `hold`");
  if (!rule.value && !table.contains(value_key) && axis.kind != Kind::acceleration)
    section.missing(value_key, axis.kind == Kind::temperature ? "\"0.5 K\"" : "\"0.001 deg\"");
  if (!rule.rate && !table.contains("rate") && axis.kind == Kind::angle) section.missing("rate", "\"0.001 deg/s\"");
  section.close();
}

void read_limits(Section& section, const AxisScale& scale, StationAxis& axis) {
  axis.offset = section.quantity("offset", scale.difference).value_or(0.0);
  axis.lowest = section.quantity("lowest", scale.point);
  axis.highest = section.quantity("highest", scale.point);
  axis.max_rate = section.quantity("max_rate", scale.rate);
  axis.max_acceleration = section.quantity("max_acceleration", scale.acceleration);
  must_be_positive(section, "max_rate", axis.max_rate);
  must_be_positive(section, "max_acceleration", axis.max_acceleration);
  if (axis.kind != Kind::temperature) axis.clips_at = section.quantity("clips_at", Unit());
  if (axis.clips_at && !(*axis.clips_at >= 1.0))
    section.problem_at("clips_at", "is in standard deviations, 1 or more; most drives clip at 3");
  if (axis.lowest && axis.highest && *axis.lowest >= *axis.highest)
    section.problem_at("lowest", "must lie below `highest`");
  if (axis.kind == Kind::angle) {
    axis.speed = section.quantity("speed", scale.rate);
    must_be_positive(section, "speed", axis.speed);
    if (axis.speed && axis.max_rate && *axis.speed > *axis.max_rate * (1.0 + 1e-9))
      section.problem_at("speed", "must not be above `max_rate`");
    axis.turns =
        static_cast<StationAxis::Turns>(choice(section, "turns", {"limited", "wrapped", "counted"}).value_or(0));
  }
  if (axis.kind == Kind::temperature) {
    axis.ramp_step = section.quantity("ramp_step", Unit::parse("s")).value_or(axis.ramp_step);
    if (axis.ramp_step < 10.0 || axis.ramp_step > 60.0) section.problem_at("ramp_step", "must be from 10 s to 60 s");
  }
}

void read_sign(Section& section, StationAxis& axis) {
  const auto* node = section.find("sign");
  if (!node) return;
  const auto* integer = node->as_integer();
  if (integer && (integer->get() == 1 || integer->get() == -1))
    axis.sign = static_cast<int>(integer->get());
  else
    section.problem_at("sign", "1 or -1 is expected");
}

void read_axis(const toml::table& table, std::size_t device, Draft& draft) {
  Section section(table, "[[device.axis]]", draft.problems);
  StationAxis axis;
  axis.device = device;
  axis.name = needed(section, "rig", "\"table\", the axis of the rig as plans call it");
  axis.number = section.integer("number").value_or(1);
  if (axis.number < 1) section.problem_at("number", "axes count from 1");
  axis.kind = static_cast<Kind>(choice(section, "moves", {"angle", "temperature", "acceleration"}).value_or(0));
  const AxisScale scale(axis.kind);
  read_sign(section, axis);
  read_limits(section, scale, axis);
  axis.retries = section.integer("retries").value_or(axis.retries);
  axis.on_failure = static_cast<OnFailure>(choice(section, "on_failure", {"ask", "skip", "stop"}).value_or(0));
  if (const auto* settle = section.table("settle"))
    read_settle(section, *settle, scale, axis, draft.problems);
  else if (!table.contains("settle") && axis.kind != Kind::acceleration)
    section.missing("settle", axis.kind == Kind::temperature
                                  ? "{temperature = \"0.5 K\", hold = \"60 s\"}"
                                  : "{position = \"0.001 deg\", rate = \"0.001 deg/s\", hold = \"2 s\"}");
  section.close();
  for (const auto& other : draft.station.axes)
    if (other.device == device && other.number == axis.number)
      section.problem_at("number", say("axis {} of this controller is '{}' already", axis.number, other.name));
  draft.station.axes.push_back(std::move(axis));
}

/// "none", or "stops in 1 s".
void read_lost_link(Section& section, StationDevice& device) {
  const auto text = section.text("on_lost_link");
  if (!text || *text == "none") return;
  const std::string start = "stops in ";
  try {
    if (!text->starts_with(start)) throw Error(Error::Kind::bad_input, "\"none\" or \"stops in 1 s\" is expected");
    device.stops_by_itself = parse_si(text->substr(start.size()), Unit::parse("s"));
    if (!(*device.stops_by_itself >= 0.0)) throw Error(Error::Kind::bad_input, "the time must not be negative");
  } catch (const Error& error) {
    for (const auto& problem : error.problems) section.problem_at("on_lost_link", problem);
  }
}

void read_times(Section& section, StationDevice& device, Draft& draft, bool turns) {
  const Unit second = Unit::parse("s");
  device.poll = section.quantity("poll", second).value_or(turns ? 0.1 : 1.0);
  device.timeout = section.quantity("timeout", second).value_or(turns ? 0.25 : 2.0);
  device.lost_after = section.quantity("lost_after", second).value_or(turns ? 0.5 : 10.0);
  must_be_positive(section, "poll", device.poll);
  must_be_positive(section, "timeout", device.timeout);
  must_be_positive(section, "lost_after", device.lost_after);
  const auto* table = section.table("timeouts");
  if (!table) return;
  Section times(*table, section.name() + " timeouts", draft.problems);
  for (const auto& word : times.unread()) {
    const auto time = times.quantity(word, second);
    const auto verb = find_verb(word);
    if (!verb) times.problem_at(word, unknown_verb(word));
    if (!time || !verb) continue;
    device.timeouts[*verb] = *time;
    must_be_positive(times, word, time);
  }
}

void read_link(Section& section, StationDevice& device) {
  device.link = needed(section, "link", "\"tcp:192.168.1.20:9878\"");
  if (!device.link.empty() && !device.link.starts_with("tcp:") && !device.link.starts_with("serial:"))
    section.problem_at("link", "tcp:HOST:PORT or serial:DEVICE[:BAUD[:8N1]] is expected");
}

void read_settings(Section& section, StationDevice& device, Draft& draft) {
  const auto* table = section.table("settings");
  if (!table) return;
  Section settings(*table, section.name() + " settings", draft.problems);
  for (const auto& key : settings.unread())
    if (const auto text = settings.text(key)) device.settings[key] = *text;
}

/// The verbs that a key names; another word is refused.
std::vector<ControllerVerb> verbs_at(Section& section, const char* key, const StationDevice& device) {
  std::vector<ControllerVerb> verbs;
  for (const auto& word : section.texts(key)) {
    const auto verb = find_verb(word);
    if (verb) verbs.push_back(*verb);
    if (!device.verbs.empty() && (!verb || !device.can(*verb)))
      section.problem_at(key, say("{} has no verb '{}'", Name{device.controller}, word));
    else if (!verb)
      section.problem_at(key, unknown_verb(word));
  }
  return verbs;
}

/// What a device does before and after the segments, where the file does not say it: nothing that moves an axis, and no
/// verb of `needing`, which want a value.
void default_conduct(Section& section, StationDevice& device, bool moves, const std::vector<ControllerVerb>& needing) {
  const auto those = [&](std::initializer_list<ControllerVerb> verbs) {
    std::vector<ControllerVerb> list;
    for (const ControllerVerb verb : verbs) {
      const bool starts_motion = moves && verb == ControllerVerb::start;
      if (device.can(verb) && !starts_motion && std::ranges::find(needing, verb) == needing.end()) list.push_back(verb);
    }
    return list;
  };
  device.prepare = section.find("prepare")
                       ? verbs_at(section, "prepare", device)
                       : those({ControllerVerb::identify, ControllerVerb::take, ControllerVerb::clear_fault,
                                ControllerVerb::enable, ControllerVerb::start});
  device.finish = section.find("finish") ? verbs_at(section, "finish", device) : those({ControllerVerb::release});
}

/// A request is answered after the pauses that its declaration wants.
void add_pauses(StationDevice& device, const ControllerCommand& command) {
  double pauses = 0.0;
  for (const ControllerExchange& exchange : command.exchanges) pauses += exchange.pause;
  if (pauses > 0.0) device.timeouts.try_emplace(command.verb, device.timeout + pauses);
}

/// Whether the verb cannot be sent by itself, before anything else was: it, or a line with all axes, wants a value.
bool needs_value(const ControllerCommand& command) {
  const auto is_missing = [](const ControllerPiece& piece) {
    return piece.kind == ControllerPiece::Kind::number && piece.axis > 0 && !piece.otherwise;
  };
  return !command.requires_.empty() || std::ranges::any_of(command.exchanges, [&](const ControllerExchange& exchange) {
    return std::ranges::any_of(exchange.send.pieces, is_missing);
  });
}

/// What the controller can do, where the file does not say it: as its declaration has it. Returned: verbs that need a
/// value.
std::vector<ControllerVerb> read_verbs(Section& section, StationDevice& device, const Draft& draft) {
  std::vector<ControllerVerb> needing;
  device.once = verbs_at(section, "once", device);
  device.verbs = verbs_at(section, "verbs", device);
  if (!device.verbs.empty() || device.controller.empty()) return needing;
  try {
    for (const ControllerCommand& command : controller_of_device(device, draft.folder).commands) {
      device.verbs.push_back(command.verb);
      device.takes[command.verb] = command.takes;
      if (needs_value(command)) needing.push_back(command.verb);
      if (command.once) device.once.push_back(command.verb);
      add_pauses(device, command);
    }
  } catch (const Error& error) {
    for (const auto& problem : error.problems) section.problem_at("controller", problem);
  }
  return needing;
}

void read_device(const toml::table& table, Draft& draft) {
  Section section(table, "[[device]]", draft.problems);
  const std::size_t index = draft.station.devices.size();
  const std::size_t first = draft.station.axes.size();
  StationDevice device;
  device.name = needed(section, "name", "\"table\"");
  device.controller = needed(section, "controller", "\"acutrol_like\"");
  read_settings(section, device, draft);
  read_link(section, device);
  for (const auto* axis : tables_at(section, "axis", "[[device.axis]]")) read_axis(*axis, index, draft);
  const auto axes = std::span(draft.station.axes).subspan(first);
  const auto is_kind = [](Kind kind) { return [kind](const StationAxis& axis) { return axis.kind == kind; }; };
  const bool turns = std::ranges::any_of(axes, is_kind(Kind::angle));
  const bool shakes = std::ranges::any_of(axes, is_kind(Kind::acceleration));
  read_times(section, device, draft, turns);
  read_lost_link(section, device);
  device.identity = section.text("identity").value_or("");
  const auto needing = read_verbs(section, device, draft);
  default_conduct(section, device, turns || shakes, needing);
  section.close();
  draft.station.devices.push_back(std::move(device));
}

}  // namespace

void read_devices(Section& root, Draft& draft) {
  const auto list = tables_at(root, "device", "[[device]]");
  for (const auto* table : list) read_device(*table, draft);
  if (list.empty()) root.problem("[[device]]: a station needs one or more devices");
}

}  // namespace tumble::station_file
