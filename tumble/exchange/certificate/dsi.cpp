#include <fmt/format.h>

#include <cmath>

#include "tumble/exchange/certificate.hpp"

namespace tumble {
namespace {

/// Base units of D-SI in the order of Dimension::Base. D-SI has no unit of counting: a count is one, and the label of a
/// quantity says what is counted.
constexpr std::string_view base_units[] = {"\\metre", "\\kilogram", "\\second", "\\ampere", "\\kelvin", "\\radian", ""};
static_assert(std::size(base_units) == Dimension::bases, "a new base unit needs its word of D-SI");

std::string power(std::string_view unit, int halves) {
  if (halves == 2) return std::string(unit);
  return fmt::format("{}\\tothe{{{}{}}}", unit, halves / 2 == 0 && halves < 0 ? "-0" : std::to_string(halves / 2),
                     halves % 2 == 0 ? "" : ".5");
}

/// A unit of D-SI that may take the place of a base unit.
struct Other {
  Dimension::Base base;
  std::string_view dsi, ours;
};

constexpr Other angles[] = {{Dimension::radian, "\\radian", "rad"},
                            {Dimension::radian, "\\degree", "deg"},
                            {Dimension::radian, "\\arcminute", "arcmin"},
                            {Dimension::radian, "\\arcsecond", "arcsec"}};
constexpr Other times[] = {{Dimension::second, "\\second", "s"},
                           {Dimension::second, "\\minute", "min"},
                           {Dimension::second, "\\hour", "h"},
                           {Dimension::second, "\\day", "day"}};
/// Units that stand alone.
constexpr struct {
  std::string_view ours, dsi;
} whole_units[] = {{"ppm", "\\ppm"},
                   {"%", "\\percent"},
                   {"degC", "\\degreecelsius"},
                   {"Hz", "\\hertz"},
                   {"kHz", "\\kilo\\hertz"},
                   {"V", "\\volt"},
                   {"mV", "\\milli\\volt"},
                   {"mA", "\\milli\\ampere"},
                   {"N", "\\newton"},
                   {"Pa", "\\pascal"},
                   {"hPa", "\\hecto\\pascal"},
                   {"kPa", "\\kilo\\pascal"},
                   {"J", "\\joule"},
                   {"W", "\\watt"},
                   {"ohm", "\\ohm"},
                   {"T", "\\tesla"},
                   {"mT", "\\milli\\tesla"},
                   {"mm", "\\milli\\metre"},
                   {"um", "\\micro\\metre"},
                   {"ms", "\\milli\\second"}};

std::string composed(const Dimension& dimension, std::string_view angle, std::string_view time) {
  std::string text;
  for (int base = 0; base < Dimension::bases; ++base) {
    const int halves = dimension.halves[base];  // NOLINT(bugprone-signed-char-misuse): a small number
    std::string_view unit = base_units[base];
    if (base == Dimension::radian) unit = angle;
    if (base == Dimension::second) unit = time;
    if (halves != 0 && !unit.empty()) text += power(unit, halves);
  }
  return text.empty() ? "\\one" : text;
}

double raised(const Other& unit, const Dimension& dimension) {
  return std::pow(Unit::parse(unit.ours).factor(), dimension.halves[unit.base] / 2.0);
}

}  // namespace

std::string dsi_unit(const Dimension& dimension) { return composed(dimension, "\\radian", "\\second"); }

std::optional<std::string> dsi_unit(const Unit& unit) {
  const auto is_unit = [&](const Unit& other) {
    return other.dimension() == unit.dimension() && other.offset() == unit.offset() &&
           std::abs(other.factor() - unit.factor()) <= 4e-16 * unit.factor();
  };
  for (const auto& [ours, dsi] : whole_units)
    if (is_unit(Unit::parse(ours))) return std::string(dsi);
  if (unit.offset() != 0.0) return std::nullopt;
  for (const auto& angle : angles)
    for (const auto& time : times) {
      const double factor = raised(angle, unit.dimension()) * raised(time, unit.dimension());
      if (std::abs(factor - unit.factor()) <= 1e-14 * unit.factor())
        return composed(unit.dimension(), angle.dsi, time.dsi);
    }
  return std::nullopt;
}

}  // namespace tumble
