// Truth simulated, identified, and subtracted from a second recording: what remains is zero within the uncertainty.
#include "tumble/reduce/compensate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/imu_channel_calibration/testing/trial.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/rlg_north_finder/outputs.hpp"
#include "tumble/methods/rlg_north_finder/testing/trial.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/models/model.hpp"
#include "tumble/reduce/imu/sensors.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

constexpr double g = 9.80665, sample_rate = 10.0;
constexpr std::uint64_t seeds = 60;
// The sd of a share of 0.95 over 60 seeds is 0.028; four of them.
constexpr double least_share = 0.837;

/// What a unit feels that is turned slowly between faces, all axes at once.
std::vector<Felt> felt_in_use() {
  std::vector<Felt> all;
  for (int i = 0; i < 40; ++i) {
    const double a = 0.7 * i, b = 0.31 * i;
    Felt felt;
    felt.specific_force = {g * std::cos(a) * std::cos(b), g * std::sin(a) * std::cos(b), g * std::sin(b)};
    felt.rate = {si(12.0, "deg/s") * std::sin(b), si(9.0, "deg/s") * std::cos(a), si(-11.0, "deg/s") * std::sin(a + b)};
    all.push_back(felt);
  }
  return all;
}

Channel channel_of(const std::string& name, QuantityKind kind, const char* unit) {
  return {name, kind, Unit::parse(unit), {0.0, sample_rate, nullptr}, {}};
}

/// An output without noise: what it is meant to show, in the order of `felt`, and what it shows.
struct Used {
  std::string channel;
  std::vector<double> truth;  ///< [SI]
};

struct Use {
  Recording recording;
  std::vector<Used> outputs;
  double pulse_share = 1.0;  ///< of a raw value that is the quantity
};

/// The unit's outputs by the table of terms, times `gain(kind)` [1]: pulses in a sample without their rounding.
Use unit_in_use(const Settings& truth, const std::function<double(QuantityKind)>& gain) {
  Use use;
  const auto felt = felt_in_use();
  const Model& model = find_model("imu");
  for (const Output& output : model.outputs(truth)) {
    const bool counts = gain(output.kind) != 1.0;
    Channel channel =
        channel_of(output.channel, counts ? QuantityKind::count : output.kind, counts ? "pulse" : output.unit.c_str());
    Used used{output.channel, {}};
    const auto coefficients = coefficients_of(model, output, truth);
    for (const Felt& one : felt) {
      double sum = output.input(one);
      used.truth.push_back(sum);
      for (std::size_t j = 0; j < coefficients.size(); ++j) sum += coefficients[j] * output.terms[j].regressor(one);
      channel.values.push_back(sum * gain(output.kind));
    }
    use.recording.channels.push_back(std::move(channel));
    use.outputs.push_back(std::move(used));
  }
  return use;
}

double mean_error(const Recording& recording, const Used& used, double gain = 1.0) {
  const auto& values = find_channel(recording, used.channel)->values;
  double sum = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i)
    sum += (values[i] / gain - used.truth[i]) / static_cast<double>(values.size());
  return sum;
}

/// Of one sample: how often its 95 % interval holds the truth, and the root mean square of its error over sd.
struct Held {
  double share = 0.0;                              ///< of errors within the 95 % interval
  double raw = 0.0, residual = 0.0, stated = 0.0;  ///< mean squares
};

/// All outputs at sample `at`, over the seeds: [output].
std::vector<Held> held(const char* name, const Use& use, const std::function<double(const Used&)>& gain,
                       std::size_t at) {
  const Method& method = find_method(name);
  std::vector<Held> out(use.outputs.size());
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Trial trial = trial_of(method, seed);
    Estimate estimate = method.identify(trial.evidence, {});
    estimate.provenance.settings = trial.evidence.plan.settings.texts();
    const Compensation done = compensate(estimate, use.recording, nullptr);
    EXPECT_EQ(done.tables.size(), 1 + use.outputs.size());
    for (std::size_t k = 0; k < use.outputs.size(); ++k) {
      const Used& used = use.outputs[k];
      const double error = find_channel(done.recording, used.channel)->values[at] - used.truth[at];
      const double sd = find_channel(done.recording, used.channel + ".compensation_sd")->values[at];
      const double freedom = estimate.parameters[0].degrees_of_freedom;
      out[k].share += (std::abs(error) < student_quantile(0.975, freedom) * sd ? 1.0 : 0.0) / seeds;
      const double raw = find_channel(use.recording, used.channel)->values[at] / gain(used) - used.truth[at];
      out[k].raw += raw * raw / seeds;
      out[k].residual += error * error / seeds;
      out[k].stated += sd * sd / seeds;
      // The mean over a recording that goes round all directions has as many signs of each term as there are.
      EXPECT_LT(std::abs(mean_error(done.recording, used)), std::abs(mean_error(use.recording, used, gain(used))))
          << used.channel << ", seed " << seed;
    }
  }
  return out;
}

