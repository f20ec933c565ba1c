#include "tumble/station/virtual_speech.hpp"

#include <algorithm>
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
