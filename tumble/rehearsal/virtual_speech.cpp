#include "tumble/rehearsal/virtual_speech.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tumble {
namespace {

using Words = std::vector<std::string>;

/// All meanings that the declaration has for a word; empty: any text is good.
Words meanings_of(const Controller& controller, const std::string& word) {
  Words meanings;
  if (const auto table = controller.words.find(word); table != controller.words.end())
    for (const auto& [text, meaning] : table->second) meanings.push_back(meaning);
  for (const ControllerBits& bits : controller.bits)
    if (bits.word == word)
      for (const ControllerBitRule& rule : bits.rules) meanings.push_back(rule.means);
  return meanings;
}

/// What comes nearest to a meaning, the nearest first.
Words near(const std::string& meaning) {
  if (meaning == "moving") return {"running", "ready"};
  if (meaning == "running") return {"manual", "moving", "ready"};
  if (meaning == "ready") return {"running", "hold", "manual", "none"};
  if (meaning == "off" || meaning == "disabled") return {"off", "disabled", "hold", "ready"};
  if (meaning == "none") return {"ready", "off"};
  return {"fault", "alarm", "warning"};
}

std::string sayable(const Words& meanings, const std::string& wanted) {
  const auto has = [&](const std::string& meaning) { return std::ranges::find(meanings, meaning) != meanings.end(); };
  if (meanings.empty() || has(wanted)) return wanted;
  for (const auto& other : near(wanted))
    if (has(other)) return other;
  return meanings.front();
}

}  // namespace

namespace {

bool names_an_axis(const ControllerCommand& command) {
  return std::ranges::any_of(command.exchanges, [](const ControllerExchange& exchange) {
    return exchange.modbus || std::ranges::any_of(exchange.send.pieces, [](const ControllerPiece& piece) {
             return piece.axis != 0 || piece.kind == ControllerPiece::Kind::axis;
           });
  });
}

/// Whether a value of the request chooses this verb for an axis.
bool is_chosen(const ControllerCommand& command, const ControllerRequest& request, const std::string& tail) {
  return std::ranges::any_of(command.exchanges, [&](const ControllerExchange& exchange) {
    return std::ranges::any_of(exchange.set, [&](const auto& set) {
      const auto sent = request.values.find(set.first + tail);
      return sent != request.values.end() && sent->second == set.second;
    });
  });
}

std::optional<ControllerRequest> of_axis(const ControllerCommand& command, const ControllerRequest& request, int axis) {
  const std::string tail = "." + std::to_string(axis);
  if (!is_chosen(command, request, tail)) return std::nullopt;
  ControllerRequest one{command.verb, {}, axis};
  for (const auto& name : command.takes)
    if (const auto value = request.values.find(name + tail); value != request.values.end())
      one.values.emplace(name, value->second);
  const std::string& own = name(command.verb);
  const bool has_own = std::ranges::find(command.takes, own) != command.takes.end();
  return has_own && !one.values.contains(own) ? std::nullopt : std::optional(std::move(one));
}

}  // namespace

std::vector<ControllerRequest> axis_by_axis(const Controller& controller, const ControllerRequest& request) {
  const int axes = static_cast<int>(controller.axes.size());
  std::vector<ControllerRequest> single;
  for (int axis = 1; axis <= axes; ++axis)
    for (const ControllerCommand& command : controller.commands)
      if (auto one = of_axis(command, request, axis)) single.push_back(std::move(*one));
  const ControllerCommand* command = controller.find(request.verb);
  const bool is_simple = request.verb == ControllerVerb::stop || request.verb == ControllerVerb::enable ||
                         request.verb == ControllerVerb::disable;
  if (command && is_simple && !names_an_axis(*command))
    for (int axis = 1; axis <= axes; ++axis) single.push_back({request.verb, request.values, axis});
  return single.empty() ? std::vector{request} : single;
}

ControllerReply in_words_of(const Controller& controller, ControllerReply reply) {
  const ControllerCommand* command = controller.find(reply.verb);
  if (!command) return reply;
  for (const auto& name : command->gives) {
    const auto bits = std::ranges::find(controller.bits, name, &ControllerBits::from);
    const std::string& word = bits == controller.bits.end() ? name : bits->word;
    if (!reply.values.contains(name)) reply.words.try_emplace(word, "none");
  }
  for (auto& [word, meaning] : reply.words) meaning = sayable(meanings_of(controller, word), meaning);
  return reply;
}

}  // namespace tumble