void expect_held(const std::vector<Held>& all, const Use& use) {
  for (std::size_t k = 0; k < all.size(); ++k) {
    EXPECT_GE(all[k].share, least_share) << use.outputs[k].channel;
    EXPECT_LT(all[k].residual, all[k].raw) << use.outputs[k].channel;
    // A mean of squares over n seeds has a relative standard deviation of sqrt(2/n); 4 of them.
    EXPECT_NEAR(all[k].residual / all[k].stated, 1.0, 4.0 * std::sqrt(2.0 / seeds)) << use.outputs[k].channel;
  }
}

TEST(SubtractedModel, OfAUnitMovedByHandHoldsAsOftenAsItSays) {
  const Settings truth = trial_of(find_method("imu_multi_position"), 1).evidence.plan.truth;
  const Use use = unit_in_use(truth, [](QuantityKind) { return 1.0; });
  expect_held(held(
                  "imu_multi_position", use, [](const Used&) { return 1.0; }, 7),
              use);
}

TEST(SubtractedModel, OfAWholeUnitThatCountsHoldsAsOftenAsItSays) {
  const Settings truth = trial_of(find_method("imu_channel_calibration"), 1).evidence.plan.truth;
  const double force = si(10000.0, "pulse/s/g") / sample_rate, rate = si(10.0, "pulse/arcsec") / sample_rate;
  const Use use = unit_in_use(truth, [&](QuantityKind k) { return k == QuantityKind::angular_rate ? rate : force; });
  const auto gain = [&](const Used& used) { return used.channel.starts_with("gyro") ? rate : force; };
  expect_held(held("imu_channel_calibration", use, gain, 7), use);
}

/// Counts of the north finder in use, and channels of what it does not measure.
Use north_finder_in_use(const std::vector<double>& truth) {
  using namespace rlg_north_finder;
  Use use;
  const auto felt = felt_in_use();
  for (const Which output : {gyro, accelerometer_x, accelerometer_y}) {
    const std::size_t first = output * per_output;
    Channel channel = channel_of(rlg_north_finder::role_of(output), QuantityKind::count, "pulse");
    Used used{channel.name, {}};
    for (const Felt& one : felt) {
      double sum = regressor_of(wanted()[first])(one);
      used.truth.push_back(sum);
      for (std::size_t j = 1; j < per_output; ++j) sum += truth[first + j] * regressor_of(wanted()[first + j])(one);
      channel.values.push_back(truth[first] * sum / sample_rate);
    }
    use.recording.channels.push_back(std::move(channel));
    use.outputs.push_back(std::move(used));
  }
  const auto add = [&](const char* name, QuantityKind kind, const char* unit, double (*value)(const Felt&)) {
    Channel channel = channel_of(name, kind, unit);
    for (const Felt& one : felt) channel.values.push_back(value(one));
    use.recording.channels.push_back(std::move(channel));
  };
  add("rate_y", QuantityKind::angular_rate, "deg/s", [](const Felt& f) { return f.rate.y; });
  add("rate_z", QuantityKind::angular_rate, "deg/s", [](const Felt& f) { return f.rate.z; });
  add("specific_force_z", QuantityKind::specific_force, "g", [](const Felt& f) { return f.specific_force.z; });
  return use;
}

