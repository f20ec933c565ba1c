#include "tumble/exchange/calibration.hpp"

#include <algorithm>
#include <cmath>

namespace tumble {

double DepartureTable::operator()(double u) const {
  if (at.empty()) return 0.0;
  double value = departure[0];
  for (std::size_t k = 1; k < at.size() && u > at[k - 1]; ++k) {
    const double slope = (departure[k] - departure[k - 1]) / (at[k] - at[k - 1]);
    value = u < at[k] ? departure[k - 1] + slope * (u - at[k - 1]) : departure[k];
  }
  return value;
}

double DepartureTable::steepest() const {
  double most = 0.0;
  for (std::size_t k = 1; k < at.size(); ++k)
    most = std::max(most, std::abs((departure[k] - departure[k - 1]) / (at[k] - at[k - 1])));
  return most;
}

bool OwnCurve::is_zero() const {
  return table.at.empty() && magnitude == 0.0 && signed_square == 0.0 &&
         std::ranges::all_of(power, [](double p) { return p == 0.0; });
}

double OwnCurve::operator()(double u) const {
  double sum = 0.0;
  for (std::size_t k = power.size(); k-- > 0;) sum = (sum + power[k]) * u;
  return sum * u + magnitude * std::abs(u) + signed_square * u * std::abs(u) + table(u);
}

double polynomial_without_constant(const std::vector<double>& coefficients, double d) {
  double sum = 0.0;
  for (std::size_t k = coefficients.size(); k-- > 0;) sum = (sum + coefficients[k]) * d;
  return sum;
}

std::vector<double> shifted_polynomial(std::vector<double> coefficients, double at) {
  for (std::size_t first = 0; first + 1 < coefficients.size(); ++first)
    for (std::size_t k = coefficients.size() - 1; k-- > first;) coefficients[k] += at * coefficients[k + 1];
  return coefficients;
}

bool TriadCalibration::has_noise() const {
  return std::ranges::any_of(noise, [](const AxisNoise& n) {
    return !std::isnan(n.white) || !std::isnan(n.walk) || !std::isnan(n.instability);
  });
}

namespace {

double kelvins_from_reference(const ImuCalibration& calibration, const ImuSample& sample) {
  return std::isnan(calibration.reference_temperature) ? 0.0 : sample.temperature - calibration.reference_temperature;
}

/// [a x r_i + w x (w x r_i)]_i
Vector3 lever_effect(const Matrix3& lever, Vector3 rate, Vector3 acceleration) {
  Vector3 effect;
  for (std::size_t i = 0; i < 3; ++i)
    effect[i] = (cross(acceleration, lever[i]) + cross(rate, cross(rate, lever[i])))[i];
  return effect;
}

bool has_levers(const TriadCalibration& triad) {
  return norm(triad.lever.x) > 0.0 || norm(triad.lever.y) > 0.0 || norm(triad.lever.z) > 0.0;
}

/// u_r of u, and back.
Vector3 at_reference(const TriadCalibration& triad, Vector3 u, double d) {
  for (std::size_t i = 0; i < 3; ++i)
    u[i] = (u[i] + polynomial_without_constant(triad.thermal[i].bias, d)) /
           (1.0 + polynomial_without_constant(triad.thermal[i].scale, d));
  return u;
}

Vector3 at_temperature(const TriadCalibration& triad, Vector3 u, double d) {
  for (std::size_t i = 0; i < 3; ++i)
    u[i] = u[i] * (1.0 + polynomial_without_constant(triad.thermal[i].scale, d)) -
           polynomial_without_constant(triad.thermal[i].bias, d);
  return u;
}

Vector3 bias_at(const TriadCalibration& triad, double d) {
  Vector3 bias = triad.bias;
  for (std::size_t i = 0; i < 3; ++i) bias[i] += polynomial_without_constant(triad.thermal[i].output, d);
  return bias;
}

Vector3 curves(const TriadCalibration& triad, Vector3 u) {
  return {triad.curve[0](u.x), triad.curve[1](u.y), triad.curve[2](u.z)};
}

/// One triad with the matrix and the bias of one temperature.
struct TriadInverse {
  const TriadCalibration& triad;
  double d;
  Matrix3 inverse;
  Vector3 bias;

  TriadInverse(const TriadCalibration& of, double kelvins)
      : triad(of), d(kelvins), inverse(tumble::inverse(of.response)), bias(bias_at(of, kelvins)) {}

