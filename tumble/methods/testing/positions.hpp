#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "tumble/earth/earth.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"

/// For the tests of methods that take positions on a dividing head.
namespace tumble::testing {

constexpr double arcsec = std::numbers::pi / 648000.0;

/// Coefficients of (4.19) and beyond, in units of the local g.
struct Coefficients {
  double k_1 = 1.0, k_0 = 0.0, k_2 = 0.0, k_3 = 0.0, k_ip = 0.0, k_io = 0.0, delta_o = 0.0, delta_p = 0.0;
  double k_pp = 0.0, k_oo = 0.0, k_po = 0.0, k_oq = 0.0;

  double operator()(double i, double p, double o) const {
    return k_1 * (k_0 + i + k_2 * i * i + k_3 * i * i * i + k_ip * i * p + k_io * i * o + delta_o * p - delta_p * o +
                  k_pp * p * p + k_oo * o * o + k_po * p * o + k_oq * i * std::abs(i));
  }
};

/// One position: angle of the head and roll of the mount [deg].
struct Position {
  double angle = 0.0, roll = 0.0;
};

inline std::vector<Position> turn(int n, double roll = 0.0) {
  std::vector<Position> out;
  for (int r = 0; r < n; ++r) out.push_back({360.0 * r / n, roll});
  return out;
}

/// Positions of 20 s at 1 Hz on an ideal head, what the accelerometer shows [V] worked out from its formula: no noise.
/// `error` is what the head is off at an angle [rad].
inline Evidence evidence_of(const std::vector<Position>& positions, const Coefficients& unit,
                            const std::function<double(double)>& error = nullptr) {
  const Method& method = find_method("accelerometer_tumble");
  Evidence evidence{trial_plan(method.name, method.options(), "pendulous_accelerometer", "dividing_head", 1.0), {}, {}};
  evidence.plan.rig.set_flag("ideal", true);
  Recording recording;
  Channel channel{"accelerometer", QuantityKind::other, Unit::parse("V"), {0.0, 1.0, nullptr}, {}};
  for (const auto& [angle, roll] : positions) {
    const std::string label = std::to_string(angle) + " roll " + std::to_string(roll);
    recording.marks.push_back({label, static_cast<double>(channel.values.size()), 1});
    const auto hold = [](double degrees) { return Motion{.kind = Motion::Kind::hold, .value = si(degrees, "deg")}; };
    evidence.plan.schedule.push_back({label, 40.0, 1, {{"head", hold(angle)}, {"mount_roll", hold(roll)}}});
    double th = si(angle, "deg");
    if (error) th += error(th);
    const double phi = si(roll, "deg");
    const double shown = unit(std::sin(th), std::cos(phi) * std::cos(th), -std::sin(phi) * std::cos(th));
    channel.values.insert(channel.values.end(), 40, shown);
  }
  recording.channels.push_back(std::move(channel));
  evidence.recordings.push_back(std::move(recording));
  return evidence;
}

/// The evidence with +-1 mV from second to second, whose mean over a position is zero, and as many samples in the first
/// position as in the others. Beside it no drift between the positions is seen, so that all are weighted alike with any
/// effect that the model does not hold, as harmonics of evenly spaced positions suppose.
inline Evidence evenly_weighted(Evidence evidence) {
  auto& values = evidence.recordings[0].channels[0].values;
  for (std::size_t i = 0; i < values.size(); ++i) values[i] += i % 2 == 0 ? 1e-3 : -1e-3;
  for (std::size_t i = 0; i < 6; ++i) values[i] = std::nan("");
  evidence.plan.settings.set_number("averaging", 1.0, Unit::parse("s"));
  return evidence;
}

/// A parameter in units of the local g; NaN where it is missing.
inline double local(const Estimate& estimate, const std::string& name, const Evidence& evidence) {
  const Parameter* p = find_parameter(estimate, name);
  if (p == nullptr) return std::nan("");
  const double g = gravity(*evidence.plan.site);
  const auto dimension = p->unit.dimension();
  if (dimension == Unit::parse("g").dimension()) return p->value / g;
  if (dimension == Unit::parse("1/g").dimension() || dimension == Unit::parse("V/g").dimension()) return p->value * g;
  return dimension == Unit::parse("1/g^2").dimension() ? p->value * g * g : p->value;
}

}  // namespace tumble::testing
