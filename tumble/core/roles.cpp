#include "tumble/core/roles.hpp"

#include <algorithm>
#include <array>

namespace tumble {
namespace {

enum class Letter { none, lower, upper };

Letter kind_of_letter(char c) {
  if (c >= 'a' && c <= 'z') return Letter::lower;
  return c >= 'A' && c <= 'Z' ? Letter::upper : Letter::none;
}

/// The words of a name in small letters: "imu0_GyrX" has imu, gyr, x.
std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> words;
  Letter before = Letter::none;
  for (const char c : name) {
    const Letter kind = kind_of_letter(c);
    if (kind != Letter::none) {
      if (before == Letter::none || (before == Letter::lower && kind == Letter::upper)) words.emplace_back();
      words.back() += kind == Letter::upper ? static_cast<char>(c - 'A' + 'a') : c;
    }
    before = kind;
  }
  return words;
}

std::optional<std::size_t> axis_in(std::string_view word) {
  static constexpr std::string_view sensors[] = {
      "a",         "acc",   "accel", "acceleration", "accelerometer", "f",      "g",  "gyr",  "gyro",   "gyros",
      "gyroscope", "omega", "w",     "rate",         "linacc",        "angvel", "dv", "dvel", "dtheta", "imu"};
  static constexpr std::string_view letters = "xyz";
  const auto axis = [&](char letter) -> std::optional<std::size_t> {
    const auto at = letters.find(letter);
    return at == letters.npos ? std::nullopt : std::optional(at);
  };
  const auto is_sensor = [](std::string_view text) { return std::ranges::find(sensors, text) != std::end(sensors); };
  if (word.size() == 1 || is_sensor(word.substr(0, word.size() - 1))) return axis(word.back());
  return is_sensor(word.substr(1)) ? axis(word.front()) : std::nullopt;
}

}  // namespace

std::optional<std::size_t> axis_named(std::string_view channel) {
  std::optional<std::size_t> found;
  for (const std::string& word : words_of(channel)) {
    const auto axis = axis_in(word);
    if (!axis) continue;
    if (found && found != axis) return std::nullopt;
    found = axis;
  }
  return found;
}

std::vector<std::string> names_of_role(std::string_view role) {
  std::vector<std::string> names{std::string(role)};
  const std::size_t before = role.size() - std::min<std::size_t>(role.size(), 2);
  if (before > 0 && role[before] == '_' && role[before + 1] >= 'x' && role[before + 1] <= 'z') {
    names.emplace_back(role);
    names.back()[before] = '.';
  }
  return names;
}

const Channel* find_role(const Recording& recording, std::string_view role) {
  for (const auto& name : names_of_role(role))
    if (const Channel* channel = find_channel(recording, name)) return channel;
  return nullptr;
}

namespace {

void propose(const std::vector<NamedKind>& channels, QuantityKind kind, const std::string& sensor,
             std::vector<ProposedRole>& proposed) {
  std::array<const NamedKind*, 3> of_axis{};
  for (const NamedKind& channel : channels) {
    const auto axis = channel.kind == kind ? axis_named(channel.name) : std::nullopt;
    if (!axis) continue;
    if (of_axis[*axis]) return;
    of_axis[*axis] = &channel;
  }
  if (std::ranges::count(of_axis, nullptr) > 0) return;
  std::vector<ProposedRole> roles;
  bool known = true;
  for (std::size_t i = 0; i < 3; ++i) {
    roles.push_back({sensor + "_" + "xyz"[i], of_axis[i] -> name});
    const auto names = names_of_role(roles.back().role);
    known = known && std::ranges::find(names, of_axis[i]->name) != names.end();
  }
  if (!known) proposed.insert(proposed.end(), roles.begin(), roles.end());
}

}  // namespace

std::vector<ProposedRole> proposed_roles(const std::vector<NamedKind>& channels) {
  std::vector<ProposedRole> proposed;
  propose(channels, QuantityKind::specific_force, "accelerometer", proposed);
  propose(channels, QuantityKind::angular_rate, "gyro", proposed);
  return proposed;
}

}  // namespace tumble