  /// The next u, from the one so far and what the other triad gives.
  Vector3 next(Vector3 output, Vector3 from_other, Vector3 u) const {
    const Vector3 curved = curves(triad, at_reference(triad, u, d));
    return at_temperature(triad, inverse * (output - bias - from_other - curved), d);
  }
};

}  // namespace

ImuSample outputs_of(const ImuCalibration& calibration, const ImuSample& truth) {
  const auto& [force, rate] = std::tie(calibration.accelerometers, calibration.gyros);
  const double d = kelvins_from_reference(calibration, truth);
  ImuSample out = truth;
  const Vector3 f = at_reference(force, truth.force, d), w = at_reference(rate, truth.rate, d);
  out.force = bias_at(force, d) + force.response * f + curves(force, f) +
              lever_effect(force.lever, truth.rate, truth.angular_acceleration);
  out.rate = bias_at(rate, d) + rate.response * w + curves(rate, w) + rate.by_force * truth.force;
  return out;
}

ImuSample compensated(const ImuCalibration& calibration, const ImuSample& outputs) {
  constexpr int most = 100;
  const double d = kelvins_from_reference(calibration, outputs);
  const TriadInverse force(calibration.accelerometers, d), rate(calibration.gyros, d);
  const bool levers = has_levers(calibration.accelerometers);
  ImuSample u = outputs;
  u.force = u.rate = {};
  for (int pass = 0; pass < most; ++pass) {
    const ImuSample before = u;
    const Vector3 by_levers =
        levers ? lever_effect(calibration.accelerometers.lever, u.rate, outputs.angular_acceleration) : Vector3{};
    u.force = force.next(outputs.force, by_levers, u.force);
    u.rate = rate.next(outputs.rate, calibration.gyros.by_force * u.force, u.rate);
    if (norm(u.force - before.force) <= 1e-16 * norm(u.force) && norm(u.rate - before.rate) <= 1e-16 * norm(u.rate))
      break;
  }
  return u;
}

bool take_measured(TriadCalibration& triad) {
  bool any = false;
  for (std::size_t i = 0; i < 3; ++i) {
    const MeasuredLine& line = triad.measured[i];
    if (line.departures.at.empty()) continue;
    any = true;
    triad.response(i, i) = line.slope;
    triad.bias[i] = line.bias;
    triad.curve[i] = {.table = line.departures};
  }
  return any;
}

void set_missing_ranges(ImuCalibration& calibration) {
  const double usual_rate = si(100.0, "deg/s"), usual_force = si(1.0, "g");
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(calibration.gyros.range[i] > 0.0)) calibration.gyros.range[i] = usual_rate;
    if (!(calibration.accelerometers.range[i] > 0.0)) calibration.accelerometers.range[i] = usual_force;
  }
}

namespace {

constexpr std::initializer_list<double> fine{-1.0, -0.5, 0.0, 0.5, 1.0}, coarse{-1.0, 0.0, 1.0}, ends{-1.0, 1.0},
    zero{0.0};

bool has_curves(const TriadCalibration& triad) {
  return !std::ranges::all_of(triad.curve, [](const OwnCurve& curve) { return curve.is_zero(); });
}

bool has_temperature(const TriadCalibration& triad) {
  return std::ranges::any_of(triad.thermal, [](const AxisThermal& axis) {
    return !axis.output.empty() || !axis.scale.empty() || !axis.bias.empty();
  });
}

/// These shares of the range, on all axes.
std::vector<Vector3> grid(Vector3 range, std::initializer_list<double> shares) {
  std::vector<Vector3> points;
  for (const double x : shares)
    for (const double y : shares)
      for (const double z : shares) points.push_back({x * range.x, y * range.y, z * range.z});
  return points;
}

std::vector<double> temperatures(const ImuCalibration& calibration) {
  constexpr int steps = 8;
  const bool matters = has_temperature(calibration.accelerometers) || has_temperature(calibration.gyros);
  if (!matters || std::isnan(calibration.coldest) || std::isnan(calibration.hottest)) return {293.15};
  std::vector<double> all;
  for (int k = 0; k <= steps; ++k)
    all.push_back(calibration.coldest + (calibration.hottest - calibration.coldest) * k / steps);
  return all;
}

double largest(Vector3 v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

}  // namespace

double error_without(const ImuCalibration& calibration, const CalibrationTerm& term) {
  ImuCalibration whole = calibration, part = calibration;
  set_missing_ranges(whole);
  term.remove(part);
  const bool gyro = term.gyro;
  // what the other triad feels matters by G and the levers alone
  const auto own = has_curves(gyro ? whole.gyros : whole.accelerometers) ? fine : coarse;
  const auto other =
      find_calibration_term(gyro ? "gyro_acceleration_sensitivity" : "accelerometer_lever").is_in(whole) ? ends : zero;
  const auto forces = grid(whole.accelerometers.range, gyro ? other : own);
  const auto rates = grid(whole.gyros.range, gyro ? own : other);
  double worst = largest(whole.gyros.transient - part.gyros.transient);
  for (const double temperature : temperatures(whole))
    for (const Vector3 force : forces)
      for (const Vector3 rate : rates) {
        const ImuSample truth{force, rate, temperature, {}};
        const ImuSample found = compensated(part, outputs_of(whole, truth));
        worst = std::max(worst, largest(gyro ? found.rate - rate : found.force - force));
      }
  return worst;
}

}  // namespace tumble
