#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "tumble/core/testing/asserts.hpp"
#include "tumble/tasks/provenance.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// A plan of that text, read back from a file of its own.
class LoadPlan : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() / (std::string("load_plan_") + test->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& text) const {
    std::ofstream(folder_ / "plan.toml") << text;
    return (folder_ / "plan.toml").string();
  }
  Plan load(const std::string& text, const Sets& sets = {}) const { return load_plan(write(text), sets); }

  /// The problems without the folder: "plan.toml:3: ...".
  std::vector<std::string> problems(const std::string& text, const Sets& sets = {}) const {
    try {
      load(text, sets);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind, Error::Kind::bad_input);
      auto all = texts_of(error.problems);
      for (auto& problem : all)
        if (problem.starts_with(folder_.string())) problem.erase(0, folder_.string().size() + 1);
      return all;
    }
    return {};
  }

  std::filesystem::path folder_;
};

const std::string chamber = R"(
[instrument]
model = "fiber_optic_gyro"
rate = "1 Hz"
[rig]
kind = "thermal_chamber"
)";

TEST_F(LoadPlan, ANameMayStandForManyFiles) {
  for (const char* name : {"run-10.csv", "run-9.csv", "run-1.csv", "other.csv", "odd[1].csv"})
    std::ofstream(folder_ / name) << "time[s],gyro[deg/h]\n";
  const auto plan = load(chamber + "[[recording]]\nfile = \"run-*.csv\"\n[[recording]]\nfile = \"odd[1].csv\"\n");
  std::vector<std::string> files;
  for (const auto& entry : plan.recordings) files.push_back(std::filesystem::path(entry.file).filename());
  EXPECT_EQ(files, (std::vector<std::string>{"run-1.csv", "run-9.csv", "run-10.csv", "odd[1].csv"}));
  const Refused refusal = refusal_of([&] { load(chamber + "[[recording]]\nfile = \"soak-*.csv\"\n"); });
  EXPECT_EQ(refusal.problems.size(), 1u);
  EXPECT_TRUE(refuses(Error::Kind::bad_input,
                      Asked{.values = {(folder_ / "soak-*.csv").string()},
                            .file = (folder_ / "plan.toml").string(),
                            .table = "[[recording]]",
                            .key = "file",
                            .line = 8},
                      refusal));
}

TEST_F(LoadPlan, ReadsEverySection) {
  const auto plan = load(R"(title = "FOG over temperature"
[site]
latitude = "34.25 deg"
latitude_sd = "2 arcsec"
longitude = "-108.9 deg"
height = "400 m"
gravity = "9.7966 m/s^2"
[[recording]]
file = "data/one.csv"
run = 2
[[limit]]
parameter = "bias"
max = "0.02 deg/h"
[channels]
gyro = "dtg.x[deg/h]"
[truth]
A1_0 = "0.05 deg/h/K"
)" + chamber);
  EXPECT_EQ(plan.title, "FOG over temperature");
  EXPECT_DOUBLE_EQ(plan.site->latitude, 34.25 * std::numbers::pi / 180);
  EXPECT_EQ(plan.site->latitude_sd, si(2.0, "arcsec"));
  EXPECT_EQ(plan.site->height, 400.0);
  EXPECT_EQ(plan.site->gravity, 9.7966);
  EXPECT_EQ(plan.sample_rate, 1.0);
  ASSERT_EQ(plan.recordings.size(), 1u);
  EXPECT_EQ(plan.recordings[0].file, (folder_ / "data/one.csv").string());
  EXPECT_EQ(plan.recordings[0].run, 2);
  ASSERT_EQ(plan.limits.size(), 1u);
  EXPECT_EQ(plan.limits[0].max->value, 0.02);
  EXPECT_FALSE(plan.limits[0].min);
  EXPECT_EQ(plan.channels.at("gyro").at(0).channel, "dtg.x");
  EXPECT_EQ(plan.channels.at("gyro").at(0).unit->text(), "deg/h");
  EXPECT_DOUBLE_EQ(plan.truth.number("A1_0"), si(0.05, "deg/h/K"));
}

