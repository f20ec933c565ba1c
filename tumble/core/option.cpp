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

Sentence said_of(const Range& range, const std::string& unit) {
  const bool lower = std::isfinite(range.least), upper = std::isfinite(range.most);
  const Name least{end_of(range.least, unit)}, most{end_of(range.most, unit)};
  if (lower && upper && range.least_open)
    return range.most_open ? say("above {} and below {}", least, most) : say("above {} and at most {}", least, most);
  if (lower && upper)
    return range.most_open ? say("at least {} and below {}", least, most)
                           : say("between {} and {}", Name{end_of(range.least, "1")}, most);
  if (lower) return range.least_open ? say("above {}", least) : say("at least {}", least);
  if (upper) return range.most_open ? say("below {}", most) : say("at most {}", most);
  return {};
}

std::string name(const Range& range, const std::string& unit) { return said_of(range, unit).text(); }

}  // namespace tumble
