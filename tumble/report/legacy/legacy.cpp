#include "tumble/report/legacy/legacy.hpp"

#include <cmath>

#include "tumble/units/error.hpp"

namespace tumble::legacy {
namespace {

Bound bound_of(const std::string& text) {
  const Quantity quantity = parse_quantity(text);
  const double value = quantity.unit.to_si(quantity.value);
  if (!std::isfinite(value)) throw Error(Error::Kind::bad_input, say("the limit '{}' cannot be read", text));
  return {value, quantity.unit};
}

}  // namespace

Limit limit_of(const std::string& text) {
  if (text.starts_with("<=")) return {.upper = bound_of(text.substr(2))};
  if (text.starts_with(">=")) return {.lower = bound_of(text.substr(2))};
  const auto to = text.find(" to ");
  if (to == std::string::npos) throw Error(Error::Kind::bad_input, say("the limit '{}' cannot be read", text));
  return {.lower = bound_of(text.substr(0, to)), .upper = bound_of(text.substr(to + 4))};
}

}  // namespace tumble::legacy
