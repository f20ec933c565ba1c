#include "tumble/models/lock_zones.hpp"

#include <boost/math/special_functions/bessel.hpp>
#include <cmath>

#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

double width_of(const LockIn& lock_in, double excursion, int n) {
  return lock_in.rate * std::abs(boost::math::cyl_bessel_j(std::abs(n), excursion));
}

/// The pull of all zones but n at an input rate. Beyond x + 8 x^(1/3) + 16 Bessel functions are below 1e-12.
double pull_at(const LockIn& lock_in, const Dither& dither, int n, double input_rate) {
  const double x = phase_excursion(lock_in, dither), spacing = dither.frequency / lock_in.scale_factor;
  const int last = static_cast<int>(x + 8.0 * std::cbrt(x) + 16.0);
  double pull = 0.0;
  for (int m = 0; m <= last; ++m) {
    const double width = width_of(lock_in, x, m), square = 0.5 * width * width;
    if (m != n) pull -= square / (input_rate - m * spacing);
    if (m != 0 && -m != n) pull -= square / (input_rate + m * spacing);
  }
  return pull;
}

}  // namespace

double phase_excursion(const LockIn& lock_in, const Dither& dither) {
  return lock_in.scale_factor * dither.rate / dither.frequency;
}

double angle_random_walk_from_lock_in(const LockIn& lock_in, const Dither& dither) {
  return lock_in.rate / std::sqrt(2.0 * pi * lock_in.scale_factor * dither.rate);
}

double residual_lock_in_rate(const LockIn& lock_in, const Dither& dither) {
  return lock_in.rate * std::sqrt(2.0 / (pi * phase_excursion(lock_in, dither)));
}

LockZone lock_zone(const LockIn& lock_in, const Dither& dither, int n) {
  const double centre = n * dither.frequency / lock_in.scale_factor;
  return {centre, width_of(lock_in, phase_excursion(lock_in, dither), n), pull_at(lock_in, dither, n, centre)};
}

double output_near_zone(const LockIn& lock_in, const Dither& dither, int n, double input_rate) {
  const double centre = n * dither.frequency / lock_in.scale_factor;
  const double width = width_of(lock_in, phase_excursion(lock_in, dither), n);
  const double d = input_rate - centre + pull_at(lock_in, dither, n, input_rate);
  const double square = (d - width) * (d + width);
  return square > 0.0 ? centre + std::copysign(std::sqrt(square), d) : centre;
}

}  // namespace tumble
