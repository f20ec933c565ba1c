#pragma once

#include <algorithm>
#include <array>
#include <string_view>

#include "tumble/rigs/error_names.hpp"

namespace tumble {

/// Whether any rig may have an error of this name.
constexpr bool is_error_name(std::string_view name) {
  namespace names = error_names;
  constexpr std::array<std::string_view, 29> whole{names::level_about_east,
                                                   names::level_about_north,
                                                   names::azimuth,
                                                   names::gravity,
                                                   names::latitude,
                                                   names::lever_x,
                                                   names::lever_y,
                                                   names::lever_z,
                                                   names::mounting_x,
                                                   names::mounting_y,
                                                   names::mounting_z,
                                                   names::pose_x,
                                                   names::pose_y,
                                                   names::pose_z,
                                                   names::radius,
                                                   names::stretch_of_radius,
                                                   names::inner_to_outer,
                                                   names::middle_to_outer,
                                                   names::inner_to_middle,
                                                   names::shake_amplitude,
                                                   names::cross_motion_y,
                                                   names::cross_motion_z,
                                                   names::second_harmonic,
                                                   names::third_harmonic,
                                                   names::reference_gain,
                                                   names::thermometer_scale,
                                                   names::thermometer_offset,
                                                   names::table_tilt_about_arm,
                                                   names::table_tilt_across_arm};
  constexpr std::array<std::string_view, 7> before_axis{
      names::index_zero_of,           names::positioning_of, names::wobble_of,
      names::angle_error_of,          names::rate_error_of,  names::rate_ripple_of,
      names::oscillation_amplitude_of};
  return std::ranges::find(whole, name) != whole.end() ||
         std::ranges::any_of(before_axis, [&](std::string_view before) { return name.starts_with(before); });
}

}  // namespace tumble
