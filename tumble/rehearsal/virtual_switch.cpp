#include "tumble/rehearsal/virtual_switch.hpp"

#include <algorithm>

namespace tumble {

void VirtualSwitch::power_on() {
  pending_.clear();
  next_ = 0;
}

std::string VirtualSwitch::obey(const std::string& command) {
  for (std::size_t i = 0; i < commands_.start.size(); ++i) {
    if (commands_.start[i].first != command) continue;
    if (i == next_ || i == 0) next_ = i + 1;
    return commands_.start[i].second;
  }
  next_ = 0;
  const auto stop = std::ranges::find(commands_.stop, command, [](const auto& one) { return one.first; });
  return stop == commands_.stop.end() ? "" : stop->second;
}

std::string VirtualSwitch::receive(std::string_view bytes) {
  std::string answers;
  pending_ += bytes;
  for (;;) {
    std::size_t first = std::string::npos, size = 0;
    std::size_t longest = 1;
    const auto look_for = [&](const std::string& command) {
      longest = std::max(longest, command.size());
      const std::size_t at = command.empty() ? std::string::npos : pending_.find(command);
      if (at < first) first = at, size = command.size();
    };
    for (const auto& [command, answer] : commands_.start) look_for(command);
    for (const auto& [command, answer] : commands_.stop) look_for(command);
    if (first == std::string::npos) {
      pending_.erase(0, pending_.size() - std::min(pending_.size(), longest - 1));
      return answers;
    }
    const std::string command = pending_.substr(first, size);
    pending_.erase(0, first + size);
    answers += obey(command);
  }
}

}  // namespace tumble
