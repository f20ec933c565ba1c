#pragma once

#include <numbers>

/// Angles, hours and the unit g in SI, for formulas. tests/check_layers.py refuses their digits outside of units/.
namespace tumble {

inline constexpr double pi = std::numbers::pi;            ///< [rad] half a turn
inline constexpr double two_pi = 2.0 * pi;                ///< [rad] a turn
inline constexpr double half_pi = 0.5 * pi;               ///< [rad] a right angle
inline constexpr double degree = pi / 180.0;              ///< [rad]
inline constexpr double arcsecond = pi / 648000.0;        ///< [rad]
inline constexpr double degrees_per_radian = 180.0 / pi;  ///< [deg/rad]; 1/degree may differ from it in the last bit

inline constexpr double minute = 60.0;  ///< [s]
inline constexpr double hour = 3600.0;  ///< [s]

/// Standard acceleration of free fall [m/s^2]: the unit g, not the gravity of any place. Exact by definition: 3rd
/// General Conference on Weights and Measures (1901).
inline constexpr double standard_gravity = 9.80665;
inline constexpr double micro_g = 9.80665e-6;  ///< [m/s^2] the double nearest to it; 1e-6 * standard_gravity is not

}  // namespace tumble
