#include "tumble/report/limit_text.hpp"

#include <fmt/format.h>

#include "tumble/units/text_parts.hpp"

namespace tumble {
namespace {

std::string limit_with(const Limit& limit, const char* at_least, const char* at_most) {
  switch (limit.kind()) {
    case Limit::Kind::at_least:
      return at_least + bound_text(*limit.lower);
    case Limit::Kind::at_most:
      return at_most + (limit.upper ? bound_text(*limit.upper) : "inf");
    case Limit::Kind::between:
      break;
  }
  return bound_text(*limit.lower) + " to " + bound_text(*limit.upper);
}

}  // namespace

double written_value(const Bound& bound) { return as_number<double>(format_in(bound.value, bound.unit)).value_or(NAN); }

std::string bound_text(const Bound& bound) {
  const auto number = fmt::format("{}", written_value(bound));
  return bound.unit.text() == "1" ? number : number + " " + bound.unit.text();
}

std::string limit_text(const Limit& limit) { return limit_with(limit, ">= ", "<= "); }

std::string limit_in_characters(const Limit& limit) { return limit_with(limit, "≥ ", "≤ "); }

}  // namespace tumble