TEST(SubtractedModel, OfANorthFinderHoldsAsOftenAsItSays) {
  const auto truth = rlg_north_finder::truth_of(trial_of(find_method("rlg_north_finder"), 1).evidence.plan);
  const Use use = north_finder_in_use(truth);
  const auto gain = [&](const Used& used) {  // the scale factor as the model has it, without its error
    return (used.channel == "gyro"              ? truth[0] / (1.0 + si(40.0, "ppm"))
            : used.channel == "accelerometer_x" ? truth[4] / (1.0 + si(300.0, "ppm"))
                                                : truth[8] / (1.0 - si(200.0, "ppm"))) /
           sample_rate;
  };
  expect_held(held("rlg_north_finder", use, gain, 7), use);
}

TEST(SubtractedModel, OfANorthFinderNamesTheAxesThatItLacks) {
  const Method& method = find_method("rlg_north_finder");
  const Trial trial = trial_of(method, 1);
  Use use = north_finder_in_use(rlg_north_finder::truth_of(trial.evidence.plan));
  use.recording.channels.resize(3);
  Estimate estimate = method.identify(trial.evidence, {});
  estimate.provenance.settings = trial.evidence.plan.settings.texts();
  const Compensation done = compensate(estimate, use.recording, nullptr);
  EXPECT_TRUE(says(done.findings, "rate_y: gyro.misalignment_y"));
  EXPECT_TRUE(says(done.findings, "rate_z: gyro.misalignment_z"));
  EXPECT_TRUE(says(done.findings, "specific_force_z: accelerometer_x.misalignment_z"));
  double squares = 0.0, stated = 0.0;
  const auto& values = done.recording.channels[0].values;
  for (std::size_t i = 0; i < values.size(); ++i) {
    squares += std::pow(values[i] - use.outputs[0].truth[i], 2);
    stated += std::pow(find_channel(done.recording, "gyro.compensation_sd")->values[i], 2);
  }
  // The test turned at 20 deg/s, the use at 12 and less: what is stated is larger, not by more than ten.
  EXPECT_GT(stated, squares);
  EXPECT_LT(stated, 100.0 * squares);
}

/// A later power-up of the trial's gyro, without noise.
Recording later_power_up(double bias, double repeatability, std::uint64_t seed) {
  Recording recording;
  recording.channels.push_back(channel_of("gyro", QuantityKind::angular_rate, "deg/h"));
  recording.channels[0].values.assign(20,
                                      bias + repeatability * RandomStream(seed).split("a later power-up").normal(0));
  return recording;
}

TEST(SubtractedModel, OfABiasHoldsAnotherPowerUpAsOftenAsItSays) {
  const Method& method = find_method("static_bias");
  double share = 0.0, raw = 0.0, residual = 0.0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Trial trial = trial_of(method, seed);
    Estimate estimate = method.identify(trial.evidence, {});
    const double bias = trial.truth[0].second;
    const Recording later = later_power_up(bias, trial.truth[3].second, seed);
    const Compensation done = compensate(estimate, later, nullptr);
    const double error = done.recording.channels[0].values[5];
    const double sd = find_channel(done.recording, "gyro.compensation_sd")->values[5];
    share += (std::abs(error) < student_quantile(0.975, estimate.parameters[0].degrees_of_freedom) * sd) / 60.0;
    raw += std::pow(later.channels[0].values[5], 2);
    residual += error * error;
  }
  EXPECT_GE(share, least_share);
  // 2^2 + 1.5^2 against 1.5^2 (1 + 1/8) in (deg/h)^2: a ratio of 0.405, of which the sd over 60 seeds is below a third
  EXPECT_LT(residual, raw);
}

TEST(SubtractedModel, OfABiasSaysWhatOnePowerUpDoesNotShow) {
  const Method& method = find_method("static_bias");
  Trial trial = trial_of(method, 1);
  trial.evidence.recordings.resize(1);
  const Estimate estimate = method.identify(trial.evidence, {});
  const Compensation done = compensate(estimate, trial.evidence.recordings[0], nullptr);
  EXPECT_NE(finding_of(done.findings, "turn_on_change_not_included"), nullptr);
  EXPECT_NE(finding_of(done.findings, "bias_of_one_attitude"), nullptr);
  Recording two = trial.evidence.recordings[0];
  two.channels.push_back(two.channels[0]);
  two.channels[1].name = "other";
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "no channel for the role"},
                      [&] { compensate(estimate, two, nullptr); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "compensated already"},
                      [&] { compensate(estimate, done.recording, nullptr); }));  // not twice
}

}  // namespace
}  // namespace tumble