TEST_F(LoadPlan, AnInstrumentBesideHasTheTruthOfThePlanButForItsOwn) {
  const std::string text = chamber + R"([truth]
A1_0 = "0.05 deg/h/K"
A2_0 = "0.001 deg/h/K^2"
[beside.second.truth]
A1_0 = "0.07 deg/h/K"
[beside.plate]
model = "pendulous_accelerometer"
mount_roll = "10 deg"
mount_pitch = "-0.5 rad"
mount_yaw = "90 deg"
)";
  const auto plan = load(text, {{"truth.A2_0", "0.002 deg/h/K^2"}, {"beside.plate.truth.bias", "3 mg"}});
  ASSERT_EQ(plan.beside.size(), 2u);
  const auto& plate = plan.beside[plan.beside[0].name == "plate" ? 0 : 1];
  const auto& second = plan.beside[plan.beside[0].name == "plate" ? 1 : 0];
  EXPECT_EQ(second.model, "fiber_optic_gyro");
  EXPECT_DOUBLE_EQ(second.truth.number("A1_0"), si(0.07, "deg/h/K"));
  EXPECT_DOUBLE_EQ(second.truth.number("A2_0"), si(0.002, "deg/h/K^2"));
  EXPECT_EQ(plate.model, "pendulous_accelerometer");
  EXPECT_DOUBLE_EQ(plate.truth.number("bias"), si(3.0, "mg"));
  EXPECT_DOUBLE_EQ(plate.mount_roll, si(10.0, "deg"));
  EXPECT_DOUBLE_EQ(plate.mount_pitch, -0.5);
  EXPECT_DOUBLE_EQ(plate.mount_yaw, si(90.0, "deg"));
  EXPECT_EQ(second.mount_roll, 0.0);
  EXPECT_EQ(second.mount_yaw, 0.0);
}

TEST_F(LoadPlan, AsksARigNoWayBetweenPositionsRecordedOneByOne) {
  const std::string head = R"(
[rig]
kind = "dividing_head"
[[schedule]]
label = "down"
duration = "20 s"
head = {hold = "-90 deg"}
[[schedule]]
label = "up"
duration = "20 s"
head = {hold = "180 deg"}
)";
  const auto file = [](const std::string& label) {
    return "[[recording]]\nfile = \"" + label + ".csv\"\nsegment = \"" + label + "\"\n";
  };
  EXPECT_EQ(load(head + file("down") + file("up")).schedule.size(), 2u);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"up", "head", "27.5", "20"}}, [&] { load(head); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"up", "head", "27.5", "20"}},
                      [&] { load(head + file("down")); }));
}

TEST_F(LoadPlan, RepeatsASegmentForItsRunsAndSortsByRun) {
  const auto plan = load(chamber + R"(
[[schedule]]
label = "cold"
duration = "1 h"
run = [1, 2]
chamber = {dwell = "-20 degC"}
[[schedule]]
label = "warm"
duration = "30 min"
run = [2, 1]
chamber = {dwell = "20 degC"}
)");
  ASSERT_EQ(plan.schedule.size(), 4u);
  const std::pair<std::string, int> expected[]{{"cold", 1}, {"warm", 1}, {"cold", 2}, {"warm", 2}};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(std::pair(plan.schedule[i].label, plan.schedule[i].run), expected[i]);
  EXPECT_EQ(plan.schedule[0].duration, 3600.0);
  EXPECT_DOUBLE_EQ(plan.schedule[0].axes.at("chamber").value, 253.15);
}

