#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "tumble/core/tables/document.hpp"
#include "tumble/units/nearest.hpp"
#include "tumble/wire/controller/declared.hpp"
#include "tumble/wire/controller/http.hpp"
#include "tumble/wire/controller/template.hpp"

namespace tumble::controller {

namespace {

using tables::Section;

/// The settings with the values that count.
std::map<std::string, std::string> settings_of(const toml::table& document,
                                               const std::map<std::string, std::string>& wanted, Declared& declared) {
  std::map<std::string, std::string> settings;
  std::vector<std::string> known;
  if (const auto* table = document["setting"].as_table())
    for (const auto& [key, node] : *table) {
      known.emplace_back(key.str());
      if (const auto text = tables::text_of(node))
        settings[known.back()] = *text;
      else
        declared.draft.problems.add(node.source(),
                                    say("[setting]: {}: a text or a number is expected", Name{known.back()}));
    }
  for (const auto& [name, value] : wanted) {
    if (!settings.contains(name))
      declared.draft.add(say("there is no setting '{}'{} (settings: {})", Name{name}, did_you_mean(name, known),
                             known.empty() ? Sentence("none") : say("{}", fmt::join(known, ", "))));
    settings[name] = value;
  }
  return settings;
}

void put_into(std::string& text, const toml::source_region& place, Declared& declared) {
  const auto& settings = declared.controller.settings;
  for (std::size_t at = text.find("${"); at != std::string::npos; at = text.find("${", at)) {
    const auto end = text.find('}', at);
    const std::string name = text.substr(at + 2, std::min(end, text.size()) - at - 2);
    const auto setting = settings.find(name);
    if (end == std::string::npos || setting == settings.end()) {
      std::vector<std::string> known;
      for (const auto& [key, value] : settings) known.push_back(key);
      declared.draft.problems.add(place, say("there is no setting '{}'{}", name, did_you_mean(name, known)));
      return;
    }
    text.replace(at, end + 1 - at, setting->second);
    at += setting->second.size();
  }
}

void put_into_node(toml::node& node, Declared& declared, int depth) {
  if (depth > 20) return;
  if (auto* text = node.as_string()) put_into(text->get(), node.source(), declared);
  if (auto* table = node.as_table())
    for (auto&& [key, value] : *table) put_into_node(value, declared, depth + 1);
  if (auto* array = node.as_array())
    for (auto& value : *array) put_into_node(value, declared, depth + 1);
}

void read_serial(Section& section, ControllerLink& link) {
  const auto text = section.text("serial");
  if (!text) return;
  const auto colon = text->find(':');
  const std::string digits = text->substr(0, colon);
  link.format = colon == std::string::npos ? "8N1" : text->substr(colon + 1);
  const bool numeric =
      !digits.empty() && digits.size() < 9 && digits.find_first_not_of("0123456789") == std::string::npos;
  const auto& format = link.format;
  const bool sound = format.size() == 3 && (format[0] == '7' || format[0] == '8') &&
                     std::string_view("NOE").find(format[1]) != std::string_view::npos &&
                     (format[2] == '1' || format[2] == '2');
  if (numeric) link.baud = std::stol(digits);
  if (!numeric || !sound || link.baud == 0) section.problem_at("serial", "\"9600:8N1\" is expected: baud, format");
}

void read_link(Section& root, Declared& declared) {
  ControllerLink& link = declared.controller.link;
  const auto* table = root.table("link");
  if (!table) return root.missing("link", "{tcp = 5025}");
  Section section = declared.draft.section(*table, "[link]");
  link.tcp = number_at(section, "tcp", 65535).value_or(0);
  read_serial(section, link);
  link.flow = section.text("flow").value_or("");
  if (!link.flow.empty() && link.flow != "xonxoff" && link.flow != "rtscts")
    section.problem_at("flow", "xonxoff or rtscts is expected");
  link.period = seconds_at(section, "period", 0.1);
  declared.timeout = seconds_at(section, "timeout", 1.0);
  declared.pause = seconds_at(section, "pause", 0.0);
  if (link.tcp == 0 && link.baud == 0) section.missing("tcp", "5025, or serial = \"9600:8N1\"");
  section.close();
}

void read_axes(Section& root, Controller& controller) {
  if (const auto* node = root.find("axes"); node && node->is_array()) {
    controller.axes = root.texts("axes");
  } else {
    const int count = number_at(root, "axes", 16).value_or(1);
    for (int axis = 1; axis <= std::min(count, 16); ++axis) controller.axes.push_back(std::to_string(axis));
  }
  auto sorted = controller.axes;
  std::ranges::sort(sorted);
  const bool twice = std::ranges::adjacent_find(sorted) != sorted.end();
  if (controller.axes.empty() || controller.axes.size() > 16 || twice ||
      std::ranges::any_of(sorted, &std::string::empty))
    root.problem_at("axes", "a number from 1 to 16, or a list of different names, is expected");
  if (controller.axes.empty()) controller.axes = {"1"};
}

void read_http(Section& root, Declared& declared) {
  Controller& controller = declared.controller;
  controller.protocol = Controller::Protocol::http;
  controller.longest = 16384;
  const auto* table = root.table("http");
  if (!table) return;
  Section section = declared.draft.section(*table, "[http]");
  ControllerHttp& settings = controller.http;
  settings.host = section.text("host").value_or(settings.host);
  settings.message = section.text("message").value_or("");
  if (!settings.message.empty() && !is_json_pointer(settings.message))
    section.problem_at("message", "a JSON pointer is expected, \"/error/message\"");
  for (const auto& header : section.texts("headers"))
    if (!header.empty()) settings.headers.push_back(header);
  const auto has_end = [](const std::string& text) { return text.find_first_of("\r\n") != std::string::npos; };
  if (std::ranges::any_of(settings.headers, has_end) || has_end(settings.host))
    section.problem_at("headers", "host and headers have no end of line in them");
  section.close();
}

void read_protocol(Section& root, Declared& declared) {
  const std::string protocol = root.text("protocol").value_or("text");
  Controller& controller = declared.controller;
  if (protocol != "text" && protocol != "modbus" && protocol != "http")
    root.problem_at("protocol", "text, modbus or http is expected");
  if (protocol == "http") return read_http(root, declared);
  const auto* table = root.table("modbus");
  if (protocol != "modbus") return table ? root.problem_at("modbus", "needs protocol = \"modbus\"") : void();
  controller.protocol = Controller::Protocol::modbus_tcp;
  if (!table) return;
  Section section = declared.draft.section(*table, "[modbus]");
  controller.unit = number_at(section, "unit", 255).value_or(1);
  const std::string words = section.text("words").value_or("high first");
  declared.low_word_first = words == "low first";
  if (!declared.low_word_first && words != "high first")
    section.problem_at("words", "low first or high first is expected");
  const std::string transport = section.text("transport").value_or("tcp");
  if (transport == "rtu")
    controller.protocol = Controller::Protocol::modbus_rtu, controller.checksum = modbus_checksum();
  else if (transport != "tcp")
    section.problem_at("transport", "tcp or rtu is expected");
  section.close();
}

}  // namespace

std::optional<int> number_at(Section& section, std::string_view key, int most) {
  const auto* node = section.find(key);
  if (!node) return std::nullopt;
  const std::string text = node->is_string() || node->is_integer() ? tables::text_of(*node).value_or("") : "";
  const bool digits = !text.empty() && text.size() < 9 && text.find_first_not_of("0123456789") == std::string::npos;
  const int value = digits ? std::stoi(text) : -1;
  if (value >= 0 && value <= most) return value;
  section.problem_at(key, say("a whole number from 0 to {} is expected", most));
  return std::nullopt;
}

bool flag_at(Section& section, std::string_view key, bool otherwise) {
  const auto* node = section.find(key);
  if (!node) return otherwise;
  if (const auto* flag = node->as_boolean()) return flag->get();
  section.problem_at(key, "true or false is expected");
  return otherwise;
}

double seconds_at(Section& section, std::string_view key, double otherwise) {
  const double value = section.quantity(key, Unit::parse("s")).value_or(otherwise);
  if (value >= 0.0 && value <= 1e5) return value;
  section.problem_at(key, "must be from 0 to 100000 s");
  return otherwise;
}

void put_settings(toml::table& document, const std::map<std::string, std::string>& wanted, Declared& declared) {
  declared.controller.settings = settings_of(document, wanted, declared);
  for (auto&& [key, value] : document)
    if (key.str() != "setting") put_into_node(value, declared, 0);
}

}  // namespace tumble::controller

