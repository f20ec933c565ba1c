#include <fmt/format.h>

#include <algorithm>

#include "tumble/wire/controller/body.hpp"
#include "tumble/wire/controller/declared.hpp"

namespace tumble::controller {

namespace {

/// The question without its values, to compare two of them.
std::string form_of(const ControllerExchange& exchange) {
  if (const auto& access = exchange.modbus)
    return fmt::format("{} {} {}", access->function, access->address, access->constant.value_or(-1.0));
  std::string text = exchange.bare ? "bare " : "";
  for (const auto& piece : exchange.send.pieces)
    text += piece.kind == ControllerPiece::Kind::literal ? piece.text : "{" + key_of(piece) + "}";
  return text;
}

bool is_same(const ControllerCommand& a, const ControllerCommand& b) {
  return std::ranges::equal(a.exchanges, b.exchanges, {}, form_of, form_of);
}

}  // namespace

void require_sense(Declared& declared) {
  const auto& commands = declared.controller.commands;
  const auto add = [&](ControllerVerb verb, const Sentence& said) {
    const Where table{.table = "command." + name(verb), .place = say("[command.{}]", Name{name(verb)})};
    declared.draft.add(within(table, said));
  };
  for (std::size_t i = 0; i < commands.size(); ++i) {
    const auto& command = commands[i];
    if (command.exchanges.empty()) add(command.verb, "there is nothing to send");
    if (command.read_back && !declared.controller.find(*command.read_back))
      add(command.verb, say("read_back: there is no command '{}'", name(*command.read_back)));
    for (std::size_t j = 0; j < i; ++j)
      if (!command.same_as && !commands[j].same_as && is_same(command, commands[j]))
        add(command.verb, say("sends the same as '{}'; write same_as = \"{}\" in place of it", name(commands[j].verb),
                              name(commands[j].verb)));
  }
  for (const auto& bits : declared.controller.bits) {
    const bool carried = std::ranges::any_of(commands, [&](const ControllerCommand& command) {
      return std::ranges::find(command.gives, bits.from) != command.gives.end();
    });
    if (!carried)
      declared.draft.add(within(Where{.table = "bits." + bits.word, .place = say("[bits.{}]", Name{bits.word})},
                                say("no reply carries the number '{}'", Name{bits.from})));
  }
}

}  // namespace tumble::controller
