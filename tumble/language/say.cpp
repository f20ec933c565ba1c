#include "tumble/language/say.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tumble {

std::string say_seconds(double seconds) {
  const double size = std::abs(seconds);
  if (size == 0.0 || size >= 999.5) return fmt::format("{:.0f} s", seconds);
  if (size < 0.9995e-3) return fmt::format("{:.3g} us", seconds * 1e6);
  if (size < 0.9995) return fmt::format("{:.3g} ms", seconds * 1e3);
  return fmt::format("{:.3g} s", seconds);
}

std::string say_instant(double seconds) {
  std::string text = fmt::format("{:.3f}", seconds);
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return (text == "-0" ? "0" : text) + " s";
}

std::string say_value(double value_si, const Unit& unit) {
  return format_in(value_si, unit) + (unit.text() == "1" ? "" : " " + unit.text());
}

std::string say_difference(double difference_si, const Unit& unit) {
  return fmt::format("{:.3g}{}{}", unit.difference_from_si(difference_si), unit.text() == "1" ? "" : " ",
                     unit.text() == "1" ? "" : unit.text());
}

std::string say_count(std::size_t count, const std::string& noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

Sentence said_count(std::size_t count, const std::string& noun) {
  Sentence said = say("{}", count);
  said.pattern += " " + noun + (count == 1 ? "" : "s");
  return said;
}

std::string say_bytes(std::size_t bytes) {
  const auto size = static_cast<double>(bytes);
  if (size >= 1e9) return fmt::format("{:.3g} GB", 1e-9 * size);
  return size >= 1e6 ? fmt::format("{:.3g} MB", 1e-6 * size) : fmt::format("{:.3g} kB", 1e-3 * size);
}

std::string frequency_label(double frequency) {
  std::string text = fmt::format("{:.6f}", frequency);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  std::replace(text.begin(), text.end(), '.', '_');
  return text + "Hz";
}

}  // namespace tumble
