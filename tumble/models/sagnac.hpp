#pragma once

namespace tumble {

class Settings;

/// In vacuum [m/s], exact.
constexpr double speed_of_light = 299792458.0;

/// Optical path difference [m] of two beams round a plane loop of `area` [m^2] that turns at `rate` [rad/s].
///
///   dL = 4 A W/c                                                                                           (4.20)
///
/// Positive for a rotation in the sense of the clockwise beam. The refractive index of a medium does not enter.
double sagnac_path_difference(double area, double rate);

/// Scale factor [fringe/rad] of a ring laser gyro, K = 4 A/(lambda L).                                      (4.22)
///
/// Given  area [m^2] and perimeter [m] of the ring; wavelength in vacuum [m]
double ring_laser_scale_factor(double area, double perimeter, double wavelength);

/// Scale factor [fringe/rad] of a ring that is a regular polygon of `corners` sides, each `side` [m] long.
double ring_laser_scale_factor(int corners, double side, double wavelength);

/// Scale factor [fringe/rad] as the constants of a ring_laser_gyro say it: `scale_factor`, or area and perimeter, or
/// shape and side.
double ring_laser_scale_factor(const Settings& truth);

/// Path difference [m] of a fibre coil, dL = 2 R L W/c = L D W/c.                                           (4.28)
///
/// Given  length of the fibre [m], diameter of the coil [m]
double coil_path_difference(double length, double diameter, double rate);

/// Phase difference [rad] of a fibre coil, 2 pi L D W/(lambda c).                                           (4.28)
double coil_phase_difference(double length, double diameter, double wavelength, double rate);

}  // namespace tumble
