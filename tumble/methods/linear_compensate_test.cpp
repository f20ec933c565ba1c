// Truth simulated, identified, and subtracted from a second recording: what remains is noise of the size stated.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/reduce/compensate.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/sim/power_up.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

void silence(Plan& plan) {
  plan.rig.set_flag("ideal", true);
  for (const char* name : {"angle_random_walk", "bias_instability", "rate_random_walk", "turn_on_sd"})
    if (plan.truth.has(name)) plan.truth.set_number(name, 0.0, Unit());
}

/// A later use of the trial's instrument, without noise and rig errors, so that the plan says exactly what was felt.
struct Use {
  Plan plan;
  Recording recording;
  std::vector<Felt> felt;  ///< at the middle of every sample
};

/// Pulses as they would be if parts of one could be counted: their rounding, 1e-4 g in a sample, would hide the rest.
void show_unrounded(const Plan& plan, const std::vector<Felt>& felt, Recording& recording) {
  const Model& model = find_model(plan.instrument_model);
  const Output output = model.outputs(plan.truth).front();
  const auto coefficients = coefficients_of(model, output, plan.truth);
  for (std::size_t i = 0; i < felt.size(); ++i) {
    double sum = output.input(felt[i]);
    for (std::size_t j = 0; j < coefficients.size(); ++j) sum += coefficients[j] * output.terms[j].regressor(felt[i]);
    recording.channels[0].values[i] = sum * plan.truth.number("pulse_scale_factor") / plan.sample_rate;
  }
}

Use use_of(const Trial& trial) {
  Use use{trial.evidence.plan, {}, {}};
  silence(use.plan);
  use.recording = simulate(use.plan, 1, {});
  const auto run = power_ups(use.plan.schedule, use.plan.sample_rate).front();
  const Reference reference =
      find_rig(use.plan.rig_kind)
          .reference({run.segments, use.plan.rig, use.plan.site, use.plan.sample_rate, {}, RandomStream(0)});
  use.felt.resize(use.recording.channels[0].values.size());
  const double step = 1.0 / use.plan.sample_rate;
  reference.felt(0.5 * step, step, use.felt);
  if (use.recording.channels[0].kind == QuantityKind::count) show_unrounded(use.plan, use.felt, use.recording);
  return use;
}

/// Share of `seeds` identifications whose 95 % interval of what was subtracted holds the truth at sample `at`.
double share_held(const char* name, std::size_t at, double (*truth)(const Felt&), std::uint64_t seeds) {
  const Method& method = find_method(name);
  const Use use = use_of(trial_of(method, 1));
  double held = 0.0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Trial trial = trial_of(method, seed);
    Estimate estimate = method.identify(trial.evidence, {});
    estimate.provenance.settings = trial.evidence.plan.settings.texts();
    const auto done = compensate(estimate, use.recording, &use.plan);
    const Channel& output = done.recording.channels[0];
    const double sd = find_channel(done.recording, output.name + ".compensation_sd")->values[at];
    const double t = student_quantile(0.975, estimate.parameters[0].degrees_of_freedom);
    held += std::abs(output.values[at] - truth(use.felt[at])) < t * sd ? 1.0 : 0.0;
  }
  return held / static_cast<double>(seeds);
}

double rate_of(const Felt& felt) { return felt.rate.x; }
double force_of(const Felt& felt) { return felt.specific_force.x; }

// 100 seeds: the sd of a share of 0.95 is 0.022, four of them 0.087.
TEST(LinearCompensation, HoldsTheDriftOfAGyroAsOftenAsItSays) {
  EXPECT_GE(share_held("sdof_gyro_static", 250, rate_of, 100), 0.86);
}

TEST(LinearCompensation, HoldsTheErrorOfAnAccelerometerAsOftenAsItSays) {
  EXPECT_GE(share_held("accelerometer_tumble", 120, force_of, 100), 0.86);
}

TEST(LinearCompensation, LeavesNothingOfTheTruthItself) {
  using Truth = double (*)(const Felt&);
  for (const auto& [name, truth] :
       {std::pair<const char*, Truth>{"sdof_gyro_static", rate_of}, {"accelerometer_tumble", force_of}}) {
    const Method& method = find_method(name);
    Trial trial = trial_of(method, 1);
    const Use use = use_of(trial);
    trial.evidence.plan = use.plan;
    trial.evidence.recordings = {use.recording};
    Estimate estimate = method.identify(trial.evidence, {});
    estimate.provenance.settings = use.plan.settings.texts();
    const auto done = compensate(estimate, use.recording, &use.plan);
    double worst = 0.0, size = 0.0, outside = 0.0;
    for (const auto& segment : use.recording.marks) {
      const std::size_t i = index_at(done.recording.channels[0], segment.begin + 30.0);
      if (i >= use.felt.size()) continue;
      worst = std::max(worst, std::abs(done.recording.channels[0].values[i] - truth(use.felt[i])));
      outside += find_channel(done.recording, done.recording.channels[0].name + ".extrapolated")->values[i];
      size = std::max(size, std::abs(truth(use.felt[i])));
    }
    // The rounding of the fit is 1e-9 of the output (linear_test); 1e-6 of what is felt lies far below every term.
    EXPECT_LT(worst, 1e-6 * size) << name;
    EXPECT_GT(size, 0.0);
    EXPECT_EQ(outside, 0.0) << name;
  }
}

