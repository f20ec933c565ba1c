#include "tumble/wire/declaration/scale.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdlib>

#include "tumble/units/error.hpp"

namespace tumble::declaration {

namespace {

/// A number at the begin of `text`, which it is taken from.
double take_number(std::string_view& text, std::string_view all) {
  double value = 0.0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc() || !std::isfinite(value))
    throw Error(Error::Kind::bad_input,
                say("\"{}\" is no scale; write for example \"2^-14 deg/s\" or \"0.05*2^-15 m/s/sample\"", all));
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

double take_power(std::string_view& text, std::string_view all) {
  const double base = take_number(text, all);
  if (!text.starts_with('^')) return base;
  text.remove_prefix(1);
  return std::pow(base, take_number(text, all));
}

double product_of(std::string_view text) {
  const std::string_view all = text;
  double value = take_power(text, all);
  while (!text.empty()) {
    const char sign = text.front();
    if (sign != '*' && sign != '/')
      throw Error(Error::Kind::bad_input, say("\"{}\": *, / or ^ is expected where \"{}\" stands", all, text));
    text.remove_prefix(1);
    const double next = take_power(text, all);
    value = sign == '*' ? value * next : value / next;
  }
  if (!std::isfinite(value) || value == 0.0)
    throw Error(Error::Kind::bad_input, say("the scale \"{}\" is not a number that can be used", all));
  return value;
}

}  // namespace

Scale parse_scale(std::string_view text, const Scales& scales) {
  if (const auto named = scales.find(std::string(text)); named != scales.end())
    return parse_scale(named->second == chosen_by_variant ? "1" : named->second, {});
  Scale scale;
  std::string_view unit = text;
  if (!text.empty() && (text[0] == '-' || text[0] == '.' || (text[0] >= '0' && text[0] <= '9'))) {
    const auto space = std::min(text.find(' '), text.size());
    scale.factor = product_of(text.substr(0, space));
    unit = text.substr(std::min(space + 1, text.size()));
  }
  constexpr std::string_view per_sample = "/sample";
  if (unit.ends_with(per_sample)) {
    scale.increment = true;
    unit.remove_suffix(per_sample.size());
  }
  scale.unit = Unit::parse(unit.empty() ? "1" : unit);
  return scale;
}

}  // namespace tumble::declaration
