#include "tumble/rigs/chain/machine.hpp"

namespace tumble::chain {
namespace {

std::vector<std::string> names(const std::vector<std::string>& axes, const char* before,
                               const std::vector<std::string>& after = {""}) {
  std::vector<std::string> out;
  for (const auto& axis : axes)
    for (const auto& part : after) out.push_back(before + axis + part);
  return out;
}

}  // namespace

std::vector<Imperfection> axis_imperfections(const std::vector<std::string>& axes) {
  const auto phases = [&](const char* per_turn) {
    return names(axes, error_names::wobble_of, {std::string(per_turn) + ", cosine", std::string(per_turn) + ", sine"});
  };
  return {{quantity("index_zero_sd", "arcsec").at_least(0).otherwise("3 arcsec").says("zero of each angle scale"),
           names(axes, error_names::index_zero_of)},
          {quantity("repeatability_sd", "arcsec")
               .at_least(0)
               .otherwise("1 arcsec")
               .says("each angle to which an axis moves"),
           names(axes, error_names::positioning_of), true},
          {quantity("wobble_once_sd", "arcsec")
               .at_least(0)
               .otherwise("1 arcsec")
               .says("wobble of each axis, once per turn"),
           phases(" once per turn")},
          {quantity("wobble_twice_sd", "arcsec")
               .at_least(0)
               .otherwise("0.5 arcsec")
               .says("wobble of each axis, twice per turn"),
           phases(" twice per turn")}};
}

std::vector<Imperfection> drive_imperfections(const std::vector<std::string>& axes) {
  return {{quantity("rate_error_sd", "ppm").at_least(0).otherwise("1 ppm").says("relative error of commanded rates"),
           names(axes, error_names::rate_error_of)},
          {quantity("rate_ripple_sd", "ppm")
               .at_least(0)
               .otherwise("10 ppm")
               .says("relative amplitude of the rate's ripple over the turn"),
           names(axes, error_names::rate_ripple_of, {", cosine", ", sine"})}};
}

std::vector<Imperfection> oscillation_imperfections(const std::vector<std::string>& axes) {
  return {{quantity("amplitude_sd", "ppm")
               .at_least(0)
               .otherwise("500 ppm")
               .says("relative error of the amplitude of oscillations"),
           names(axes, error_names::oscillation_amplitude_of)}};
}

}  // namespace tumble::chain
