#include "tumble/methods/testing/trials.hpp"

#include <cmath>
#include <string>

#include "tumble/earth/earth.hpp"
#include "tumble/methods/random_vibration/spectrum.hpp"
#include "tumble/methods/random_vibration/testing/trial.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/reduce/vibration/vibration.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::random_vibration {
namespace {

constexpr double rate = 200.0, at_rest = 20.0, vibrating = 60.0, settling = 0.5;
constexpr int oversampling = 25;

/// A unit, in the units of its data sheet.
struct Kind {
  double pulses, second_order, third_order, walk, cross_io;
  double rectification(double a_0) const { return si(second_order, "ug/g^2") + 3.0 * si(third_order, "ug/g^3") * a_0; }
  double per_force() const { return si(pulses, "pulse/s/g") / rate; }
};
/// Cross-couplings across each other: motion across moves the units independently, as that of two types does.
constexpr Kind first{2000.0, 20.0, 0.5, 60.0, -20.0}, second{2500.0, 45.0, 1.0, 150.0, 20.0};

Settings truth_of(const Kind& unit, Settings truth) {
  const auto set = [&](const char* name, double value, const char* shown) {
    truth.set_number(name, si(value, shown), Unit::parse(shown));
  };
  truth.set_word("output", "count");
  truth.set_integer("oversampling", oversampling);
  set("pulse_scale_factor", unit.pulses, "pulse/s/g");
  set("bias", 3.0, "mg");
  set("second_order_coefficient", unit.second_order, "ug/g^2");
  set("third_order_coefficient", unit.third_order, "ug/g^3");
  set("cross_coupling_ip", 20.0, "ug/g^2");
  set("cross_coupling_io", unit.cross_io, "ug/g^2");
  set("angle_random_walk", unit.walk, "ug/sqrt(Hz)");
  set("bias_instability", 3.0, "ug");
  return truth;
}

/// The point at 20.8 Hz makes the edge at 20 Hz steep: it is smoothed over a quarter of the least distance.
SpectralDensity density() {
  const double s = si(0.1, "g^2/Hz");
  return {{20.0, 20.8, 2000.0}, {s, s, s}};
}

Plan plan_of(const std::vector<Option>& options) {
  Plan plan = trial_plan("random_vibration", options, "pendulous_accelerometer", "shaker", rate);
  plan.settings.set_word("scale_factor", "accelerometer: 2000 pulse/s/g, Q1: 2500 pulse/s/g");
  plan.settings.set_number("scale_factor_sd", 1e-4, Unit::parse("%"));
  plan.settings.set_number("settling", settling, Unit::parse("s"));
  const auto psd = density();
  // A level known to 0.1 %: a larger uncertainty would dominate the intervals of the mean.
  plan.rig.set_number("amplitude_sd", 1e-3, Unit::parse("%"));
  plan.schedule = {
      {"before", at_rest, 1, {{"shake", Motion{}}}},
      {"random",
       vibrating,
       1,
       {{"shake", Motion{.kind = Motion::Kind::random, .psd_frequency = psd.frequency, .psd = psd.density}}}},
      {"after", at_rest, 1, {{"shake", Motion{}}}}};
  plan.truth = truth_of(first, plan.truth);
  plan.beside = {{"Q1", plan.instrument_model, truth_of(second, plan.truth)}};
  return plan;
}

/// Variance of the simulated windows, which are integrals: the gain is sinc(f H).
double variance_of_windows(const SpectralDensity& psd) {
  constexpr int points = 200000;
  const double low = psd.frequency.front(), step = (psd.frequency.back() - low) / points;
  double sum = 0.0;
  for (int i = 0; i < points; ++i) {
    const double f = low + (i + 0.5) * step;
    const double gain = vibration::sinc(f / rate);
    sum += density_at(psd, f) * gain * gain * step;
  }
  return sum;
}

}  // namespace

Trial trial(std::uint64_t seed, const std::vector<Option>& options) {
  static const double of_windows = variance_of_windows(density());
  Trial trial;
  trial.evidence.plan = plan_of(options);
  trial.evidence.recordings = {simulate(trial.evidence.plan, seed, {})};
  const Site& site = *trial.evidence.plan.site;
  const double a_0 = gravity(site), square = variance(density());
  const double peaks = 2.0 * greatest_of((vibrating - settling) * rate).mean;
  const auto sd_of = [&](const Kind& unit) {
    const double walk = si(unit.walk, "ug/sqrt(Hz)");
    // Slope of K_2 a^2 + K_3 a^3 about a_0, mean over the vibration.
    const double slope =
        1.0 + 2.0 * si(unit.second_order, "ug/g^2") * a_0 + 3.0 * si(unit.third_order, "ug/g^3") * (a_0 * a_0 + square);
    return std::sqrt(slope * slope * of_windows + walk * walk * rate +
                     1.0 / 6.0 / (unit.per_force() * unit.per_force()));
  };
  const auto add = [&](const std::string& prefix, const Kind& unit) {
    const double k = unit.per_force(), rectification = unit.rectification(a_0);
    trial.truth.emplace_back(prefix + "pulse_error_mean", k * rectification * square);
    trial.truth.emplace_back(prefix + "pulse_error_sd", k * sd_of(unit));
    trial.truth.emplace_back(prefix + "pulse_error_peak_to_peak", peaks * k * sd_of(unit));
    trial.truth.emplace_back(prefix + "vibration_rectification", rectification);
  };
  add("accelerometer.", first);
  add("Q1.", second);
  const std::string over = "accelerometer_over_Q1.";
  trial.truth.emplace_back(over + "mean_ratio", first.rectification(a_0) / second.rectification(a_0));
  trial.truth.emplace_back(over + "sd_ratio", sd_of(first) / sd_of(second));
  trial.truth.emplace_back(over + "peak_to_peak_ratio", sd_of(first) / sd_of(second));
  return trial;
}

extern const Trials trials{
    [](std::uint64_t seed) { return trial(seed, find_method("random_vibration").options()); },
    [](std::uint64_t seed) { return second_trial(seed, find_method("random_vibration").options()); }};

}  // namespace tumble::random_vibration