TEST_F(LoadPlan, TimesARampFromWhereTheRunStands) {
  const auto plan = load(chamber + R"(
[[schedule]]
label = "start"
duration = "10 min"
run = [1, 2]
chamber = {dwell = "20 degC"}
[[schedule]]
label = "up"
run = 1
chamber = {ramp = "2 K/min", to = "60 degC"}
[[schedule]]
label = "down"
run = [1, 2]
chamber = {ramp = "0.5 K/min", to = "-20 degC"}
)");
  ASSERT_EQ(plan.schedule.size(), 5u);
  EXPECT_NEAR(plan.schedule[1].duration, 20 * 60, 1e-9);   // 40 K at 2 K/min
  EXPECT_NEAR(plan.schedule[2].duration, 160 * 60, 1e-9);  // 80 K at 0.5 K/min, from where "up" ended
  EXPECT_NEAR(plan.schedule[4].duration, 80 * 60, 1e-9);   // 40 K: run 2 starts at 20 degC, not where run 1 ended
}

TEST_F(LoadPlan, ARecordingMayBringItsOwnPlan) {
  const std::string schedule = "[[schedule]]\nlabel = \"soak\"\nduration = \"1 h\"\nchamber = {hold = \"20 degC\"}\n";
  std::ofstream(folder_ / "other.toml") << chamber << schedule;
  const auto plan = load(chamber +
                         "[[recording]]\nfile = \"a.csv\"\n[[recording]]\nfile = \"b.csv\"\n"
                         "segment = \"soak\"\nplan = \"other.toml\"\n");
  ASSERT_EQ(plan.recordings.size(), 2u);
  EXPECT_EQ(plan.recordings[0].plan, nullptr);
  ASSERT_NE(plan.recordings[1].plan, nullptr);
  EXPECT_EQ(plan.recordings[1].plan->schedule.at(0).label, "soak");
}

// Of two plans the schedule of each would be half recorded, and the errors of the rig drawn twice.
TEST_F(LoadPlan, RecordingsThatNameOnePlanShareIt) {
  std::ofstream(folder_ / "other.toml") << chamber;
  const auto plan = load(chamber +
                         "[[recording]]\nfile = \"a.csv\"\nplan = \"other.toml\"\n"
                         "[[recording]]\nfile = \"b.csv\"\nplan = \"./other.toml\"\n");
  ASSERT_NE(plan.recordings.at(0).plan, nullptr);
  EXPECT_EQ(plan.recordings[0].plan, plan.recordings.at(1).plan);
}

TEST_F(LoadPlan, RefusesAPlanOfARecordingThatDoesNotFit) {
  const std::string with = "[[recording]]\nfile = \"a.csv\"\nplan = \"other.toml\"\n";
  EXPECT_EQ(problems(chamber + with).size(), 1u);  // there is no such file
  std::ofstream(folder_ / "other.toml") << chamber << with;
  const auto deeper = refusal_of([&] { load(chamber + with); });
  ASSERT_EQ(deeper.problems.size(), 1u);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "further plans", .key = "plan"}, deeper));
  std::ofstream(folder_ / "other.toml") << "[instrument]\nmodel = \"sdof_gyro\"\n";
  const auto stranger = refusal_of([&] { load(chamber + with); });
  ASSERT_EQ(stranger.problems.size(), 1u);
  EXPECT_TRUE(
      refuses(Error::Kind::bad_input, Asked{.values = {"sdof_gyro", "fiber_optic_gyro"}, .key = "plan"}, stranger));
}

TEST_F(LoadPlan, FindsEveryProblemWithItsLine) {
  const auto found = problems(R"(titel = "x"
[instrument]
model = "fiber_optic_gyr"
rate = 1
[rig]
kind = "thermal_chamber"
[site]
latitude = "34 m"
[[schedule]]
label = "a"
duration = 300
chamber = {dwell = "20 degC"}
[[schedule]]
label = "b"
duration = "5 min"
chambr = {dwell = "20 degC"}
[[limit]]
parameter = "bias"
)");
  const char* lines[]{"plan.toml:1: ",  "plan.toml:3: ",  "plan.toml:4: ", "plan.toml:8: ",
                      "plan.toml:11: ", "plan.toml:16: ", "plan.toml:17: "};
  for (const auto* line : lines)
    EXPECT_TRUE(std::any_of(found.begin(), found.end(), [&](const auto& one) { return one.starts_with(line); }))
        << line;
  EXPECT_EQ(found.size(), std::size(lines)) << testing::PrintToString(found);
}

