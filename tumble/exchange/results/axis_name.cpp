#include "tumble/exchange/results/axis_name.hpp"

#include <algorithm>
#include <string>
#include <vector>

namespace tumble::results {
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

}  // namespace tumble::results
