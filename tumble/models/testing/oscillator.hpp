#pragma once

namespace tumble::testing {

/// Angle and angular rate of what turns about one axis.
struct Swing {
  double angle = 0.0, rate = 0.0;
};

/// One step of the classical Runge-Kutta method for angle'' = acceleration(time, swing).
template <class Acceleration>
Swing runge_kutta(Swing at, double time, double step, Acceleration acceleration) {
  const auto moved = [](Swing a, Swing slope, double by) {
    return Swing{a.angle + by * slope.angle, a.rate + by * slope.rate};
  };
  const auto slope = [&](double when, Swing a) { return Swing{a.rate, acceleration(when, a)}; };
  const Swing k1 = slope(time, at);
  const Swing k2 = slope(time + 0.5 * step, moved(at, k1, 0.5 * step));
  const Swing k3 = slope(time + 0.5 * step, moved(at, k2, 0.5 * step));
  const Swing k4 = slope(time + step, moved(at, k3, step));
  return {at.angle + step / 6.0 * (k1.angle + 2.0 * k2.angle + 2.0 * k3.angle + k4.angle),
          at.rate + step / 6.0 * (k1.rate + 2.0 * k2.rate + 2.0 * k3.rate + k4.rate)};
}

}  // namespace tumble::testing