TEST_F(LoadPlan, NamesTheNearestKey) {
  const auto found = refusal_of([&] { load("[site]\nlatitude = \"1 deg\"\nheigth = \"1 m\"\n"); });
  ASSERT_EQ(found.problems.size(), 1u);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"heigth", "height"}, .line = 3}, found));
}

TEST_F(LoadPlan, RefusesABareNumberWithTheUnitItNeeds) {
  const auto found = refusal_of([&] { load("[site]\nlatitude = 34.25\n"); });
  ASSERT_EQ(found.problems.size(), 1u);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.part = "34.25", .key = "latitude", .line = 2}, found));
}

TEST_F(LoadPlan, SaysWhereTomlBreaks) {
  const auto found = problems("title = \"x\"\nmethod = \n");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].starts_with("plan.toml:2:")) << found[0];
}

TEST_F(LoadPlan, RefusesMotionsTheAxisCannotDo) {
  const auto start = chamber + "[[schedule]]\nlabel = \"a\"\n";
  EXPECT_EQ(problems(start + "duration = \"1 s\"\nchamber = {rate = \"1 K/s\"}\n").size(), 1u);
  EXPECT_EQ(problems(start + "duration = \"1 s\"\nchamber = {ramp = \"1 K/min\"}\n").size(), 1u);  // no `to`
  EXPECT_EQ(problems(start + "chamber = {ramp = \"1 K/min\", to = \"60 degC\"}\n").size(), 1u);    // from where?
  EXPECT_EQ(problems(start + "duration = \"0 s\"\nchamber = {dwell = \"20 degC\"}\n").size(), 1u);
  EXPECT_EQ(problems(start + "duration = \"1 s\"\nchamber = {}\n").size(), 1u);
  EXPECT_EQ(problems(start + "duration = \"1 s\"\nrun = 0\nchamber = {dwell = \"20 degC\"}\n").size(), 1u);
}

TEST_F(LoadPlan, TakesTheCommandLineInPlaceOfTheFile) {
  const auto text = chamber + "[truth]\nA1_0 = \"1 deg/h/K\"\n";
  EXPECT_DOUBLE_EQ(load(text, {{"truth.A1_0", "2 deg/h/K"}}).truth.number("A1_0"), si(2, "deg/h/K"));
  EXPECT_DOUBLE_EQ(load(text, {{"rig.ramp_limit", "1 K/min"}}).rig.number("ramp_limit"), si(1, "K/min"));
  EXPECT_EQ(problems(text, {{"truth.A1_9", "2 deg/h/K"}}).size(), 1u);
}

