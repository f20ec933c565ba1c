// Segments that end when the estimate so far is good enough: the rule is in the result, and the result is as good as
// the rule says.
#include "tumble/recorder/live_estimates.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "tumble/formats/format.hpp"
#include "tumble/recorder/recorder_read.hpp"
#include "tumble/rehearsal/rehearse.hpp"
#include "tumble/rehearsal/testing/served_rig.hpp"
#include "tumble/rehearsal/virtual_stream.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {
namespace {

const double degrees_an_hour = Unit::parse("deg/h").to_si(1.0);

/// A gyro at rest for half an hour at most, with a rule.
std::string resting(const std::string& rule) {
  return "title = \"rest\"\nmethod = \"static_bias\"\n"
         "[instrument]\nmodel = \"triad\"\nserial = \"7\"\nrate = \"10 Hz\"\n"
         "[site]\nlatitude = \"34.25 deg\"\nlongitude = \"108.9 deg\"\nheight = \"400 m\"\n"
         "[channels]\nsignal = \"gyro_z\"\n[settings]\naxis = \"up\"\n[rig]\nkind = \"rate_table\"\n"
         "[[schedule]]\nlabel = \"rest\"\nduration = \"30 min\"\ntable = {hold = \"0 deg\"}\n" +
         rule +
         "[truth]\nsensors = \"gyros\"\ngyro_z_bias = \"5 deg/h\"\ngyro_angle_random_walk = \"0.1 deg/sqrt(h)\"\n";
}

const std::string rule_of_one = "until = \"sd(bias) <= 1 deg/h\"\nat_least = \"2 min\"\n";

Plan plan_of(const ScratchFolder& scratch, const std::string& text) {
  std::ofstream(scratch.file("plan.toml")) << text;
  return load_plan(scratch.file("plan.toml"), {});
}

struct Outcome {
  Rehearsed rehearsed;
  Estimate estimate;
  Recording recording;
  std::string notes;
};

Outcome rehearsed(const ScratchFolder& scratch, const Plan& plan, std::uint64_t seed = 1) {
  Rehearsal rehearsal;
  rehearsal.plan = plan;
  rehearsal.seed = seed;
  rehearsal.folder = scratch.file("run" + std::to_string(seed));
  rehearsal.recording = scratch.file("run" + std::to_string(seed) + ".h5");
  Outcome outcome;
  rehearsal.company.note = [&](const Note& note, double) {
    outcome.notes += std::string(name(note.kind)) + ": " + note.text.text() + "\n";
  };
  outcome.rehearsed = rehearse(rehearsal);
  outcome.recording = read_recording(rehearsal.recording, {}, {});
  outcome.estimate = identify(gather(plan, {rehearsal.recording}, {}), {});
  return outcome;
}

const Finding* finding_of(const Estimate& estimate, const std::string& code) {
  const auto found = std::ranges::find(estimate.findings, code, &Finding::code);
  return found == estimate.findings.end() ? nullptr : &*found;
}

double sd_of(const Estimate& estimate, const char* name) {
  const Parameter* const parameter = find_parameter(estimate, name);
  return parameter ? standard_uncertainty(estimate, static_cast<std::size_t>(parameter - estimate.parameters.data()))
                   : std::nan("");
}

TEST(LiveEstimates, ASegmentEndsByItsRuleAndTheResultSaysSo) {
  const ScratchFolder scratch;
  const Outcome outcome = rehearsed(scratch, plan_of(scratch, resting(rule_of_one)));
  ASSERT_EQ(outcome.rehearsed.end.ending, RunEnding::complete) << outcome.rehearsed.end.text.text();
  ASSERT_EQ(outcome.recording.marks.size(), 1u);
  const Mark& mark = outcome.recording.marks.front();
  EXPECT_GE(mark.end - mark.begin, 120.0);
  EXPECT_LT(mark.end - mark.begin, 1700.0) << "it ended before its time";
  const Finding* const said = finding_of(outcome.estimate, "ended_by_rule");
  ASSERT_NE(said, nullptr);
  EXPECT_NE(said->message.find("sd(bias) <= 1 deg/h"), std::string::npos) << said->message;
  EXPECT_EQ(finding_of(outcome.estimate, "segment_duration"), nullptr) << "an early end by a rule is no fault";
  // The answer was asked for within the last sample or two of what is sealed.
  EXPECT_LE(sd_of(outcome.estimate, "bias"), 1.02 * degrees_an_hour);
  const Parameter& bias = *find_parameter(outcome.estimate, "bias");
  EXPECT_LT(std::abs(bias.value - 5.0 * degrees_an_hour), 4.0 * sd_of(outcome.estimate, "bias"));
}

TEST(LiveEstimates, TheSameSeedEndsASegmentAtTheSameSample) {
  const ScratchFolder a, b;
  const Outcome one = rehearsed(a, plan_of(a, resting(rule_of_one))),
                two = rehearsed(b, plan_of(b, resting(rule_of_one)));
  ASSERT_EQ(one.recording.channels.front().values.size(), two.recording.channels.front().values.size());
  EXPECT_EQ(one.recording.marks.front().end, two.recording.marks.front().end);
}

TEST(LiveEstimates, ARuleThatIsNotReachedIsSaidToo) {
  const ScratchFolder scratch;
  const Outcome outcome =
      rehearsed(scratch, plan_of(scratch, resting("until = \"sd(bias) <= 0.001 deg/h\"\nat_least = \"10 min\"\n")));
  ASSERT_EQ(outcome.rehearsed.end.ending, RunEnding::complete);
  EXPECT_NEAR(outcome.recording.marks.front().end - outcome.recording.marks.front().begin, 1800.0, 1.0);
  EXPECT_NE(finding_of(outcome.estimate, "rule_not_met"), nullptr);
  EXPECT_EQ(finding_of(outcome.estimate, "ended_by_rule"), nullptr);
}

TEST(LiveEstimates, ARuleThatCannotBeJudgedSaysWhy) {
  const ScratchFolder scratch;
  const Outcome misspelt =
      rehearsed(scratch, plan_of(scratch, resting("until = \"sd(bais) <= 1 deg/h\"\nat_least = \"10 min\"\n")));
  EXPECT_NE(misspelt.notes.find("no parameter 'bais'; did you mean 'bias'?"), std::string::npos) << misspelt.notes;
  EXPECT_NEAR(misspelt.recording.marks.front().end - misspelt.recording.marks.front().begin, 1800.0, 1.0);
  const Outcome unfit =
      rehearsed(scratch, plan_of(scratch, resting("until = \"sd(bias) <= 1 ug\"\nat_least = \"10 min\"\n")), 2);
  EXPECT_NE(unfit.notes.find("is given in ug, and bias in deg/h"), std::string::npos) << unfit.notes;
}

TEST(LiveEstimates, ARunOverTcpEndsByItsRuleToo) {
  const ScratchFolder scratch;
  const Plan plan = plan_of(scratch, resting(rule_of_one));
  const Station station = testing::station_over_tcp(plan, scratch);
  constexpr double fast = 100.0;
  ServedRig rig(plan, station, fast);
  auto run = testing::run_over_tcp(plan, station, scratch.file("run"), fast);
  const RunEnd end = run_plan(run);
  ASSERT_EQ(end.ending, RunEnding::complete) << end.text.text();
  const auto rows = journal_of(run.folder);
  const auto row = std::ranges::find(rows, RunRow::Kind::segment_ends, &RunRow::kind);
  ASSERT_NE(row, rows.end());
  EXPECT_EQ(row->rule, "sd(bias) <= 1 deg/h");
  EXPECT_EQ(row->at_least, 120.0);
  ASSERT_TRUE(row->reached.has_value());
  EXPECT_GE(*row->reached, 120.0);
}

/// The segment goes on until every unit is good enough, except one that has dropped out.
TEST(LiveEstimates, ARuleIsForAllUnitsThatAreStillThere) {
  const ScratchFolder scratch;
  Rehearsal rehearsal;
  rehearsal.plan = plan_of(scratch, resting(rule_of_one));
  Station station = station_for(rehearsal.plan);
  station.file = scratch.file("station.toml");
  std::ofstream(scratch.file(std::string(made_frames_name))) << frames_for(rehearsal.plan);
  station.instruments.push_back(station.instruments.front());
  station.instruments[0].slot = "a";
  station.instruments[1].slot = "b";
  rehearsal.units = {{"a", "1"}, {"b", "2"}};
  rehearsal.station = station;
  rehearsal.folder = scratch.file("run");
  rehearsal.recording = scratch.file("run.h5");
  rehearsal.faults = {
      {.kind = FaultKind::drop_link, .name = "it", .about = "b", .at = 100.0, .lasts = 1e9, .ends = "complete"}};
  const Rehearsed rehearsed = rehearse(rehearsal);
  ASSERT_EQ(rehearsed.end.ending, RunEnding::complete) << rehearsed.end.text.text();
  const auto rows = journal_of(rehearsal.folder);
  const auto row = std::ranges::find(rows, RunRow::Kind::segment_ends, &RunRow::kind);
  ASSERT_NE(row, rows.end());
  EXPECT_TRUE(row->reached.has_value()) << "the dead unit does not keep the rule from being met";
}

/// What a run that is carried on knows is what it knew before.
TEST(LiveEstimates, ARunThatIsCarriedOnHasItsSamplesAgain) {
  const ScratchFolder scratch;
  const Plan plan = plan_of(scratch, resting("until = \"sd(bias) <= 0.001 deg/h\"\nat_least = \"10 min\"\n"));
  const Outcome outcome = rehearsed(scratch, plan);
  LiveEstimates estimates(estimator_of(plan), {.beside = false});
  EXPECT_FALSE(estimates.begin(1e4)) << "nothing is known";
  estimates.load(scratch.file("run1"));
  ASSERT_TRUE(estimates.begin(1e4));
  const auto answers = estimates.finished();
  ASSERT_EQ(answers.size(), 1u);
  ASSERT_TRUE(answers[0].estimate) << answers[0].problem.text();
  // The file has the samples in deg/s, so that their last digit is rounded.
  const double expected = find_parameter(outcome.estimate, "bias")->value, sd = sd_of(outcome.estimate, "bias");
  EXPECT_NEAR(find_parameter(*answers[0].estimate, "bias")->value, expected, 1e-9 * sd);
  EXPECT_NEAR(sd_of(*answers[0].estimate, "bias"), sd, 1e-9 * sd);
}

TEST(LiveEstimates, TooManySamplesEndIt) {
  LiveEstimates estimates([](Recording, const Progress&) { return Estimate{}; }, {.beside = false, .most_bytes = 1000});
  StoreStream stream;
  stream.channels.push_back({"x", Unit::parse("deg/h"), false});
  stream.rate = 1.0;
  stream.link = 0;
  estimates.stream(0, stream);
  const double value = 1.0;
  const auto add = [&](std::uint64_t from, std::uint64_t to) {
    for (std::uint64_t i = from; i < to; ++i)
      estimates.sample(0, {static_cast<double>(i), {}, i, std::span(&value, 1)});
  };
  add(0, 100);
  EXPECT_TRUE(estimates.begin(100.0));
  add(100, 20'000);
  EXPECT_FALSE(estimates.begin(20'000.0));
}

/// The rule looks at the standard uncertainty again and again and ends when it is small: were it too noisy, the
/// intervals of what it ends would be too narrow. White noise and flicker of the plan, a rule that ends most records
/// after a quarter to three quarters of their time.
TEST(LiveEstimatesCoverage, ARuleLeavesTheIntervalsAsTheyShouldBe) {
  const ScratchFolder scratch;
  const Plan plan = plan_of(scratch, resting(rule_of_one));
  const char* const wanted = std::getenv("TUMBLE_COVERAGE_SEEDS");
  const int seeds = wanted ? std::atoi(wanted) : 100;
  const StoppingRule rule = parse_stopping_rule("sd(bias) <= 1 deg/h", 120.0);
  int inside = 0, ended = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const Recording whole = simulate(plan, static_cast<std::uint64_t>(seed), {});
    Estimate estimate;
    for (double time = rule.at_least; time <= 1800.0; time += std::max(1.0, 0.05 * time)) {
      Recording part = whole;
      for (Channel& channel : part.channels) channel.values.resize(static_cast<std::size_t>(time * 10.0));
      estimate = identify(gather(plan, {}, {part}, {}), {});
      if (sd_of(estimate, "bias") <= rule.sd && ++ended) break;
    }
    const Parameter& bias = *find_parameter(estimate, "bias");
    const double half = std::isfinite(bias.lower) ? 0.0 : 1.96 * sd_of(estimate, "bias");
    const double low = half > 0.0 ? bias.value - half : bias.lower, high = half > 0.0 ? bias.value + half : bias.upper;
    inside += low <= 5.0 * degrees_an_hour && 5.0 * degrees_an_hour <= high;
  }
  EXPECT_GT(ended, seeds / 2) << "else this tests nothing";
  const double band = 4.0 * std::sqrt(0.95 * 0.05 / seeds);
  EXPECT_GE(static_cast<double>(inside) / seeds, 0.95 - band);
}

}  // namespace
}  // namespace tumble
