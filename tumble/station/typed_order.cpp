#include "tumble/station/typed_order.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace tumble {
namespace {

constexpr std::array<std::pair<RunOrder::Kind, std::string_view>, 4> desk_words{
    {{RunOrder::Kind::pause_at_checkpoint, "pause"},
     {RunOrder::Kind::resume, "resume"},
     {RunOrder::Kind::stop, "stop"},
     {RunOrder::Kind::abort, "abort"}}};

}  // namespace

std::string_view desk_word(RunOrder::Kind kind) {
  const auto found = std::ranges::find(desk_words, kind, [](const auto& one) { return one.first; });
  return found == desk_words.end() ? std::string_view() : found->second;
}

std::optional<RunOrder::Kind> find_order(std::string_view word) {
  const auto found = std::ranges::find(desk_words, word, [](const auto& one) { return one.second; });
  return found == desk_words.end() ? std::nullopt : std::optional(found->first);
}

std::optional<decltype(RunEvent::what)> order_of_line(const std::string& line, const std::optional<Prompt>& open,
                                                      const std::string& who) {
  using Kind = RunOrder::Kind;
  if (line == "abort") return RunOrder{Kind::abort, who};
  if (open && line.empty()) return PromptAnswer{open->id, open->standard, who};
  if (open && std::ranges::find(open->choices, line) != open->choices.end()) return PromptAnswer{open->id, line, who};
  if (line == "p" || line == "pause") return RunOrder{Kind::pause_at_checkpoint, who};
  if (line == "r" || line == "resume") return RunOrder{Kind::resume, who};
  return std::nullopt;
}

}  // namespace tumble
