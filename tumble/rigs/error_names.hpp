#pragma once

/// The names of the rigs' errors, as budgets show them. Rigs and those who ask for an error by name share these.
namespace tumble::error_names {

inline constexpr const char* level_about_east = "level of the base about east";
inline constexpr const char* level_about_north = "level of the base about north";
inline constexpr const char* azimuth = "azimuth of the base";
inline constexpr const char* gravity = "gravity";
inline constexpr const char* latitude = "latitude";

inline constexpr const char* lever_x = "lever arm x";
inline constexpr const char* lever_y = "lever arm y";
inline constexpr const char* lever_z = "lever arm z";
inline constexpr const char* mounting_x = "mounting about x";
inline constexpr const char* mounting_y = "mounting about y";
inline constexpr const char* mounting_z = "mounting about z";
inline constexpr const char* pose_x = "pose about x";
inline constexpr const char* pose_y = "pose about y";
inline constexpr const char* pose_z = "pose about z";

inline constexpr const char* radius = "radius";
inline constexpr const char* stretch_of_radius = "stretch of the radius";
inline constexpr const char* table_tilt_about_arm = "tilt of the table axis about the arm";
inline constexpr const char* table_tilt_across_arm = "tilt of the table axis across the arm";
inline constexpr const char* inner_to_outer = "orthogonality of inner to outer";
inline constexpr const char* middle_to_outer = "orthogonality of middle to outer";
inline constexpr const char* inner_to_middle = "orthogonality of inner to middle";

inline constexpr const char* shake_amplitude = "shake amplitude";
inline constexpr const char* cross_motion_y = "cross motion y";
inline constexpr const char* cross_motion_z = "cross motion z";
inline constexpr const char* second_harmonic = "second harmonic";
inline constexpr const char* third_harmonic = "third harmonic";
inline constexpr const char* reference_gain = "gain of the reference";

inline constexpr const char* thermometer_offset = "thermometer offset";
inline constexpr const char* thermometer_scale = "thermometer scale";

/// Before the name of an axis.
inline constexpr const char* index_zero_of = "index zero of ";
inline constexpr const char* positioning_of = "positioning of ";
inline constexpr const char* wobble_of = "wobble of ";
inline constexpr const char* angle_error_of = "angle error of ";
inline constexpr const char* rate_error_of = "rate error of ";
inline constexpr const char* rate_ripple_of = "rate ripple of ";
inline constexpr const char* oscillation_amplitude_of = "oscillation amplitude of ";

}  // namespace tumble::error_names
