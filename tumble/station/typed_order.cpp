#include "tumble/station/typed_order.hpp"

#include <algorithm>

namespace tumble {

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