namespace tumble {

Controller read_controller(std::string_view text, const std::string& file,
                           const std::map<std::string, std::string>& settings) {
  toml::table document = tables::document_of(std::string(text), file);
  controller::Declared declared{declaration::Draft(file)};
  controller::put_settings(document, settings, declared);
  tables::Section root = declared.draft.section(document, "");
  root.table("setting");
  Controller& controller = declared.controller;
  controller.name = file.ends_with(".toml") ? file.substr(0, file.size() - 5) : file;
  declaration::read_head(root, "\"ESPEC P-300 chamber\"", controller);
  controller.lost_link = root.text("lost_link").value_or("");
  controller::read_axes(root, controller);
  controller::read_link(root, declared);
  controller::read_protocol(root, declared);
  controller::read_frame(root, declared);
  controller::read_words(root, declared);
  controller::read_sayings(root, declared);
  controller::read_commands(root, declared);
  if (declared.draft.sound()) controller::require_sense(declared);
  controller::read_vectors(root, declared);
  root.close();
  declared.draft.require_sound();
  for (const auto& [name, value] : settings)
    if (value != tables::text_of(*document["setting"][name].node())) controller.vectors.clear();
  if (auto wrong = problems_of_vectors(controller); !wrong.empty()) throw Error(Error::Kind::bad_input, wrong);
  return controller;
}

}  // namespace tumble