TEST(LinearCompensation, WithoutAPlanSaysWhichTermsRemain) {
  const Method& method = find_method("sdof_gyro_static");
  const Trial trial = trial_of(method, 1);
  const Use use = use_of(trial);
  Estimate estimate = method.identify(trial.evidence, {});
  estimate.provenance.settings = trial.evidence.plan.settings.texts();
  const auto done = compensate(estimate, use.recording, nullptr);
  EXPECT_TRUE(says(done.findings, "specific_force_x: D_I"));
  // D_F alone is known; what remains in each position is stated: the terms' rms over an even spread of positions
  const auto& sd = find_channel(done.recording, "gyro.compensation_sd")->values;
  double squares = 0.0, stated = 0.0;
  for (const auto& segment : use.recording.marks) {  // at rest: a sample is a mean, what is felt an instant
    const std::size_t i = index_at(done.recording.channels[0], segment.begin + 30.0);
    squares += std::pow(done.recording.channels[0].values[i] - use.felt[i].rate.x, 2);
    stated += sd[i] * sd[i];
  }
  EXPECT_GT(stated, 0.25 * squares);
  EXPECT_LT(stated, 4.0 * squares);
}

TEST(LinearCompensation, ChannelsOfTheRecordingAreTakenBeforeThePlan) {
  const Method& method = find_method("sdof_gyro_static");
  const Trial trial = trial_of(method, 1);
  Use use = use_of(trial);
  Estimate estimate = method.identify(trial.evidence, {});
  estimate.provenance.settings = trial.evidence.plan.settings.texts();
  const auto by_plan = compensate(estimate, use.recording, &use.plan);
  const char* axes[] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k) {
    Channel force{std::string("imu.accelerometer_") + axes[k],
                  QuantityKind::specific_force,
                  Unit::parse("g"),
                  use.recording.channels[0].timeline,
                  {}};
    for (const Felt& felt : use.felt)
      force.values.push_back(k == 0 ? felt.specific_force.x : k == 1 ? felt.specific_force.y : felt.specific_force.z);
    use.recording.channels.push_back(std::move(force));
  }
  const auto by_channels = compensate(estimate, use.recording, nullptr);
  for (std::size_t i = 0; i < use.felt.size(); i += 97)
    EXPECT_NEAR(by_channels.recording.channels[0].values[i], by_plan.recording.channels[0].values[i], 1e-14) << i;
}

Estimate result_of(const Method& method, const Trial& trial) {
  Estimate estimate = method.identify(trial.evidence, {});
  estimate.provenance.settings = trial.evidence.plan.settings.texts();
  return estimate;
}

/// A recording without its first `marks` segments.
Recording cut_off(const Recording& whole, std::size_t marks) {
  Recording cut = whole;
  cut.marks.erase(cut.marks.begin(), cut.marks.begin() + static_cast<std::ptrdiff_t>(marks));
  for (Channel& channel : cut.channels) {
    const std::size_t first = index_at(channel, cut.marks.front().begin);
    channel.timeline.start = channel.time(first);
    channel.values.erase(channel.values.begin(), channel.values.begin() + static_cast<std::ptrdiff_t>(first));
  }
  return cut;
}

TEST(LinearCompensation, SegmentsAreThoseOfTheirLabels) {
  const Method& method = find_method("sdof_gyro_static");
  const Trial trial = trial_of(method, 1);
  const Use use = use_of(trial);
  const Estimate estimate = result_of(method, trial);
  const auto whole = compensate(estimate, use.recording, &use.plan);
  const auto cut = compensate(estimate, cut_off(use.recording, 2), &use.plan);
  const auto &all = whole.recording.channels[0].values, &rest = cut.recording.channels[0].values;
  ASSERT_LT(rest.size(), all.size());
  const std::size_t ahead = all.size() - rest.size();
  // What was felt is the same, computed from another segment's begin: rounding of the time, times the fastest change.
  for (std::size_t i = 0; i < rest.size(); i += 7)
    EXPECT_NEAR(rest[i], all[ahead + i], 1e-9 * std::max(1e-6, std::abs(all[ahead + i]))) << i;
  Recording renamed = use.recording;
  renamed.marks[1].label = "not in the plan";
  const auto blank = compensate(estimate, renamed, &use.plan);
  const std::size_t inside = index_at(use.recording.channels[0], renamed.marks[1].begin + 1.0);
  EXPECT_TRUE(std::isnan(blank.recording.channels[0].values[inside]));
}

TEST(LinearCompensation, AnOutputOfAnotherKindIsRefused) {
  const Method& method = find_method("accelerometer_tumble");
  const Trial trial = trial_of(method, 1);
  Use use = use_of(trial);
  const Estimate estimate = result_of(method, trial);
  for (const char* unit : {"V", "m/s^2", "deg/h"}) {
    use.recording.channels[0].unit = Unit::parse(unit);
    EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {unit}, .pattern = "was calibrated in"}, [&] {
      compensate(estimate, use.recording, &use.plan);
    })) << unit;
  }
}

}  // namespace
}  // namespace tumble