// One letter of a comment, a value of the command line, another plan of a recording: each is another provenance.
TEST_F(LoadPlan, NoTwoPlansHaveTheSameProvenance) {
  const auto text = [&](const std::string& comment) { return "# " + comment + "\nmethod = \"static_bias\"\n"; };
  const Provenance one = provenance_of(load(text("a"))), other = provenance_of(load(text("b")));
  ASSERT_EQ(one.plans.size(), 1u);
  EXPECT_EQ(one.plans[0].file, "plan.toml");
  EXPECT_EQ(one.plans[0].text, text("a"));
  EXPECT_NE(one.plans[0].sha256, other.plans[0].sha256);
  EXPECT_EQ(provenance_of(load(text("a"), {{"rate", "7 Hz"}})).command_line.at("rate"), "7 Hz");
  const Provenance large = provenance_of(load(text(std::string(100'000, 'x'))));
  EXPECT_FALSE(large.plans[0].text);
  EXPECT_EQ(large.plans[0].sha256.size(), 64u);
}

TEST_F(LoadPlan, NamesOfFilesAreRelativeToThePlan) {
  std::filesystem::create_directories(folder_ / "parts");
  std::ofstream(folder_ / "parts" / "arm.toml") << chamber;
  const Plan plan = load(chamber + "[[recording]]\nfile = \"parts/arm.csv\"\nplan = \"parts/arm.toml\"\n");
  EXPECT_EQ(relative_to(plan, plan.recordings[0].file), "parts/arm.csv");
  EXPECT_EQ(relative_to(plan, (folder_.parent_path() / "beside.csv").string()), "../beside.csv");
  const Provenance provenance = provenance_of(plan);
  ASSERT_EQ(provenance.plans.size(), 2u);
  EXPECT_EQ(provenance.plans[1].file, "parts/arm.toml");
  EXPECT_EQ(provenance.plans[1].text, chamber);
}

TEST_F(LoadPlan, SaysThatAPlanCannotBeRead) {
  try {
    load_plan((folder_ / "none.toml").string(), {});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind, Error::Kind::bad_file);
  }
}

TEST(PlanForMethod, CarriesWhatTheCommandLineSaysOfReading) {
  const auto plan = plan_for_method("allan_noise", {{"rate", "100"}, {"unit.a", "deg/h"}, {"missing", "NA"}});
  EXPECT_EQ(plan.reading.rate, 100.0);
  EXPECT_EQ(plan.reading.units.at("a").text(), "deg/h");
  EXPECT_EQ(plan.reading.missing, "NA");
  EXPECT_FALSE(plan_for_method("allan_noise", {}).reading.rate);
}

TEST(ReadOptions, TakesOnlyWhatSpeaksOfReading) {
  const auto options = read_options({{"rate", "100"}, {"unit.gyro.x", "deg/h"}, {"missing", "NA"}});
  EXPECT_EQ(options.rate, 100.0);
  EXPECT_EQ(options.units.at("gyro.x").text(), "deg/h");
  EXPECT_EQ(options.missing, "NA");
  EXPECT_EQ(read_options({{"rate", "2 kHz"}}).rate, 2000.0);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"rate", "-1"}}, [&] {
    read_options({{"rate", "-1"}});
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"rate", "1 deg"}}, [&] {
    read_options({{"rate", "1 deg"}});
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"rates"}}, [&] { read_options({{"rates", "1"}}); }));
}

Estimate estimate_of(double value_deg_h, double sd_deg_h) {
  Estimate estimate;
  estimate.parameters.push_back({"bias", "B", Unit::parse("deg/h"), si(value_deg_h, "deg/h"), ""});
  estimate.covariance = Matrix(1, 1);
  estimate.covariance(0, 0) = std::pow(si(sd_deg_h, "deg/h"), 2);
  return estimate;
}

Verdict verdict_on(const LimitEntry& limit, Estimate estimate) { return judge({limit}, estimate).at(0); }

TEST(Judge, DecidesByThe95PercentInterval) {
  using Outcome = Verdict::Outcome;
  const LimitEntry below{"bias", std::nullopt, parse_quantity("0.02 deg/h"), ""};
  // 1.96 sd = 0.0098 deg/h
  EXPECT_EQ(verdict_on(below, estimate_of(0.010, 0.005)).outcome, Outcome::pass);
  EXPECT_EQ(verdict_on(below, estimate_of(0.015, 0.005)).outcome, Outcome::undecided);
  EXPECT_EQ(verdict_on(below, estimate_of(0.025, 0.005)).outcome, Outcome::undecided);
  EXPECT_EQ(verdict_on(below, estimate_of(0.030, 0.005)).outcome, Outcome::fail);
  EXPECT_EQ(verdict_on(below, estimate_of(0.030, 0.005)).limit.highest(), si(0.02, "deg/h"));
  const LimitEntry both{"bias", parse_quantity("-0.02 deg/h"), parse_quantity("72 arcsec/h"), ""};
  EXPECT_EQ(verdict_on(both, estimate_of(0.0, 0.005)).outcome, Outcome::pass);
  EXPECT_EQ(verdict_on(both, estimate_of(-0.04, 0.005)).outcome, Outcome::fail);
}

