#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <set>
#include <span>

#include "tumble/core/tables/document.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/formats/confinement.hpp"
#include "tumble/station/station_file/draft.hpp"
#include "tumble/station/station_file/motion_limits.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"
#include "tumble/wire/instruments.hpp"

namespace tumble {
namespace station_file {
namespace {

const Unit& seconds() {
  static const Unit unit = Unit::parse("s");
  return unit;
}

std::optional<Requirement> requirement_at(Section& section, const std::string& key) {
  const auto text = section.text(key);
  if (!text) return std::nullopt;
  try {
    return parse_requirement(*text);
  } catch (const Error& error) {
    for (const auto& problem : error.problems) section.problem_at(key, problem);
    return std::nullopt;
  }
}

void read_requirement(Section& section, Draft& draft, bool may_stop) {
  StationInterlock interlock;
  const auto require = requirement_at(section, "require");
  if (!section.find("require")) section.missing("require", "\"chamber.temperature < 90 degC\"");
  interlock.action = StationInterlock::Action::hold;
  if (may_stop && choice(section, "action", {"stop", "hold"}).value_or(0) == 0)
    interlock.action = StationInterlock::Action::stop;
  interlock.debounce = section.quantity("debounce", seconds()).value_or(0.0);
  interlock.stale = section.quantity("stale", seconds()).value_or(interlock.stale);
  if (interlock.debounce < 0.0) section.problem_at("debounce", "must not be negative");
  if (interlock.stale <= 0.0) section.problem_at("stale", "must be above zero");
  section.close();
  if (!require) return;
  interlock.require = *require;
  draft.station.interlocks.push_back(std::move(interlock));
}

void read_instrument(Section& section, Draft& draft) {
  StationInstrument instrument;
  instrument.slot = needed(section, "slot", "\"1\"");
  instrument.frames = section.text("frames").value_or("");
  instrument.link = section.text("link").value_or("");
  instrument.rate = section.quantity("rate", Unit::parse("Hz")).value_or(0.0);
  if (section.find("rate") && instrument.rate <= 0.0) section.problem_at("rate", "must be above zero");
  instrument.start = !section.find("start") || flag(section, "start");
  instrument.start_within = section.quantity("start_within", seconds()).value_or(instrument.start_within);
  if (!(instrument.start_within > 0.0 && instrument.start_within <= 100.0))
    section.problem_at("start_within", "must be above zero, and 100 s at most");
  if (instrument.frames.empty() != instrument.link.empty())
    section.problem("a stream needs both `frames`, its declaration, and `link`");
  for (const auto& other : draft.station.instruments)
    if (other.slot == instrument.slot && !other.slot.empty())
      section.problem_at("slot", say("there are two slots '{}'", instrument.slot));
  try {
    const auto choice = parse_instrument(instrument.frames);
    if (std::filesystem::path(choice.name).extension() == ".toml") {
      const auto path = file_named_in(draft.folder, choice.name);
      if (!std::filesystem::exists(path)) section.problem_at("frames", say("there is no file {}", Name{path}));
    } else if (!instrument.frames.empty()) {
      find_instrument(choice.name);
    }
  } catch (const Error& error) {
    for (const auto& problem : error.problems) section.problem_at("frames", problem);
  }
  section.close();
  draft.station.instruments.push_back(std::move(instrument));
}

/// What the chamber is told when something is wrong keeps to the limits as well.
void check_safe_temperature(Section& section, const SafeCommand& command, double temperature, const Station& station) {
  const Unit celsius = Unit::parse("degC");
  constexpr double coldest = 0.0, hottest = 1273.15;  // [K] of any chamber
  bool limited = false;
  for (const StationAxis& axis : station.axes) {
    if (axis.device != command.device || axis.number != command.request.axis) continue;
    limited = limited || (axis.lowest && axis.highest);
    for (const auto& problem : beyond_limits_of_safe(axis, temperature)) section.problem_at("temperature", problem);
  }
  if (!limited && !(temperature > coldest && temperature <= hottest))
    section.problem_at("temperature",
                       say("{:.6g} degC is not a temperature of a chamber; above {:.6g} degC and "
                           "up to {:.6g} degC is accepted",
                           celsius.from_si(temperature), celsius.from_si(coldest), celsius.from_si(hottest)));
}

std::vector<std::string> words_of(std::span<const ControllerVerb> verbs) {
  std::vector<std::string> words;
  for (const ControllerVerb verb : verbs) words.push_back(name(verb));
  return words;
}

void read_safe_command(Section& section, Draft& draft) {
  SafeCommand command;
  const auto device = device_at(section, "device", draft.station);
  const std::string word = needed(section, "verb", "\"stop\"");
  const auto verb = find_verb(word);
  command.request.verb = verb.value_or(ControllerVerb{});
  command.request.axis = section.integer("axis").value_or(1);
  command.confirm = requirement_at(section, "confirm");
  command.within = section.quantity("within", seconds()).value_or(command.within);
  command.wait = flag(section, "wait");
  command.words = section.text("words").value_or("");
  constexpr std::array harmless{ControllerVerb::stop,    ControllerVerb::hold,    ControllerVerb::off,
                                ControllerVerb::disable, ControllerVerb::release, ControllerVerb::set_temperature};
  const auto temperature = section.quantity("temperature", Unit::parse("degC"));
  const bool sets = verb == ControllerVerb::set_temperature;
  if (sets && !temperature && !section.find("temperature")) section.missing("temperature", "\"23 degC\"");
  if (!sets && section.find("temperature")) section.problem_at("temperature", "is for verb = \"set_temperature\"");
  if (sets && temperature) command.request.values["temperature"] = *temperature;
  if (!word.empty() && std::ranges::find(harmless, verb) == harmless.end())
    section.problem_at("verb",
                       say("'{}' is not for a safe list; accepted: {}", word, fmt::join(words_of(harmless), ", ")));
  if (command.within <= 0.0) section.problem_at("within", "must be above zero");
  section.close();
  if (!device) return;
  const auto& setup = draft.station.devices[*device];
  if (!setup.verbs.empty() && !word.empty() && (!verb || !setup.can(*verb)))
    section.problem_at("verb", say("{} has no verb '{}'", Name{setup.controller}, word));
  command.device = *device;
  if (sets && temperature) check_safe_temperature(section, command, *temperature, draft.station);
  draft.station.safe.push_back(std::move(command));
}

/// What is safe where the file does not say it: axes stop, chambers hold, and then the unit is switched off.
void default_safe_list(Draft& draft) {
  auto& station = draft.station;
  for (const auto& axis : station.axes)
    if (axis.kind != StationAxis::Kind::temperature)
      station.safe.push_back({.device = axis.device, .request = {ControllerVerb::stop, {}, axis.number}});
  for (std::size_t i = 0; i < station.devices.size(); ++i) {
    const bool warms = std::any_of(station.axes.begin(), station.axes.end(), [&](const StationAxis& axis) {
      return axis.device == i && axis.kind == StationAxis::Kind::temperature;
    });
    const auto& device = station.devices[i];
    const ControllerVerb verb = device.can(ControllerVerb::hold)   ? ControllerVerb::hold
                                : device.can(ControllerVerb::stop) ? ControllerVerb::stop
                                                                   : ControllerVerb::off;
    if (!warms || !device.can(verb)) continue;
    station.safe.push_back({.device = i, .request = {verb}, .within = 30.0});
  }
  if (station.power.device)
    station.safe.push_back(
        {.device = *station.power.device, .request = {ControllerVerb::off}, .within = 10.0, .wait = true});
}

/// Every axis that moves must be stopped by the safe list.
void check_safe_list(Section& root, Draft& draft) {
  const auto& station = draft.station;
  for (const auto& axis : station.axes) {
    if (axis.kind == StationAxis::Kind::temperature) continue;
    const bool stopped = std::any_of(station.safe.begin(), station.safe.end(), [&](const SafeCommand& command) {
      return command.device == axis.device && command.request.axis == axis.number &&
             command.request.verb == ControllerVerb::stop;
    });
    if (!stopped)
      root.problem(say("[[safe]]: nothing stops the axis '{}': add device = \"{}\", verb = \"stop\", axis = {}",
                       axis.name, station.devices[axis.device].name, axis.number));
  }
}

void read_station_section(Section& root, Draft& draft) {
  const auto* table = root.table("station");
  if (!table) return root.missing("[station]", "[station] with name = \"bench 3\"");
  Section section(*table, "[station]", draft.problems);
  draft.station.name = needed(section, "name", "\"bench 3\"");
  draft.station.by_hand = section.texts("by_hand");
  const auto units = section.text("units");
  if (units && *units != "all" && *units != "any")
    section.problem_at("units", "\"all\": a unit that fails ends the run; or \"any\": the others go on");
  draft.station.all_units = units == "all";
  const auto answer = section.quantity("answer_within", Unit::parse("s"));
  if (answer && *answer <= 0.0) section.problem_at("answer_within", "must be above zero");
  draft.station.answer_within = answer.value_or(draft.station.answer_within);
  section.close();
}

void check_names(Section& root, Draft& draft) {
  std::set<std::string> names;
  const auto once = [&](const std::string& name, const char* what) {
    if (!name.empty() && !names.insert(name).second)
      root.problem(say("two things are called '{}': a {} needs a name of its own", name, what));
  };
  for (const auto& device : draft.station.devices) once(device.name, "device");
  std::set<std::string> axes;
  for (const auto& axis : draft.station.axes)
    if (!axis.name.empty() && !axes.insert(axis.name).second)
      root.problem(say("the axis '{}' of the rig is given to two axes of controllers", axis.name));
  for (const auto& axis : draft.station.by_hand)
    if (!axes.insert(axis).second) root.problem(say("the axis '{}' is moved by hand and by a device", axis));
}

}  // namespace

std::vector<const toml::table*> tables_at(Section& section, const std::string& key, const std::string& heading) {
  std::vector<const toml::table*> found;
  const auto* node = section.find(key);
  if (!node) return found;
  if (const auto* array = node->as_array())
    for (const auto& element : *array)
      if (const auto* table = element.as_table()) found.push_back(table);
  const auto* array = node->as_array();
  if (!array || found.size() != array->size())
    section.problem_at(key, say("is a list of tables, each headed {}", Name{heading}));
  return found;
}

bool flag(Section& section, const std::string& key) {
  const auto* node = section.find(key);
  if (!node) return false;
  if (const auto* boolean = node->as_boolean()) return boolean->get();
  section.problem_at(key, "true or false is expected");
  return false;
}

std::string needed(Section& section, const std::string& key, const std::string& example) {
  const auto* node = section.find(key);
  auto text = section.text(key).value_or("");
  if (!node)
    section.missing(key, example);
  else if (text.empty() && node->is_string())
    section.problem_at(key, "must not be empty");
  return text;
}

std::optional<std::size_t> device_at(Section& section, const std::string& key, const Station& station) {
  const auto name = needed(section, key, "\"table\"");
  if (name.empty()) return std::nullopt;
  std::vector<std::string> known;
  for (std::size_t i = 0; i < station.devices.size(); ++i) {
    if (station.devices[i].name == name) return i;
    known.push_back(station.devices[i].name);
  }
  section.problem_at(key, say("the station has no device '{}'{} (devices: {})", name, did_you_mean(name, known),
                              fmt::join(known, ", ")));
  return std::nullopt;
}

std::optional<std::size_t> choice(Section& section, const std::string& key, const std::vector<std::string>& words) {
  const auto text = section.text(key);
  if (!text) return std::nullopt;
  const auto found = std::find(words.begin(), words.end(), *text);
  if (found != words.end()) return static_cast<std::size_t>(found - words.begin());
  section.problem_at(
      key, say("'{}' is not known{}; accepted: {}", *text, did_you_mean(*text, words), fmt::join(words, ", ")));
  return std::nullopt;
}

bool is_date(const std::string& text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return false;
  for (const std::size_t i : {0, 1, 2, 3, 5, 6, 8, 9})
    if (text[i] < '0' || text[i] > '9') return false;
  const std::string month = text.substr(5, 2), day = text.substr(8, 2);
  return month >= "01" && month <= "12" && day >= "01" && day <= "31";
}

void read_instruments(Section& root, Draft& draft) {
  for (const auto* table : tables_at(root, "instrument", "[[instrument]]")) {
    Section section(*table, "[[instrument]]", draft.problems);
    read_instrument(section, draft);
  }
}

void read_interlocks(Section& root, Draft& draft) {
  for (const bool may_stop : {true, false}) {
    const std::string key = may_stop ? "interlock" : "hold";
    for (const auto* table : tables_at(root, key, "[[" + key + "]]")) {
      Section section(*table, "[[" + key + "]]", draft.problems);
      read_requirement(section, draft, may_stop);
    }
  }
}

void read_safe(Section& root, Draft& draft) {
  const auto list = tables_at(root, "safe", "[[safe]]");
  for (const auto* table : list) {
    Section section(*table, "[[safe]]", draft.problems);
    read_safe_command(section, draft);
  }
  if (list.empty()) default_safe_list(draft);
  check_safe_list(root, draft);
}

void read_equipment(Section& root, Draft& draft) {
  for (const auto* table : tables_at(root, "equipment", "[[equipment]]")) {
    Section section(*table, "[[equipment]]", draft.problems);
    StationEquipment equipment;
    equipment.name = needed(section, "name", "\"rate table\"");
    equipment.serial = needed(section, "serial", "\"RT-12\"");
    equipment.certificate = section.text("certificate").value_or("");
    equipment.due = section.text("due").value_or("");
    if (section.find("due") && !is_date(equipment.due))
      section.problem_at("due", "a date in quotes is expected, for example \"2027-03-01\"");
    section.close();
    draft.station.equipment.push_back(std::move(equipment));
  }
}

void read_power(Section& root, Draft& draft) {
  const auto* table = root.table("power");
  if (!table) return;
  Section section(*table, "[power]", draft.problems);
  auto& power = draft.station.power;
  if (table->contains("device")) power.device = device_at(section, "device", draft.station);
  power.off_time = section.quantity("off_time", seconds()).value_or(power.off_time);
  power.warm_up = section.quantity("warm_up", seconds()).value_or(power.warm_up);
  if (power.off_time < 0.0) section.problem_at("off_time", "must not be negative");
  if (power.warm_up < 0.0) section.problem_at("warm_up", "must not be negative");
  section.find("device");
  section.close();
}

}  // namespace station_file

Station read_station(const std::string& text, const std::string& file) {
  using namespace station_file;
  Draft draft;
  draft.problems.file = draft.station.file = file;
  draft.folder = std::filesystem::path(file).parent_path().string();
  draft.station.sha256 = sha256_of(text);
  draft.station.text = text;
  const auto document = tables::document_of(text, file);
  Section root(document, "", draft.problems);
  read_station_section(root, draft);
  read_devices(root, draft);
  read_power(root, draft);
  read_instruments(root, draft);
  read_interlocks(root, draft);
  read_safe(root, draft);
  read_equipment(root, draft);
  check_names(root, draft);
  root.close();
  if (!draft.problems.all.empty()) throw Error(Error::Kind::bad_input, draft.problems.sorted());
  return std::move(draft.station);
}

}  // namespace tumble
