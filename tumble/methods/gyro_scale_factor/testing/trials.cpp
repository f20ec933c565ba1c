#include "tumble/methods/testing/trials.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/methods/gyro_scale_factor/testing/trial.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::gyro_scale_factor {
namespace {

/// What the two trials differ in.
struct Truth {
  double asymmetry, third_order, scale_error;
  double bias;                ///< [deg/h]
  double volts;               ///< for 1 deg/s
  std::vector<double> rates;  ///< [deg/s], each of `dwell` [s]
  double dwell;
  double latitude;       ///< [deg]
  double start;          ///< [s] of the first stamp
  std::size_t lost = 0;  ///< each sample of that number is missing; 0: none
};

/// Output of the electronics [relative to the scale factor] at a rate [rad/s].
double distorted(double rate, const Truth& truth, double range, double own) {
  const double u = rate / range;
  return rate + 0.5 * truth.asymmetry * std::abs(rate) + truth.third_order * range * (u * u * u - own * u);
}

/// Largest departure of the noise-free output from its least-squares line, over the range.
double largest_departure(const std::vector<double>& rates, const Truth& truth, double range, double own) {
  double mean = 0.0, slope = 0.0, squares = 0.0, most = 0.0;
  std::vector<double> d;
  for (const double w : rates) {
    d.push_back(distorted(w, truth, range, own) - w);
    mean += d.back() / static_cast<double>(rates.size());
    slope += d.back() * w;
    squares += w * w;
  }
  for (std::size_t i = 0; i < d.size(); ++i)
    most = std::max(most, std::abs(d[i] - mean - slope / squares * rates[i]) / range);
  return most;
}

Plan plan_of(const std::vector<Option>& options, const Truth& truth) {
  Plan plan = trial_plan("gyro_scale_factor", options, "ring_laser_gyro", "rate_table", 1.0);
  plan.site->latitude = si(truth.latitude, "deg");
  plan.truth.set_word("output", "rate");
  set_truth(plan, "bias", truth.bias, "deg/h");
  plan.truth.set_number("scale_factor_error", truth.scale_error, Unit::parse("ppm"));
  set_truth(plan, "angle_random_walk", 0.05, "deg/sqrt(h)");
  for (std::size_t k = 0; k < truth.rates.size(); ++k) {
    Segment segment{fmt::format("{} {} deg/s", k + 1, truth.rates[k]), truth.dwell, 1, {}};
    segment.axes["table"] = {.kind = Motion::Kind::rate, .value = si(truth.rates[k], "deg/s")};
    if (k == 0) segment.axes["mount_pitch"] = {.kind = Motion::Kind::hold, .value = si(-90.0, "deg")};
    plan.schedule.push_back(segment);
  }
  return plan;
}

/// The gyro's rate as volts of its electronics, on a clock that begins elsewhere, with samples missing.
void pass_through_electronics(const Truth& truth, double range, double own, Recording& recording) {
  const double volts = truth.volts / si(1.0, "deg/s");
  for (Mark& mark : recording.marks) mark.begin += truth.start;
  for (Channel& channel : recording.channels) {
    channel.timeline.start += truth.start;
    if (channel.name != "gyro") continue;
    for (std::size_t i = 0; i < channel.values.size(); ++i) {
      channel.values[i] = volts * distorted(channel.values[i], truth, range, own);
      if (truth.lost > 0 && i % truth.lost == truth.lost - 1) channel.values[i] = std::nan("");
    }
    channel.kind = QuantityKind::other;
    channel.unit = Unit::parse("V");
  }
}

Trial trial_of(std::uint64_t seed, const std::vector<Option>& options, const Truth& truth) {
  Trial trial;
  trial.evidence.plan = plan_of(options, truth);
  double fourth = 0.0, second = 0.0, range = 0.0;
  std::vector<double> rates;
  for (const double rate : truth.rates) {
    const double w = si(rate, "deg/s");
    rates.push_back(w);
    second += w * w;
    fourth += std::pow(w, 4);
    range = std::max(range, std::abs(w));
  }
  const double own = fourth / second / (range * range);
  Recording recording = simulate(trial.evidence.plan, seed, {});
  pass_through_electronics(truth, range, own, recording);
  trial.evidence.recordings.push_back(std::move(recording));
  trial.truth = {{"scale_factor", truth.volts / si(1.0, "deg/s") * (1.0 + truth.scale_error)},
                 {"bias", si(truth.bias, "deg/h") / (1.0 + truth.scale_error)},
                 {"scale_factor_asymmetry", truth.asymmetry},
                 {"third_order_coefficient", truth.third_order},
                 {"nonlinearity", largest_departure(rates, truth, range, own)}};
  return trial;
}

}  // namespace

Trial trial(std::uint64_t seed, const std::vector<Option>& options) {
  Truth truth{60e-6, 150e-6, 120e-6, 12.0, 0.05, {-100, -70, -40, -20, -10, -4, 0, 4, 10, 20, 40, 70, 100},
              36.0,  34.25,  0.0};
  const std::vector<double> up = truth.rates;  // and down again
  truth.rates.insert(truth.rates.end(), up.rbegin(), up.rend());
  return trial_of(seed, options, truth);
}

Trial second_trial(std::uint64_t seed, const std::vector<Option>& options) {
  return trial_of(seed, options,
                  {-90e-6,
                   -220e-6,
                   -310e-6,
                   -30.0,
                   0.02,
                   {80, -80, 50, -50, 30, -30, 12, -12, 5, -5, 50, -50, 80, -80},
                   47.0,
                   -41.0,
                   1234.5,
                   19});
}

extern const Trials trials{
    [](std::uint64_t seed) { return trial(seed, find_method("gyro_scale_factor").options()); },
    [](std::uint64_t seed) { return second_trial(seed, find_method("gyro_scale_factor").options()); }};

}  // namespace tumble::gyro_scale_factor
