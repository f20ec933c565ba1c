#include "tumble/wire/controller_verb.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "tumble/units/nearest.hpp"

namespace tumble {
namespace {

constexpr std::array verb_words{
    "identify", "take",      "release", "enable",      "disable",         "home",       "rate",  "position", "sine",
    "stop",     "read",      "state",   "clear_fault", "set_temperature", "set_ramp",   "start", "hold",     "off",
    "resume",   "set_point", "alarm",   "set_voltage", "set_current",     "set_limits", "sweep", "random",   "notice"};
static_assert(verb_words.size() == static_cast<std::size_t>(ControllerVerb::notice) + 1);

}  // namespace

const std::string& name(ControllerVerb verb) {
  static const std::vector<std::string> names(verb_words.begin(), verb_words.end());
  return names.at(static_cast<std::size_t>(verb));
}

const std::vector<std::string>& controller_verbs() {
  static const std::vector<std::string> verbs(verb_words.begin(), verb_words.end() - 1);  // no declaration has a notice
  return verbs;
}

std::optional<ControllerVerb> find_verb(std::string_view word) {
  const auto& verbs = controller_verbs();
  const auto found = std::ranges::find(verbs, word);
  if (found == verbs.end()) return std::nullopt;
  return static_cast<ControllerVerb>(found - verbs.begin());
}

Sentence unknown_verb(const std::string& word) {
  const auto& verbs = controller_verbs();
  return say("unknown verb '{}'{} (known: {})", word, did_you_mean(word, verbs), fmt::join(verbs, ", "));
}

}  // namespace tumble
