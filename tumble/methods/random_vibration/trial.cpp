#include "tumble/methods/random_vibration/trial.hpp"

#include <cmath>
#include <numbers>

#include "tumble/earth/earth.hpp"
#include "tumble/methods/random_vibration/spectrum.hpp"
#include "tumble/methods/trial/plan.hpp"
#include "tumble/methods/vibration/vibration.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::random_vibration {
namespace {

constexpr double rate = 200.0, at_rest = 20.0, vibrating = 60.0, settling = 0.5;
constexpr int oversampling = 25;

/// The point at 20.8 Hz is there to make the edge at 20 Hz steep: it is smoothed over a quarter of the least distance.
SpectralDensity density() {
  const double s = si(0.1, "g^2/Hz");
  return {{20.0, 20.8, 2000.0}, {s, s, s}};
}

Plan plan_of(const std::vector<Option>& options) {
  Plan plan = methods::trial_plan("random_vibration", options, "pendulous_accelerometer", "shaker", rate);
  plan.settings.set_word("scale_factor", "2000 pulse/s/g");
  plan.settings.set_number("scale_factor_sd", 1e-4, Unit::parse("%"));
  plan.settings.set_number("settling", settling, Unit::parse("s"));
  const auto psd = density();
  // A level known to 0.1 %: with more, it alone would be what the intervals of the mean are made of.
  plan.rig.set_number("amplitude_sd", 1e-3, Unit::parse("%"));
  plan.schedule = {
      {"before", at_rest, 1, {{"shake", Motion{}}}},
      {"random",
       vibrating,
       1,
       {{"shake", Motion{.kind = Motion::Kind::random, .psd_frequency = psd.frequency, .psd = psd.density}}}},
      {"after", at_rest, 1, {{"shake", Motion{}}}}};
  plan.truth.set_word("output", "count");
  plan.truth.set_integer("oversampling", oversampling);
  methods::set_truth(plan, "pulse_scale_factor", 2000.0, "pulse/s/g");
  methods::set_truth(plan, "bias", 3.0, "mg");
  methods::set_truth(plan, "second_order_coefficient", 20.0, "ug/g^2");
  methods::set_truth(plan, "third_order_coefficient", 0.5, "ug/g^3");
  methods::set_truth(plan, "angle_random_walk", 60.0, "ug/sqrt(Hz)");
  methods::set_truth(plan, "bias_instability", 3.0, "ug");
  return plan;
}

/// Variance of the simulated windows: sums of steps at their middles, not integrals, for which sinc(f H) over
/// sinc(f H/steps) stands.
double variance_of_windows(const SpectralDensity& psd) {
  constexpr int points = 200000;
  const double low = psd.frequency.front(), step = (psd.frequency.back() - low) / points;
  double sum = 0.0;
  for (int i = 0; i < points; ++i) {
    const double f = low + (i + 0.5) * step;
    const double gain = vibration::sinc(f / rate) / vibration::sinc(f / rate / oversampling);
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
  const double a_0 = normal_gravity(site.latitude, site.height), square = variance(density());
  const double rectification = si(20.0, "ug/g^2") + 3.0 * si(0.5, "ug/g^3") * a_0;
  const double walk = si(60.0, "ug/sqrt(Hz)");
  const double sd = std::sqrt(of_windows + walk * walk * rate + std::pow(si(0.1, "g"), 2) / 6.0);
  const double per_force = 2000.0 / si(1.0, "g") / rate;
  const double windows = (vibrating - settling) * rate;
  trial.truth = {{"pulse_error_mean", per_force * rectification * square},
                 {"pulse_error_sd", per_force * sd},
                 {"pulse_error_peak_to_peak", 2.0 * per_force * sd * greatest_of(windows).mean},
                 {"vibration_rectification", rectification}};
  return trial;
}

}  // namespace tumble::random_vibration
