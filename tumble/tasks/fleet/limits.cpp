#include "tumble/tasks/fleet/limits.hpp"

#include <fmt/format.h>

#include "tumble/units/error.hpp"

namespace tumble::fleet {

LimitsByName limits_by_name(const Sets& sets) {
  LimitsByName limits;
  Problems problems;
  for (const auto& [key, text] : sets) {
    const auto dot = key.rfind('.');
    const std::string end = dot == std::string::npos ? "" : key.substr(dot + 1);
    if (end == "min")
      limits[key.substr(0, dot)].lower = text;
    else if (end == "max")
      limits[key.substr(0, dot)].upper = text;
    else
      problems.push_back(say("limit '{}': write PARAMETER.min or PARAMETER.max", key));
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return limits;
}

ParameterLimits limits_in(const LimitsByName& limits, const std::string& name, const Unit& unit) {
  ParameterLimits both;
  const auto written = limits.find(name);
  if (written == limits.end()) return both;
  if (!written->second.lower.empty()) both.lower = parse_si(written->second.lower, unit);
  if (!written->second.upper.empty()) both.upper = parse_si(written->second.upper, unit);
  if (!(both.lower < both.upper))
    throw Error(Error::Kind::bad_input, say("limits of {}: {} is not below {}", Name{name}, Name{written->second.lower},
                                            Name{written->second.upper}));
  return both;
}

}  // namespace tumble::fleet
