#include "tumble/earth/earth.hpp"

#include <cmath>

#include "tumble/units/constants.hpp"

namespace tumble {

Vector3 earth_rate_in_level(const Site& site) {
  return {0.0, earth_rate * std::cos(site.latitude), earth_rate * std::sin(site.latitude)};
}

double normal_gravity(double latitude, double height) {
  // WGS84: a, f, and what follows from them with GM and the Earth's rate.
  constexpr double a = 6378137.0, f = 1.0 / 298.257223563, e2 = f * (2.0 - f);
  constexpr double gamma_e = 9.7803253359, k = 0.00193185265241, m = 0.00344978650684;
  const double s = std::sin(latitude), s2 = s * s, h = height / a;
  const double on_ellipsoid = gamma_e * (1.0 + k * s2) / std::sqrt(1.0 - e2 * s2);
  return on_ellipsoid * (1.0 - 2.0 * (1.0 + f + m - 2.0 * f * s2) * h + 3.0 * h * h);
}

double gravity(const Site& site) {
  return site.gravity.value_or(normal_gravity(site.latitude, site.height.value_or(0.0)));
}

double gravity_sd(const std::optional<Site>& site) {
  constexpr double measured = 5.0 * micro_g, anomaly = 50.0 * micro_g, anywhere = 0.015;
  constexpr double gradient = 3.086e-6, usual_height = 1000.0;  // [1/s^2], [m]
  if (!site) return anywhere;
  if (site->gravity) return measured;
  return site->height ? anomaly : std::hypot(anomaly, gradient * usual_height);
}

double latitude_sd(const Site& site) { return site.latitude_sd.value_or(10.0 * arcsecond); }

}  // namespace tumble
