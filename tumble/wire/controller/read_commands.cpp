#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "tumble/units/nearest.hpp"
#include "tumble/wire/controller/body.hpp"
#include "tumble/wire/controller/declared.hpp"
#include "tumble/wire/controller/http.hpp"
#include "tumble/wire/controllers.hpp"

namespace tumble {

namespace controller {

namespace {

using declaration::parse_at;
using tables::Section;

/// Numbers have a known name and its unit, or no unit.
void require_unit(Section& section, const char* key, const ControllerPiece& piece) {
  if (piece.kind != ControllerPiece::Kind::number || piece.part == ControllerPiece::Part::sign) return;
  const auto* units = units_of(piece.text);
  const auto fits = [&](const Unit& unit) { return unit.dimension() == piece.unit.dimension(); };
  if (units && std::ranges::any_of(*units, fits)) return;
  if (!units && piece.unit.dimension() == Dimension{}) return;
  if (units)
    section.problem_at(key, say("'{}' must be in {} or the like, not '{}'", piece.text, Name{units->front().text()},
                                piece.unit.text()));
  else
    section.problem_at(
        key, say("a number with a unit has one of the names position, rate, acceleration, "
                 "amplitude, frequency, phase, temperature, set_point, ramp, voltage, current; '{}' is not one",
                 piece.text));
}

/// Absolute temperatures keep their zero: 0.1 degC of a register is a step, and 0 is 0 degC.
void check_template(Section& section, const char* key, const ControllerTemplate& form, bool is_send,
                    const Declared& declared) {
  for (const auto& piece : form.pieces) {
    require_unit(section, key, piece);
    if (piece.axis > static_cast<int>(declared.controller.axes.size()))
      section.problem_at(key, say("'{}': there is no axis {} (see axes)", key_of(piece), piece.axis));
    if (is_send && piece.kind == ControllerPiece::Kind::word)
      section.problem_at(key,
                         say("the word '{}': only numbers and the axis are sent; write the text itself", piece.text));
    if (piece.kind == ControllerPiece::Kind::any && piece.format.width > 0 && !piece.otherwise)
      section.problem_at(key, "{_} with a width needs a default, {_:3s=abc}");
  }
}

std::vector<ControllerTemplate> templates_at(Section& section, const char* key, Declared& declared) {
  std::vector<ControllerTemplate> forms;
  parse_at(section, key, [&] {
    for (const auto& text : section.texts(key)) {
      forms.push_back(parse_template(text));
      check_template(section, key, forms.back(), false, declared);
    }
  });
  return forms;
}

/// "temperature:f32 degC" with bytes of Modbus, the highest first.
ControllerPiece register_field(std::string text) {
  if (const auto colon = text.find(':'); colon != std::string::npos) {
    const auto end = std::min(text.find_first_of(" =", colon), text.size());
    const auto type = text.substr(colon + 1, end - colon - 1);
    if (!type.ends_with("be") && !type.ends_with("le")) text.insert(end, "be");
  }
  const ControllerPiece piece = parse_field(text);
  if (!is_binary(piece) || (piece.number.bytes != 2 && piece.number.bytes != 4))
    throw Error(
        Error::Kind::bad_input,
        say("\"{}\": a type of a register is expected, \"temperature:f32 degC\" (i16, u16, i32, u32, f32)", text));
  if (piece.number.big) return piece;
  throw Error(Error::Kind::bad_input, "Modbus sends the high byte first; the order of words is words = \"low first\"");
}

void read_register(Section& section, ControllerExchange& exchange, Declared& declared) {
  const auto read = section.text("read"), write = section.text("write");
  ControllerRegister access;
  if (read && write) section.problem_at("write", "an exchange reads or writes");
  if (!read && !write) section.missing("read", "\"temperature:f32 degC\"");
  const char* const key = read ? "read" : "write";
  parse_at(section, key, [&] { access.number = register_field(read ? *read : write.value_or("x:u16")); });
  require_unit(section, key, access.number);
  access.address = number_at(section, "register", 65535).value_or(-1);
  if (access.address < 0) section.missing("register", "2820"), access.address = 0;
  access.step = number_at(section, "step", 65535).value_or(0);
  if (access.address + access.step * static_cast<int>(declared.controller.axes.size()) > 65536)
    section.problem_at("step", "the register of the last axis is above 65535");
  const std::string words = section.text("words").value_or(declared.low_word_first ? "low first" : "high first");
  access.low_word_first = words == "low first";
  if (!access.low_word_first && words != "high first")
    section.problem_at("words", "low first or high first is expected");
  access.function = number_at(section, "function", 16).value_or(read ? 3 : access.number.number.bytes == 2 ? 6 : 16);
  const bool sound =
      read ? access.function == 3 : access.function == 16 || (access.function == 6 && access.number.number.bytes == 2);
  if (!sound) section.problem_at("function", "3 reads; 6 writes one register, 16 one or more");
  if (const auto* node = section.find("value")) {
    access.constant = node->value<double>();
    if (!access.constant || !write)
      section.problem_at("value", "a number that is written is expected");
    else
      parse_at(section, "value", [&] { write_number({.number = access.number.number}, *access.constant); });
  }
  exchange.modbus = access;
}

/// What HTTP has beside the texts.
void read_json(Section& section, ControllerExchange& exchange) {
  exchange.json = section.texts("json");
  if (!std::ranges::all_of(exchange.json, is_json_pointer))
    section.problem_at("json", "JSON pointers are expected, \"/data/result\"");
  if (exchange.expect.empty()) section.missing("expect", "\"{_}\": every request of HTTP has a reply");
  if (exchange.bare) section.problem_at("bare", "has no meaning for HTTP");
}

ControllerExchange exchange_of(Section& section, Declared& declared) {
  ControllerExchange exchange;
  exchange.when = section.text("when").value_or("");
  exchange.timeout = seconds_at(section, "timeout", declared.timeout);
  exchange.pause = seconds_at(section, "pause", declared.pause);
  if (declared.controller.is_modbus()) {
    read_register(section, exchange, declared);
    return exchange;
  }
  const auto send = section.text("send");
  if (!send) section.missing("send", "\"POS {axis},{position:.4f deg}\"");
  parse_at(section, "send", [&] { exchange.send = parse_template(send.value_or("")); });
  check_template(section, "send", exchange.send, true, declared);
  exchange.expect = templates_at(section, "expect", declared);
  exchange.refused = templates_at(section, "refused", declared);
  if (const auto* values = section.table("set"))
    for (const auto& [name, node] : *values) {
      const std::string key(name.str());
      parse_at(section, "set", [&] {
        if (units_of(key)) throw Error(Error::Kind::bad_input, "numbers without unit are expected, {mode = 2}");
        exchange.set[key] = parse_si(tables::text_of(node).value_or(""), Unit());
      });
    }
  exchange.bare = flag_at(section, "bare", false);
  if (exchange.bare && (!size_of(exchange.send) || exchange.send.pieces.empty()))
    section.problem_at("bare", "bytes that are sent bare must have a fixed number");
  if (declared.controller.protocol == Controller::Protocol::http) {
    read_json(section, exchange);
    return exchange;
  }
  const bool by_size = declared.controller.send.tail.empty() && !exchange.bare;
  if (by_size && !size_of(exchange.send)) section.problem_at("send", "without a tail, every field needs a fixed size");
  if (declared.controller.reply.tail.empty())
    for (const auto& form : exchange.expect)
      if (!size_of(form)) section.problem_at("expect", "without a tail, every field needs a fixed size");
  return exchange;
}

void summarise(ControllerCommand& command) {
  std::set<std::string> takes, needs, gives;
  const auto take = [&](const ControllerPiece& piece, const ControllerExchange& exchange) {
    if (piece.kind != ControllerPiece::Kind::number || exchange.set.contains(piece.text)) return;
    takes.insert(piece.text);
    if (piece.axis > 0) takes.insert(key_of(piece));
    if (piece.axis == 0 && !piece.otherwise && exchange.when.empty()) needs.insert(piece.text);
  };
  for (const auto& exchange : command.exchanges) {
    for (const auto& piece : exchange.send.pieces) take(piece, exchange);
    if (!exchange.when.empty()) takes.insert(exchange.when);
    if (exchange.modbus && exchange.modbus->function == 3) gives.insert(exchange.modbus->number.text);
    if (exchange.modbus && exchange.modbus->function != 3 && !exchange.modbus->constant)
      take(exchange.modbus->number, exchange);
    if (exchange.expect.empty()) continue;
    for (const auto& piece : exchange.expect.front().pieces)
      if (piece.kind == ControllerPiece::Kind::word || piece.kind == ControllerPiece::Kind::number)
        gives.insert(piece.text);
  }
  command.takes.assign(takes.begin(), takes.end());
  command.requires_.assign(needs.begin(), needs.end());
  command.gives.assign(gives.begin(), gives.end());
}

/// The other commands that a command names.
void read_others(Section& section, ControllerCommand& command) {
  if (const auto word = section.text("read_back")) {
    command.read_back = find_verb(*word);
    if (!command.read_back) section.problem(say("read_back: there is no command '{}'", *word));
  }
  if (const auto word = section.text("same_as")) {
    command.same_as = find_verb(*word);
    if (!command.same_as) section.problem(say("same_as: there is no command '{}'", *word));
  }
}

/// Absent where the word is no verb.
std::optional<ControllerCommand> command_at(const std::string& word, const toml::table& table, Declared& declared) {
  Section section = declared.draft.section(table, fmt::format("[command.{}]", word));
  ControllerCommand command;
  const auto verb = find_verb(word);
  if (!verb) section.problem(unknown_verb(word));
  command.verb = verb.value_or(ControllerVerb{});
  command.once = flag_at(section, "once", false);
  read_others(section, command);
  command.note = section.text("note").value_or("");
  command.certainty = declaration::certainty_at(section, declared.controller.certainty);
  if (table.contains("exchange")) {
    for (const auto* one : declaration::tables_at(section, "exchange")) {
      Section inner = declared.draft.section(*one, fmt::format("[command.{}] exchange", word));
      command.exchanges.push_back(exchange_of(inner, declared));
      inner.close();
    }
  } else if (!table.contains("same_as")) {
    command.exchanges.push_back(exchange_of(section, declared));
  }
  const auto is_optional = [](const ControllerExchange& exchange) { return !exchange.when.empty(); };
  if (!command.exchanges.empty() && is_optional(command.exchanges.back()))
    section.problem_at("when", "the last exchange of a command is always sent; put this one before it");
  section.close();
  summarise(command);
  return verb ? std::optional(std::move(command)) : std::nullopt;
}

void resolve_same(ControllerCommand& command, Declared& declared, Section& root) {
  if (!command.same_as) return;
  const auto* other = declared.controller.find(*command.same_as);
  if (!other || other->same_as || !command.exchanges.empty())
    return root.problem_at("command", say("[command.{}]: same_as names another command, and has nothing to send "
                                          "beside it",
                                          Name{name(command.verb)}));
  command.exchanges = other->exchanges;
  summarise(command);
}

}  // namespace

const std::vector<Unit>* units_of(const std::string& value) {
  const auto units = [](std::initializer_list<const char*> texts) {
    std::vector<Unit> all;
    for (const char* text : texts) all.push_back(Unit::parse(text));
    return all;
  };
  static const std::map<std::string, std::vector<Unit>> known{{"position", units({"deg"})},
                                                              {"rate", units({"deg/s"})},
                                                              {"acceleration", units({"deg/s^2", "m/s^2"})},
                                                              {"amplitude", units({"deg", "m/s^2", "m"})},
                                                              {"frequency", units({"Hz"})},
                                                              {"to_frequency", units({"Hz"})},
                                                              {"duration", units({"s"})},
                                                              {"rms", units({"deg", "m/s^2"})},
                                                              {"phase", units({"deg"})},
                                                              {"temperature", units({"degC"})},
                                                              {"set_point", units({"degC"})},
                                                              {"ramp", units({"K/min"})},
                                                              {"voltage", units({"V"})},
                                                              {"current", units({"A"})}};
  const auto found = known.find(value);
  return found == known.end() ? nullptr : &found->second;
}

void read_commands(Section& root, Declared& declared) {
  const auto* all = root.table("command");
  if (!all) return root.missing("command", "[command.stop] send = \"STOP\"");
  std::vector<std::pair<toml::source_position, std::string>> order;
  for (const auto& [key, node] : *all) {
    order.emplace_back(node.source().begin, std::string(key.str()));
    if (!node.is_table()) root.problem_at("command", "a table for each verb is expected, [command.stop]");
  }
  std::ranges::sort(order, [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [place, word] : order)
    if (const auto* table = all->get(word)->as_table())
      if (auto command = command_at(word, *table, declared))
        declared.controller.commands.push_back(std::move(*command));
  for (auto& command : declared.controller.commands) resolve_same(command, declared, root);
}

}  // namespace controller
}  // namespace tumble
