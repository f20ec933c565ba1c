#include "tumble/models/sagnac.hpp"

#include <cmath>

#include "tumble/core/settings.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {

double sagnac_path_difference(double area, double rate) { return 4.0 * area * rate / speed_of_light; }

double ring_laser_scale_factor(double area, double perimeter, double wavelength) {
  return 4.0 * area / (wavelength * perimeter);
}

double ring_laser_scale_factor(int corners, double side, double wavelength) {
  return side / (wavelength * std::tan(pi / corners));
}

double ring_laser_scale_factor(const Settings& truth) {
  if (truth.has("scale_factor")) return truth.number("scale_factor");
  const double wavelength = truth.number("wavelength");
  if (truth.has("area")) return ring_laser_scale_factor(truth.number("area"), truth.number("perimeter"), wavelength);
  return ring_laser_scale_factor(truth.word("shape") == "triangle" ? 3 : 4, truth.number("side"), wavelength);
}

double coil_path_difference(double length, double diameter, double rate) {
  return length * diameter * rate / speed_of_light;
}

double coil_phase_difference(double length, double diameter, double wavelength, double rate) {
  return two_pi / wavelength * coil_path_difference(length, diameter, rate);
}

}  // namespace tumble
