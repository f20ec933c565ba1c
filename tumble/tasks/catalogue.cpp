#include "tumble/tasks/catalogue.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "tumble/checks/check.hpp"
#include "tumble/departures/departure.hpp"
#include "tumble/exchange/exports/export.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/language/said.hpp"
#include "tumble/language/texts.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/models/model.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/tasks/ready_plans.hpp"
#include "tumble/units/words.hpp"
#include "tumble/wire/controllers.hpp"
#include "tumble/wire/instruments.hpp"

namespace tumble {
namespace catalogue {
namespace {

using Json = nlohmann::ordered_json;

const char* word(Option::Type type) {
  switch (type) {
    case Option::Type::quantity:
      return "quantity";
    case Option::Type::integer:
      return "integer";
    case Option::Type::word:
      return "word";
    case Option::Type::flag:
      return "flag";
    case Option::Type::integers:
      return "integers";
    case Option::Type::text:
      return "text";
  }
  return "";
}

const char* word(Motion::Kind kind) {
  switch (kind) {
    case Motion::Kind::hold:
      return "hold";
    case Motion::Kind::rate:
      return "rate";
    case Motion::Kind::slew:
      return "slew";
    case Motion::Kind::sine:
      return "sine";
    case Motion::Kind::sweep:
      return "sweep";
    case Motion::Kind::random:
      return "random";
    case Motion::Kind::ramp:
      return "ramp";
    case Motion::Kind::dwell:
      return "dwell";
  }
  return "";
}

/// The ends [unit of the option], and which of them the value must not reach.
void add_range(const Range& range, Json& one) {
  if (std::isfinite(range.least)) one["min"] = range.least;
  if (std::isfinite(range.most)) one["max"] = range.most;
  if (range.least_open) one["min_excluded"] = true;
  if (range.most_open) one["max_excluded"] = true;
}

Json json(const std::vector<Option>& options) {
  Json list = Json::array();
  for (const auto& option : options) {
    Json one{{"name", option.name}, {"type", word(option.type)}};
    if (option.type == Option::Type::quantity) one["unit"] = option.unit;
    add_range(option.range, one);
    one["default"] = option.fallback.empty() ? Json() : Json(option.fallback);
    if (option.type == Option::Type::word) one["words"] = option.words;
    one["description"] = option.description;
    list.push_back(std::move(one));
  }
  return list;
}

Json json(const Method& method) {
  Json roles = Json::array();
  for (const auto& role : method.roles())
    roles.push_back(
        {{"name", role.name}, {"unit", role.unit}, {"required", role.required}, {"description", role.description}});
  return {{"name", method.name},
          {"summary", method.summary},
          {"source", method.source},
          {"needs_plan", method.needs_plan},
          {"compensates", method.compensates},
          {"predicts", method.predict != nullptr},
          {"roles", roles},
          {"options", json(method.options())}};
}

Json json(const Model& model) {
  Json outputs = Json::array();
  for (const auto& output : model.outputs(defaults(model.constants())))
    outputs.push_back(
        {{"channel", output.channel}, {"quantity", std::string(name(output.kind))}, {"unit", output.unit}});
  return {{"name", model.name},
          {"summary", model.summary},
          {"source", model.source},
          {"outputs", outputs},
          {"options", json(truth_options(model))}};
}

Json json(const Rig& rig) {
  Json axes = Json::array();
  for (const auto& axis : rig.axes()) {
    Json motions = Json::array();
    for (const auto kind : axis.motions) motions.push_back(word(kind));
    axes.push_back({{"name", axis.name}, {"unit", axis.unit}, {"motions", motions}, {"description", axis.description}});
  }
  return {{"name", rig.name}, {"summary", rig.summary}, {"axes", axes}, {"options", json(rig.options())}};
}

Json json(const Format& format) {
  return {{"name", format.name},
          {"summary", format.summary},
          {"extensions", format.extensions},
          {"writes", format.writer != nullptr}};
}

Json json(const Departure& departure) {
  return {{"name", departure.name},
          {"summary", departure.summary},
          {"unit", departure.unit},
          {"sizes", departure.covered != nullptr},
          {"told_by", departure.told_by}};
}

Json json(const Check& check) { return {{"name", check.name}, {"summary", check.summary}}; }

Json json(const Export& entry) {
  std::vector<Option> options = common_export_options();
  for (auto& option : entry.options()) options.push_back(std::move(option));
  return {{"name", entry.name},
          {"summary", entry.summary},
          {"source", entry.source},
          {"formula", entry.formula},
          {"units", entry.units},
          {"frame", entry.frame},
          {"extension", entry.extension},
          {"carries", entry.carries()},
          {"estimates", entry.estimates()},
          {"takes_counts", entry.takes_counts},
          {"options", json(options)}};
}

Json json(const ReadyPlan& plan) {
  return {{"name", plan.name}, {"summary", plan.title}, {"method", plan.method.empty() ? Json() : Json(plan.method)}};
}

Json json(const ShippedInstrument& instrument) {
  const FrameCodec codec = codec_of(instrument);
  Json channels = Json::array();
  for (const auto& channel : codec.channels)
    channels.push_back(
        {{"name", channel.name},
         {"unit", channel.unit.text()},
         {"description", channel.increment ? "from increments, which are divided by the time of a sample" : ""}});
  return {{"name", instrument.name}, {"summary", instrument.title},
          {"source", codec.source},  {"certainty", std::string(name(codec.certainty))},
          {"note", codec.note},      {"variants", instrument.variants},
          {"channels", channels}};
}

/// "tcp 10001, serial 9600:8N1"
std::string said_of(const ControllerLink& link) {
  std::string text = link.tcp > 0 ? fmt::format("tcp {}", link.tcp) : "";
  if (link.baud > 0)
    text += fmt::format("{}serial {}:{}{}{}", text.empty() ? "" : ", ", link.baud, link.format,
                        link.flow.empty() ? "" : " ", link.flow);
  return text;
}

Json json(const Controller& controller) {
  Json commands = Json::array(), settings = Json::array();
  for (const auto& command : controller.commands)
    commands.push_back({{"name", name(command.verb)},
                        {"takes", command.takes},
                        {"gives", command.gives},
                        {"certainty", std::string(name(command.certainty))},
                        {"description", command.note}});
  for (const auto& [setting, value] : controller.settings)
    settings.push_back({{"name", setting}, {"default", value}, {"description", ""}});
  return {{"name", controller.name},
          {"summary", controller.title + (controller.supported() ? "" : " (example)")},
          {"source", controller.source},
          {"certainty", std::string(name(controller.certainty))},
          {"supported", controller.supported()},
          {"note", controller.note},
          {"link", said_of(controller.link)},
          {"lost_link", controller.lost_link},
          {"settings", settings},
          {"commands", commands}};
}

Json json(const ShippedController& shipped) { return json(controller_of(shipped)); }

/// "1 deg = 0.0174532925 rad", and the words with a prefix that are known as well.
Json json(const UnitWord& word) {
  const Unit unit = Unit::parse(word.text);
  const std::string si = name(unit.dimension()) == "1" ? "" : " " + name(unit.dimension());
  Json prefixed = Json::array();
  for (const char prefix : word.prefixes) prefixed.push_back(prefix + std::string(word.text));
  return {{"name", word.text},
          {"summary", unit.offset() == 0.0 ? fmt::format("1 {} = {:.9g}{}", word.text, unit.to_si(1.0), si)
                                           : fmt::format("0 {} = {:.9g}{}", word.text, unit.to_si(0.0), si)},
          {"with_prefixes", prefixed}};
}

template <class Entry>
Json all(const std::vector<const Entry*>& catalogue) {
  Json list = Json::array();
  for (const auto* entry : catalogue) list.push_back(json(*entry));
  return list;
}

template <class Entry>
Json each(const std::vector<Entry>& entries) {
  Json list = Json::array();
  for (const auto& entry : entries) list.push_back(json(entry));
  return list;
}

Json entries_of(const std::string& kind) {
  if (kind == "methods") return all(method_catalogue());
  if (kind == "models") return all(model_catalogue());
  if (kind == "rigs") return all(rig_catalogue());
  if (kind == "formats") return all(format_catalogue());
  if (kind == "departures") return each(departure_catalogue());
  if (kind == "exports") return all(export_catalogue());
  if (kind == "plans") return each(ready_plans());
  if (kind == "instruments") return each(shipped_instruments());
  if (kind == "controllers") return each(shipped_controllers());
  if (kind == "units") return each(unit_words());
  return all(check_catalogue());
}

/// What an option of an entry does: by entry and name, or by name alone where several entries describe one alike.
std::optional<std::string> find_option_text(Language language, const std::string& entry, const std::string& option) {
  auto text = find_text(language, "option." + entry, option);
  return text ? text : find_text(language, "option.common", option);
}

/// An entry in a language, as far as text/<code>.toml has it.
void say_in(Language language, Json& entry) {
  const std::string name = entry["name"];
  if (const auto text = find_text(language, "summary", name)) entry["summary"] = *text;
  if (entry.contains("options"))
    for (auto& option : entry["options"])
      if (const auto text = find_option_text(language, name, option["name"])) option["description"] = *text;
  for (const char* list : {"roles", "axes", "channels", "settings", "commands"})
    if (entry.contains(list))
      for (auto& item : entry[list]) item["description"] = said_in(language, item["description"].get<std::string>());
}

}  // namespace
}  // namespace catalogue

const std::vector<std::string>& catalogue_kinds() {
  static const std::vector<std::string> kinds{"methods", "models", "rigs",        "formats",     "checks", "departures",
                                              "exports", "plans",  "instruments", "controllers", "units"};
  return kinds;
}

std::string controller_json(const std::string& file) {
  return catalogue::json(read_controller(read_text_file(file), file)).dump();
}

std::string catalogue_json(const std::string& kind) { return catalogue::entries_of(kind).dump(); }

std::string catalogue_json(const std::string& kind, Language language) {
  auto entries = catalogue::entries_of(kind);
  if (language != Language::english)
    for (auto& entry : entries) catalogue::say_in(language, entry);
  return entries.dump();
}

}  // namespace tumble
