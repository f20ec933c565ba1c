#include "tumble/reduce/mistaken_unit.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

constexpr double looks_like_unit = 0.15;  ///< [1] within which a size is that of a mistaken unit

constexpr MistakenUnit rates[] = {{degrees_per_radian, "deg/s", "rad/s"},
                                  {1.0 / degrees_per_radian, "rad/s", "deg/s"},
                                  {hour, "deg/h", "deg/s"},
                                  {1.0 / hour, "deg/s", "deg/h"},
                                  {1e3, "mrad/s, mdeg/s", "rad/s, deg/s"},
                                  {1e-3, "rad/s, deg/s", "mrad/s, mdeg/s"}};
constexpr MistakenUnit forces[] = {
    {standard_gravity, "m/s^2", "g"}, {1.0 / standard_gravity, "g", "m/s^2"}, {1e3, "mg", "g"}, {1e-3, "g", "mg"}};

std::optional<MistakenUnit> nearest(double gain, std::span<const MistakenUnit> all) {
  const auto found = std::ranges::find_if(
      all, [&](const MistakenUnit& unit) { return std::abs(std::abs(gain) / unit.ratio - 1.0) < looks_like_unit; });
  return found == all.end() ? std::nullopt : std::optional(*found);
}

}  // namespace

std::optional<MistakenUnit> mistaken_unit_of_rate(double gain) { return nearest(gain, rates); }
std::optional<MistakenUnit> mistaken_unit_of_force(double gain) { return nearest(gain, forces); }

}  // namespace tumble