TEST(Judge, RefusesLimitsInTheWrongUnit) {
  Estimate estimate = estimate_of(0, 1);
  const std::vector<LimitEntry> limits{{"bias", parse_quantity("1 deg"), std::nullopt, "plan.toml:6"},
                                       {"bias", parse_quantity("1"), std::nullopt, "plan.toml:9"}};
  const auto refused = refusal_of([&] { judge(limits, estimate); });
  ASSERT_EQ(refused.problems.size(), 2u);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.part = "1 deg/h"}, refused));
  EXPECT_NE(refused.problems[1].text().find("plan.toml:9"), std::string::npos);
}

// A parameter that the noise hides lies between zero and its upper limit: a good instrument is not left undecided.
TEST(Judge, AnUpperLimitDecidesToo) {
  Estimate estimate = estimate_of(0, 1);
  estimate.findings.push_back({Finding::Severity::info,
                               "noise_term_not_significant",
                               {{"term", "rate_random_walk"},
                                {"limit", si(2.0, "deg/h/sqrt(h)"), "deg/h/sqrt(h)"},
                                {"length", 3600.0, "s"},
                                {"remedy", "a longer record"}},
                               "gyro.x, gyro.y"});
  estimate.findings.back().hidden = {{"gyro.x.rate_random_walk", "gyro.x"}, {"gyro.y.rate_random_walk", "gyro.y"}};
  const auto outcome = [&](const char* name, const char* min, const char* max) {
    const auto written = [](const char* text) { return *text ? std::optional(parse_quantity(text)) : std::nullopt; };
    return judge({{name, written(min), written(max), ""}}, estimate)[0].outcome;
  };
  using Outcome = Verdict::Outcome;
  EXPECT_EQ(outcome("gyro.y.rate_random_walk", "", "2.5 deg/h/sqrt(h)"), Outcome::pass);
  EXPECT_EQ(outcome("gyro.x.rate_random_walk", "", "1.5 deg/h/sqrt(h)"), Outcome::undecided);
  EXPECT_EQ(outcome("gyro.x.rate_random_walk", "3 deg/h/sqrt(h)", ""), Outcome::fail);
  EXPECT_EQ(outcome("gyro.x.rate_random_walk", "1 deg/h/sqrt(h)", ""), Outcome::undecided);
  EXPECT_EQ(estimate.findings.size(), 1u);  // nothing more to say of these
  EXPECT_EQ(outcome("gyro.z.rate_random_walk", "", "9 deg/h/sqrt(h)"), Outcome::undecided);  // another channel
  EXPECT_EQ(estimate.findings.size(), 2u);
}

TEST(Judge, LeavesOpenWhatTheResultDoesNotGive) {
  Estimate estimate = estimate_of(0, 1);
  const auto verdicts = judge({{"bais", std::nullopt, parse_quantity("0.02 deg/h"), "plan.toml:3"}}, estimate);
  const Findings& findings = estimate.findings;
  ASSERT_EQ(verdicts.size(), 1u);
  EXPECT_EQ(verdicts[0].outcome, Verdict::Outcome::undecided);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].severity, Finding::Severity::error);
  EXPECT_TRUE(is_finding(
      findings[0], "limit_near_parameter",
      {{"limit", "<= 0.02 deg/h"}, {"parameter", "bais"}, {"nearest", "bias"}, {"parameters", "bias"}}, "plan.toml:3"));
}

}  // namespace
}  // namespace tumble
