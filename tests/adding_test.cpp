// The entries of docs/adding/ at work: this program is compiled with the files of examples/adding, and finds them in
// its catalogues as it finds all others.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <numbers>
#include <string>

#include "tumble/checks/check.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/reduce/compensate.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/rigs/testing/bench.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

std::size_t index_of(const Estimate& estimate, const std::string& name) {
  const auto* parameter = find_parameter(estimate, name);
  EXPECT_NE(parameter, nullptr) << name;
  return parameter ? static_cast<std::size_t>(parameter - estimate.parameters.data()) : 0;
}

TEST(Adding, RigTurnsGravityFromZTowardsX) {
  const Rig& rig = find_rig("my_rig");
  for (const double angle : {0.0, 45.0, 90.0, 200.0}) {
    const Schedule schedule{{"s", 100.0, 1, {{"tilt", {.value = angle * degree}}}}};
    const Felt at =
        felt(rig.reference(run_of(schedule, with(rig, {{"ideal", "true", "test", false}}))), 90.0, 1.0, 1).front();
    // Products of two rounded numbers of size g, each to 1e-16.
    EXPECT_NEAR(at.specific_force.x, -*site.gravity * std::sin(angle * degree), 1e-14 * *site.gravity);
    EXPECT_NEAR(at.specific_force.y, 0.0, 1e-14 * *site.gravity);
    EXPECT_NEAR(at.specific_force.z, *site.gravity * std::cos(angle * degree), 1e-14 * *site.gravity);
  }
}

TEST(Adding, RigRefusesWhatItCannotDo) {
  const Rig& rig = find_rig("my_rig");
  const Schedule schedule{{"spin", 10.0, 1, {{"tilt", {.kind = Motion::Kind::rate, .value = 1.0}}}}};
  EXPECT_EQ(rig.refusals(schedule, defaults(rig.options())).size(), 1u);
}

TEST(Adding, RigErrorsStandInTheBudgetOfTheMethod) {
  const Estimate estimate =
      find_method("my_gyro_drift").identify(trial_of(find_method("my_gyro_drift"), 1).evidence, {});
  EXPECT_TRUE(std::any_of(estimate.budget.begin(), estimate.budget.end(), [](const Contribution& line) {
    return line.source.find("level of the base") != std::string::npos;
  }));
}

TEST(Adding, MethodHoldsItsTruthWithinFourSigma) {
  const Method& method = find_method("my_gyro_drift");
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Trial trial = trial_of(method, seed);
    const Estimate estimate = method.identify(trial.evidence, {});
    for (const auto& [name, truth] : trial.truth) {
      const std::size_t i = index_of(estimate, name);
      const double sd = standard_uncertainty(estimate, i);
      EXPECT_GT(sd, 0.0) << name;
      EXPECT_NEAR(estimate.parameters[i].value, truth, 4.0 * sd) << name << ", seed " << seed;
    }
  }
}

TEST(Adding, MethodFindsTheTruthToRoundingWithoutNoise) {
  const Method& method = find_method("my_gyro_drift");
  Trial trial = trial_of(method, 1);
  trial.evidence.plan.rig.set_flag("ideal", true);
  trial.evidence.plan.truth.set_number("angle_random_walk", 0.0, Unit());
  trial.evidence.recordings = {simulate(trial.evidence.plan, 1, {})};
  const Estimate estimate = method.identify(trial.evidence, {});
  // The output is below 1e-4 rad/s (Earth rate), its rounding below 1e-20; the regressor of D_F is 1.
  EXPECT_NEAR(estimate.parameters[index_of(estimate, "D_F")].value, trial.truth[0].second, 1e-18);
}

TEST(Adding, MethodPredictsWhatItThenStates) {
  const Method& method = find_method("my_gyro_drift");
  const Trial trial = trial_of(method, 1);
  const Estimate before = method.predict(trial.evidence.plan), after = method.identify(trial.evidence, {});
  for (const auto& [name, truth] : trial.truth) {
    const double predicted = standard_uncertainty(before, index_of(before, name));
    // The noise is estimated from some 200 averages and 8 positions: its standard deviation may be off by
    // 4/sqrt(2 (8 - 3)) where the scatter of the positions gives it.
    EXPECT_LT(standard_uncertainty(after, index_of(after, name)), 2.3 * predicted) << name;
    EXPECT_GT(standard_uncertainty(after, index_of(after, name)), predicted / 2.3) << name;
  }
}

