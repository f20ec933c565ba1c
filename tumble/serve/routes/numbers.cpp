#include "tumble/serve/routes/numbers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/units/text_parts.hpp"

namespace tumble::routes {

Json number(double value_si, const Unit& unit) {
  if (!std::isfinite(value_si)) return nullptr;
  return as_number<double>(format_in(value_si, unit)).value_or(NAN);
}

std::string number_text(double value, double scale) {
  if (!std::isfinite(value)) return "";
  if (!(scale > 0.0) || !std::isfinite(scale)) return fmt::format("{:.9g}", value);
  const int last = static_cast<int>(std::floor(std::log10(scale))) - 4;
  if (std::abs(value) < std::pow(10.0, last)) return fmt::format("{:.2g}", value);
  const double size = std::log10(std::abs(value));
  if (last >= -12 && last <= 0 && size < 9.0) return fmt::format("{:.{}f}", value, -last);
  return fmt::format("{:.{}g}", value, std::clamp(static_cast<int>(std::floor(size)) - last + 1, 1, 17));
}

std::vector<std::string> units_like(const Unit& unit) {
  static const std::vector<std::string> usual{"deg/h",  "deg/s", "rad/s", "m/s^2", "g",    "mg", "ug", "deg",
                                              "arcsec", "rad",   "m/s",   "mm/s",  "degC", "K",  "s",  "ms",
                                              "pulse",  "V",     "mV",    "A",     "mA",   "T",  "uT", "Pa",
                                              "kPa",    "hPa",   "Hz",    "m",     "mm",   "1",  "%",  "ppm"};
  std::vector<std::string> like{unit.text()};
  for (const auto& text : usual)
    if (text != unit.text() && Unit::parse(text).dimension() == unit.dimension()) like.push_back(text);
  return like;
}

}  // namespace tumble::routes
