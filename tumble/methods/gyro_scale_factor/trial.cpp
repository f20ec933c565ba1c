#include "tumble/methods/gyro_scale_factor/trial.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/rigs/rig.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::scale {
namespace {

constexpr double asymmetry = 60e-6, third_order = 150e-6, scale_error = 120e-6;

/// What the electronics make of the rate [rad/s]: V, relative to the scale factor.
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

}  // namespace

Trial trial(std::uint64_t seed, const std::vector<Option>& options) {
  Trial trial;
  Plan& plan = trial.evidence.plan;
  plan.method = "gyro_scale_factor";
  plan.settings = defaults(options);
  plan.instrument_model = "ring_laser_gyro";
  plan.sample_rate = 1.0;
  plan.site = Site{.latitude = si(34.25, "deg"), .height = 400.0};
  plan.rig_kind = "rate_table";
  plan.rig = defaults(find_rig("rate_table").options());
  plan.truth = defaults(truth_options(find_model("ring_laser_gyro")));
  plan.truth.set_word("output", "rate");
  plan.truth.set_number("bias", si(12.0, "deg/h"), Unit::parse("deg/h"));
  plan.truth.set_number("scale_factor_error", scale_error, Unit::parse("ppm"));
  plan.truth.set_number("angle_random_walk", si(0.05, "deg/sqrt(h)"), Unit::parse("deg/sqrt(h)"));
  std::vector<double> up{-100, -70, -40, -20, -10, -4, 0, 4, 10, 20, 40, 70, 100}, rates = up;
  rates.insert(rates.end(), up.rbegin(), up.rend());
  double fourth = 0.0, second = 0.0;
  for (std::size_t k = 0; k < rates.size(); ++k) {
    Segment segment{fmt::format("{} {} deg/s", k + 1, rates[k]), 36.0, 1, {}};
    segment.axes["table"] = {.kind = Motion::Kind::rate, .value = si(rates[k], "deg/s")};
    if (k == 0) segment.axes["mount_pitch"] = {.kind = Motion::Kind::hold, .value = si(-90.0, "deg")};
    plan.schedule.push_back(segment);
    rates[k] = si(rates[k], "deg/s");
    second += rates[k] * rates[k];
    fourth += std::pow(rates[k], 4);
  }
  const double range = si(100.0, "deg/s"), own = fourth / second / (range * range);
  Recording recording = simulate(plan, seed, {});
  const double volts = 0.05 / si(1.0, "deg/s");
  for (Channel& channel : recording.channels) {
    if (channel.name != "gyro") continue;
    for (double& v : channel.values) v = volts * distorted(v, range, own);
    channel.kind = QuantityKind::other;
    channel.unit = Unit::parse("V");
  }
  trial.evidence.recordings.push_back(std::move(recording));
  trial.truth = {{"scale_factor", volts * (1.0 + scale_error)},
                 {"bias", si(12.0, "deg/h") / (1.0 + scale_error)},
                 {"scale_factor_asymmetry", asymmetry},
                 {"third_order_coefficient", third_order},
                 {"nonlinearity", largest_departure(rates, range, own)}};
  return trial;
}

}  // namespace tumble::scale