TEST(Adding, MethodSubtractsTheDriftFromAnotherRecording) {
  const Method& method = find_method("my_gyro_drift");
  const Trial trial = trial_of(method, 1), other = trial_of(method, 2);
  Estimate estimate = method.identify(trial.evidence, {});
  estimate.provenance.settings = trial.evidence.plan.settings.texts();
  const Compensation compensated = compensate(estimate, other.evidence.recordings[0], &trial.evidence.plan);
  const Channel* after = find_channel(compensated.recording, "gyro");
  const Channel* before = find_channel(other.evidence.recordings[0], "gyro");
  ASSERT_NE(after, nullptr);
  // In the first position x is east, where the Earth does not turn, and f = (0, 0, g): what is subtracted is
  // D_F + D_S g, to 4 standard deviations.
  const double drift = trial.truth[0].second + trial.truth[2].second * 9.797;
  const Channel* sd = find_channel(compensated.recording, "gyro.compensation_sd");
  ASSERT_NE(sd, nullptr);
  EXPECT_NEAR(before->values[100] - after->values[100], drift, 4.0 * sd->values[100]);
  EXPECT_GT(std::abs(drift), 4.0 * sd->values[100]);
}

TEST(Adding, WarmUpFindsTheTruthWithoutNoise) {
  const Method& method = find_method("my_warm_up");
  Trial trial = trial_of(method, 1);
  Plan& plan = trial.evidence.plan;
  plan.rig.set_flag("ideal", true);
  plan.truth.set_number("angle_random_walk", 0.0, Unit());
  plan.settings.set_number("averaging", 1.0, Unit::parse("s"));
  trial.evidence.recordings = {simulate(plan, 1, {})};
  const Estimate estimate = method.identify(trial.evidence, {});
  // The last step is below 1e-12 of each value; samples of 1e-5 rad/s are rounded to 1e-16 of themselves.
  for (const auto& [name, truth] : trial.truth)
    EXPECT_NEAR(estimate.parameters[index_of(estimate, name)].value, truth, 1e-10 * std::abs(truth)) << name;
}

TEST(Adding, WarmUpRefusesARecordingWithoutATransient) {
  Evidence evidence = trial_of(find_method("my_warm_up"), 1).evidence;
  evidence.plan.truth.set_number("startup_transient", 0.0, Unit::parse("deg/h"));
  evidence.recordings = {simulate(evidence.plan, 1, {})};
  try {
    find_method("my_warm_up").identify(evidence, {});
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind, Error::Kind::bad_data);
  }
}

TEST(Adding, WarmUpIsSubtractedFromAnotherRecording) {
  const Method& method = find_method("my_warm_up");
  const Trial trial = trial_of(method, 1), other = trial_of(method, 2);
  Estimate estimate = method.identify(trial.evidence, {});
  estimate.provenance.settings = trial.evidence.plan.settings.texts();
  const Recording& recording = other.evidence.recordings[0];
  const Compensation compensated = compensate(estimate, recording, &trial.evidence.plan);
  const Channel *after = find_channel(compensated.recording, "gyro"), *before = find_channel(recording, "gyro"),
                *sd = find_channel(compensated.recording, "gyro.compensation_sd");
  ASSERT_NE(after, nullptr);
  ASSERT_NE(sd, nullptr);
  for (const std::size_t sample : {0u, 250u, 2000u}) {
    const double time = static_cast<double>(sample) + 0.5;
    const double drift = trial.truth[0].second + trial.truth[1].second * std::exp(-time / trial.truth[2].second);
    EXPECT_NEAR(before->values[sample] - after->values[sample], drift, 4.0 * sd->values[sample]) << sample;
    EXPECT_LT(sd->values[sample],
              si(0.1, "deg/h"));  // some hundredths: the noise of 0.12 deg/h in 1 s, over 10 minutes
  }
}

