#include "tumble/core/option.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace tumble {

namespace {

Option option(std::string name, Option::Type type) {
  Option made;
  made.name = std::move(name);
  made.type = type;
  return made;
}

std::string end_of(double value, const std::string& unit) {
  return fmt::format("{}{}{}", value, unit == "1" ? "" : " ", unit == "1" ? "" : unit);
}

}  // namespace

Option& Option::above(double least) {
  range.least = least, range.least_open = true;
  return *this;
}
Option& Option::at_least(double least) {
  range.least = least, range.least_open = false;
  return *this;
}
Option& Option::below(double most) {
  range.most = most, range.most_open = true;
  return *this;
}
Option& Option::at_most(double most) {
  range.most = most, range.most_open = false;
  return *this;
}
Option& Option::between(double least, double most) { return at_least(least).at_most(most); }

Option& Option::otherwise(std::string text) {
  fallback = std::move(text);
  return *this;
}
Option& Option::bare() {
  bare_on_command_line = true;
  return *this;
}
Option& Option::says(std::string text) {
  description = std::move(text);
  return *this;
}

Option quantity(std::string name, std::string unit) {
  Option made = option(std::move(name), Option::Type::quantity);
  made.unit = std::move(unit);
  return made;
}

Option integer(std::string name) { return option(std::move(name), Option::Type::integer); }
Option integers(std::string name) { return option(std::move(name), Option::Type::integers); }

Option word(std::string name, std::vector<std::string> words) {
  Option made = option(std::move(name), Option::Type::word);
  made.words = std::move(words);
  return made;
}

Option flag(std::string name) { return option(std::move(name), Option::Type::flag).otherwise("false"); }
Option text(std::string name) { return option(std::move(name), Option::Type::text); }

std::string name(const Range& range, const std::string& unit) {
  const bool lower = std::isfinite(range.least), upper = std::isfinite(range.most);
  const std::string least = end_of(range.least, unit), most = end_of(range.most, unit);
  if (lower && upper && !range.least_open && !range.most_open)
    return fmt::format("between {} and {}", end_of(range.least, "1"), most);
  std::string text;
  if (lower) text = (range.least_open ? "above " : "at least ") + least;
  if (upper) text += (lower ? " and " : "") + std::string(range.most_open ? "below " : "at most ") + most;
  return text;
}

}  // namespace tumble
