#include "tumble/models/fiber_optic_gyro/shupe.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/units/unit.hpp"

namespace tumble::fiber_optic_gyro {
namespace {

double deg_per_hour(double rate) { return Unit::parse("deg/h").from_si(rate); }

// Tdot = G z/L, G = 0.01 K/s: n (dn/dT + n alpha) G L/(6 D). Sections of 1/N of the fibre miss 1/N^2 of it.
TEST(Shupe, LinearRampAlongTheFibre) {
  const Coil coil{.length = 1000.0, .diameter = 0.1};
  std::vector<double> rates(10000);
  for (std::size_t i = 0; i < rates.size(); ++i) rates[i] = 0.01 * (static_cast<double>(i) + 0.5) / 10000.0;
  EXPECT_NEAR(deg_per_hour(shupe_rate(coil, rates)), 53.8227, 5e-5);
}

TEST(Shupe, SymmetricAboutTheMiddleIsNothing) {
  std::vector<double> rates(1001), odd(1001);
  for (std::size_t i = 0; i < rates.size(); ++i) {
    const double u = (static_cast<double>(i) - 500.0) / 500.0;
    rates[i] = 0.01 * (1.0 + u * u - std::pow(u, 4));
    odd[i] = 0.01 * u;
  }
  EXPECT_NEAR(deg_per_hour(shupe_rate({}, rates)), 0.0, 1e-10);
  EXPECT_GT(deg_per_hour(shupe_rate({}, odd)), 50.0);
}

/// Drift for layers whose temperature rate is the layer's number to the power n.
double drift(Winding winding, int layers, int power) {
  const auto weights = layer_weights({.winding = winding, .layers = layers});
  double sum = 0.0;
  for (std::size_t l = 0; l < weights.size(); ++l) sum += weights[l] * std::pow(static_cast<double>(l), power);
  return sum;
}

// A rate linear in the layer: plain M (M^2 - 1)/6, dipole M^2/4, quadrupole -M/2 in units of (L/M)^2. Of the plain
// winding's drift the dipole leaves 3/(2 M), the quadrupole 3/M^2.
TEST(Shupe, DipoleAndQuadrupoleSuppressALinearGradient) {
  for (const int M : {4, 16, 32, 80}) {
    const double unit = std::pow(1000.0 / M, 2), m = M;
    EXPECT_NEAR(drift(Winding::plain, M, 1) / unit, m * (m * m - 1.0) / 6.0, 1e-9 * m * m * m);
    EXPECT_NEAR(drift(Winding::dipole, M, 1) / unit, m * m / 4.0, 1e-9 * m * m * m);
    EXPECT_NEAR(drift(Winding::quadrupole, M, 1) / unit, -m / 2.0, 1e-9 * m * m * m);
    // one rate for all layers is nothing
    for (const Winding winding : {Winding::plain, Winding::dipole, Winding::quadrupole})
      EXPECT_NEAR(drift(winding, M, 0) / unit, 0.0, 1e-9 * m * m);
  }
}

/// Explicit finite differences across the thickness, cells much finer than the layers: independent of the series.
std::vector<double> by_differences(const Coil& coil, double seconds, double from, double by_outer, double by_inner) {
  const int cells = 4 * coil.layers;
  const double h = coil.thickness / cells, step = 0.2 * h * h / coil.diffusivity;
  const int steps = static_cast<int>(std::ceil(seconds / step));
  const double r = coil.diffusivity * (seconds / steps) / (h * h);
  std::vector<double> t(static_cast<std::size_t>(cells) + 2, from);
  for (int k = 0; k < steps; ++k) {
    const double part = (k + 0.5) / steps, outer = from + by_outer * part, inner = from + by_inner * part;
    t.back() = 2.0 * outer - t[t.size() - 2];
    t.front() = coil.inner_insulated ? t[1] : 2.0 * inner - t[1];
    auto next = t;
    for (std::size_t i = 1; i + 1 < t.size(); ++i) next[i] = t[i] + r * (t[i - 1] - 2.0 * t[i] + t[i + 1]);
    t = next;
  }
  std::vector<double> layers;
  for (std::size_t l = 0; l < static_cast<std::size_t>(coil.layers); ++l)
    layers.push_back(0.25 * (t[4 * l + 1] + t[4 * l + 2] + t[4 * l + 3] + t[4 * l + 4]));
  return layers;
}

// Ramps of the faces. The differences miss a part (1/cells)^2 of the change, 2e-4 of 10 K at 64 cells.
TEST(CoilHeat, FollowsTheHeatEquation) {
  for (const bool insulated : {true, false}) {
    const Coil coil{.layers = 16, .inner_insulated = insulated};
    CoilHeat heat(coil, 300.0, 300.0);
    for (int k = 1; k <= 10; ++k) heat.advance(5.0, 300.0 + k, 300.0 - 0.3 * k);
    const auto expected = by_differences(coil, 50.0, 300.0, 10.0, -3.0), found = heat.layers();
    for (std::size_t l = 0; l < found.size(); ++l) EXPECT_NEAR(found[l], expected[l], 2.5e-3) << l;
  }
}

// A step of the outer face: T = 1 - sum 2 (-1)^n/k_n exp(-a k_n^2 t/H^2) cos(k_n x/H), k_n = (n + 1/2) pi
// (Carslaw and Jaeger, Conduction of Heat in Solids, 1959, section 3.4); at x = 0 and a t/H^2 = 0.2: 0.2277.
TEST(CoilHeat, StepOfAnInsulatedSlab) {
  const Coil coil{.layers = 200};
  const double time = coil.thickness * coil.thickness / coil.diffusivity, instant = 1e-9 * time;
  CoilHeat heat(coil, 0.0, 0.0);
  heat.advance(instant, 1.0, 0.0);
  heat.advance(0.2 * time, 1.0, 0.0);
  double series = 1.0;
  for (int n = 0; n < 20; ++n) {
    const double k = (n + 0.5) * 3.14159265358979324;
    series -= 2.0 * (n % 2 == 0 ? 1.0 : -1.0) / k * std::exp(-0.2 * k * k);
  }
  EXPECT_NEAR(heat.layers().front(), series, 2e-5);  // the mean of the first of 200 layers is not quite x = 0
}

// A ramp s leaves, once settled, every layer behind its face by s (H^2 - x^2)/(2 a) (insulated at x = 0): all at one
// rate, so that no winding drifts any more, and the angle gained till then is that of the lag.
TEST(CoilHeat, DriftsAtTheBeginningOfARampAndNotLater) {
  double angles[3]{};
  for (const Winding winding : {Winding::plain, Winding::dipole, Winding::quadrupole}) {
    const Coil coil{.winding = winding};
    CoilHeat heat(coil, 293.0, 293.0);
    const double ramp = 1.0 / 60.0;  // [K/s]
    double drift = 0.0, angle = 0.0;
    for (int k = 1; k <= 8000; ++k) angle += drift = heat.advance(1.0, 293.0 + ramp * k, 293.0);
    EXPECT_NEAR(deg_per_hour(drift), 0.0, 1e-9);
    const auto weights = layer_weights(coil);
    double expected = 0.0;
    for (std::size_t l = 0; l < weights.size(); ++l) {
      const double square = (std::pow(static_cast<double>(l) + 0.5, 2) + 1.0 / 12.0) / std::pow(coil.layers, 2);
      expected -= weights[l] * ramp * coil.thickness * coil.thickness * (1.0 - square) / (2.0 * coil.diffusivity);
    }
    expected *= coil.index / (coil.length * coil.diameter) * (coil.index_slope + coil.index * coil.expansion);
    EXPECT_NEAR(angle, expected, 2e-5 * std::abs(expected) + 1e-5 * std::abs(angles[0]));  // 128 modes
    angles[static_cast<int>(winding)] = angle;
  }
  // Of a parabola the dipole leaves 2/M, the quadrupole 6/M^2, both to leading order in 1/M.
  EXPECT_NEAR(std::abs(angles[1] / angles[0]), 2.0 / 32.0, 0.1 * 2.0 / 32.0);
  EXPECT_NEAR(std::abs(angles[2] / angles[0]), 6.0 / 1024.0, 0.1 * 6.0 / 1024.0);
}

// The drift adds up to the change of the weighted temperature, however the time is divided.
TEST(CoilHeat, DoesNotDependOnHowTheTimeIsDivided) {
  const Coil coil{.winding = Winding::dipole, .inner_insulated = false};
  CoilHeat coarse(coil, 300.0, 300.0), fine(coil, 300.0, 300.0);
  const double whole = coarse.advance(60.0, 301.0, 299.5);
  double mean = 0.0;
  for (int k = 1; k <= 60; ++k) mean += fine.advance(1.0, 300.0 + k / 60.0, 300.0 - 0.5 * k / 60.0) / 60.0;
  EXPECT_NEAR(whole, mean, 1e-9 * std::abs(whole));
}

}  // namespace
}  // namespace tumble::fiber_optic_gyro