Recording with_temperature(std::vector<double> kelvins) {
  Channel channel{"case", QuantityKind::temperature, Unit::parse("degC"), {0.0, 2.0, nullptr}, std::move(kelvins)};
  Recording recording;
  recording.channels.push_back(std::move(channel));
  return recording;
}

Findings findings_of_my_check(const Recording& recording) {
  for (const Check* check : check_catalogue())
    if (std::string(check->name) == "my_check") return check->run(recording, nullptr);
  ADD_FAILURE() << "my_check is not in the catalogue";
  return {};
}

TEST(Adding, CheckReportsAJump) {
  const Findings findings = findings_of_my_check(with_temperature({293.0, 293.1, 320.0, 293.2, 293.3}));
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].where, "case");
  EXPECT_EQ(findings[0].code, "temperature_jump");
  EXPECT_EQ(findings[0].message,
            "2 jumps of more than 5 K between two samples, first at 1 s; check the contacts of the sensor");
}

TEST(Adding, CheckAcceptsWhatAChamberDoes) {
  EXPECT_TRUE(findings_of_my_check(with_temperature({293.0, 293.1, std::nan(""), 297.9, 293.0})).empty());
  Recording rates = with_temperature({0.0, 100.0});
  rates.channels[0].kind = QuantityKind::angular_rate;
  EXPECT_TRUE(findings_of_my_check(rates).empty());
}

std::string logged(std::string bytes, const std::vector<double>& numbers) {
  for (const double number : numbers) {
    char eight[sizeof number];
    std::memcpy(eight, &number, sizeof number);
    bytes.append(eight, sizeof eight);
  }
  return bytes;
}

class AddingFormat : public testing::Test {
 protected:
  std::string file(const std::string& bytes) {
    const auto path = folder_.file("a.mylog");
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  std::string beside(const std::string& name) const { return folder_.file(name); }

 private:
  ScratchFolder folder_;
};

TEST_F(AddingFormat, IsRecognisedAndRead) {
  const Recording recording = read_recording(file(logged("MYLOGGER", {200.0, 15.0, -30.0})), {}, {});
  ASSERT_EQ(recording.channels.size(), 1u);
  const Channel& gyro = recording.channels[0];
  EXPECT_EQ(gyro.unit, Unit::parse("deg/h"));
  EXPECT_EQ(gyro.timeline.rate, 200.0);
  ASSERT_EQ(gyro.values.size(), 2u);
  // 15 deg/h; the factor is one rounded product.
  EXPECT_NEAR(gyro.values[0], std::numbers::pi / 43200.0, 1e-19);
  EXPECT_EQ(gyro.values[1], -2.0 * gyro.values[0]);
  EXPECT_EQ(sha256_of(recording.origin).size(), 64u);
}

TEST_F(AddingFormat, IsConvertedToAFormatThatIsWritten) {
  const std::string from = file(logged("MYLOGGER", {200.0, 15.0, -30.0, 0.25})), to = beside("a.csv");
  convert(from, to, {}, {});
  const Recording before = read_recording(from, {}, {}), after = read_recording(to, {}, {});
  ASSERT_EQ(after.channels.size(), 1u);
  EXPECT_EQ(after.channels[0].values, before.channels[0].values);
  EXPECT_EQ(after.channels[0].timeline.rate, 200.0);
}

TEST_F(AddingFormat, IsNotWritten) {
  const std::string from = file(logged("MYLOGGER", {200.0, 15.0}));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {beside("b.mylog")}, .pattern = "cannot be written"},
                      [&] { convert(from, beside("b.mylog"), {}, {}); }));
}

TEST_F(AddingFormat, RefusesAFileThatWasCutOff) {
  for (const auto& bytes : {logged("MYLOGGER", {}), logged("MYLOGGER", {200.0, 15.0}) + "x",
                            logged("MYLOGGER", {0.0, 1.0}), logged("MYLOGGER", {std::nan(""), 1.0})}) {
    try {
      read_recording(file(bytes), {}, {});
      ADD_FAILURE() << "no error for " << bytes.size() << " bytes";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind, Error::Kind::bad_file);
    }
  }
}

}  // namespace
}  // namespace tumble
