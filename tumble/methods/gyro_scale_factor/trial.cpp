#include "tumble/methods/gyro_scale_factor/trial.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/reduce/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::gyro_scale_factor {
namespace {

constexpr double asymmetry = 60e-6, third_order = 150e-6, scale_error = 120e-6;
constexpr double bias = 12.0;  ///< [deg/h]

/// Output of the electronics [V, relative to the scale factor] at a rate [rad/s].
double distorted(double rate, double range, double own) {
  const double u = rate / range;
  return rate + 0.5 * asymmetry * std::abs(rate) + third_order * range * (u * u * u - own * u);
}

/// Largest departure of the noise-free output from its least-squares line, over the range.
double largest_departure(const std::vector<double>& rates, double range, double own) {
  double mean = 0.0, slope = 0.0, squares = 0.0, most = 0.0;
  std::vector<double> d;
  for (const double w : rates) {
    d.push_back(distorted(w, range, own) - w);
    mean += d.back() / static_cast<double>(rates.size());
    slope += d.back() * w;
    squares += w * w;
  }
  for (std::size_t i = 0; i < d.size(); ++i)
    most = std::max(most, std::abs(d[i] - mean - slope / squares * rates[i]) / range);
  return most;
}

/// Up and down again. `rates` [deg/s] become [rad/s].
Plan plan_of(const std::vector<Option>& options, std::vector<double>& rates) {
  Plan plan = trial_plan("gyro_scale_factor", options, "ring_laser_gyro", "rate_table", 1.0);
  plan.truth.set_word("output", "rate");
  set_truth(plan, "bias", bias, "deg/h");
  plan.truth.set_number("scale_factor_error", scale_error, Unit::parse("ppm"));
  set_truth(plan, "angle_random_walk", 0.05, "deg/sqrt(h)");
  for (std::size_t k = 0; k < rates.size(); ++k) {
    Segment segment{fmt::format("{} {} deg/s", k + 1, rates[k]), 36.0, 1, {}};
    segment.axes["table"] = {.kind = Motion::Kind::rate, .value = si(rates[k], "deg/s")};
    if (k == 0) segment.axes["mount_pitch"] = {.kind = Motion::Kind::hold, .value = si(-90.0, "deg")};
    plan.schedule.push_back(segment);
    rates[k] = si(rates[k], "deg/s");
  }
  return plan;
}

}  // namespace

Trial trial(std::uint64_t seed, const std::vector<Option>& options) {
  std::vector<double> rates{-100, -70, -40, -20, -10, -4, 0, 4, 10, 20, 40, 70, 100};
  const std::vector<double> up = rates;
  rates.insert(rates.end(), up.rbegin(), up.rend());
  Trial trial;
  trial.evidence.plan = plan_of(options, rates);
  double fourth = 0.0, second = 0.0;
  for (const double w : rates) {
    second += w * w;
    fourth += std::pow(w, 4);
  }
  const double range = si(100.0, "deg/s"), own = fourth / second / (range * range);
  Recording recording = simulate(trial.evidence.plan, seed, {});
  const double volts = 0.05 / si(1.0, "deg/s");
  for (Channel& channel : recording.channels) {
    if (channel.name != "gyro") continue;
    for (double& v : channel.values) v = volts * distorted(v, range, own);
    channel.kind = QuantityKind::other;
    channel.unit = Unit::parse("V");
  }
  trial.evidence.recordings.push_back(std::move(recording));
  trial.truth = {{"scale_factor", volts * (1.0 + scale_error)},
                 {"bias", si(bias, "deg/h") / (1.0 + scale_error)},
                 {"scale_factor_asymmetry", asymmetry},
                 {"third_order_coefficient", third_order},
                 {"nonlinearity", largest_departure(rates, range, own)}};
  return trial;
}

}  // namespace tumble::gyro_scale_factor
