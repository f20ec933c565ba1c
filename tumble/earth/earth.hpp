#pragma once

#include <optional>

#include "tumble/core/plan.hpp"
#include "tumble/math/vector3.hpp"

namespace tumble {

/// The Earth's rotation against inertial space [rad/s] (WGS84).
inline constexpr double earth_rate = 7.292115e-5;

/// The Earth's rotation as seen at a site, in local level axes.
///
///   x east 0, y north w cos(latitude), z up w sin(latitude)
///
/// Given     site      its geodetic latitude [rad]
/// Returned  rate_in_level [rad/s], x east, y north, z up along the ellipsoid's normal
Vector3 earth_rate_in_level(const Site& site);

/// Normal gravity on and above the WGS84 ellipsoid, along its normal.
///
///   gamma_0 = gamma_e (1 + k sin^2 B) / sqrt(1 - e^2 sin^2 B)
///   gamma   = gamma_0 (1 - 2 (1 + f + m - 2 f sin^2 B) h/a + 3 (h/a)^2)
///
/// Given     latitude  B, geodetic [rad]
///           height    h above the ellipsoid [m]
/// Returned  gamma [m/s^2], positive
/// Valid     -1 km to 20 km. Real gravity differs from normal gravity by up to some 1e-3 m/s^2: measure where it
///           matters.
/// Accuracy  1e-10 m/s^2 on the ellipsoid, 1.1e-10 m/s^2 more for every metre of height (against GeographicLib)
/// See       Somigliana (1929); Moritz, Geodetic Reference System 1980; Heiskanen and Moritz, Physical Geodesy (1967),
///           section 2-14 for the series in height
double normal_gravity(double latitude, double height);

/// Gravity at a site [m/s^2]: as measured if the site says so, else normal gravity.
double gravity(const Site& site);

/// Standard uncertainty of the gravity that acts on an instrument [m/s^2], where nobody states it.
///
///   measured at the site                      5 ug
///   normal gravity, at the height stated      50 ug, by which real gravity scatters about the formula (50 mGal)
///   normal gravity, where none is stated      318 ug: 3.086e-6 1/s^2 times 1000 m beside it
///   nowhere on Earth in particular            0.015 m/s^2, between the equator and a pole
///
/// See       Heiskanen and Moritz, Physical Geodesy (1967), section 2-14: -0.3086 mGal/m
double gravity_sd(const std::optional<Site>& site);

/// Standard uncertainty of the latitude between the plumb line of a site and the Earth's axis [rad]: as the site states
/// it, else 10 arcsec, which is a deflection of the vertical and a latitude that is written to 0.01 deg.
double latitude_sd(const Site& site);

}  // namespace tumble
