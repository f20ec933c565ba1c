#include "tumble/reduce/stretches.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "tumble/core/testing/asserts.hpp"
#include "tumble/rigs/rig.hpp"

namespace tumble {
namespace {

Plan plan_of(std::vector<Segment> schedule) {
  Plan plan;
  plan.rig_kind = "rate_table";
  plan.rig = defaults(find_rig("rate_table").options());
  plan.site = Site{.latitude = 0.6};
  plan.sample_rate = 10.0;
  plan.schedule = std::move(schedule);
  return plan;
}

/// 10 Hz from `start` [s] on, sample i having the value i + 1.
Channel counting(std::size_t samples, double start = 0.0) {
  Channel channel{"gyro", QuantityKind::angular_rate, Unit::parse("rad/s"), {start, 10.0, nullptr}, {}};
  for (std::size_t i = 0; i < samples; ++i) channel.values.push_back(static_cast<double>(i + 1));
  return channel;
}

Recording recording_of(std::vector<Mark> marks, std::size_t samples = 60) {
  Recording recording;
  recording.channels = {counting(samples)};
  recording.marks = std::move(marks);
  return recording;
}

const std::vector<Segment> rest_and_turn{{"rest", 2.0}, {"turn", 2.0}, {"rest", 2.0}};
const std::vector<Mark> marks_of_it{{"rest", 0.0}, {"turn", 2.0}, {"rest", 4.0}};

TEST(MarkedSegments, ALabelThatOccursTwiceIsTakenInOrder) {
  const Evidence evidence{plan_of(rest_and_turn), {recording_of(marks_of_it)}};
  const auto marked = marked_segments(evidence).at(0);
  ASSERT_EQ(marked.size(), 3u);
  for (std::size_t m = 0; m < 3; ++m) {
    EXPECT_EQ(marked[m].index, m);
    EXPECT_EQ(marked[m].planned, &evidence.plan.schedule[m]);
    EXPECT_EQ(marked[m].start, 0u);
  }
  EXPECT_DOUBLE_EQ(marked[0].end, 2.0);
  EXPECT_EQ(marked[2].end, std::numeric_limits<double>::infinity());
}

TEST(MarkedSegments, AClosingRepeatIsNotTakenForTheFirstSegment) {
  const std::vector<Segment> closed{{"up", 2.0}, {"down", 2.0}, {"left", 2.0}, {"up", 2.0}};
  // the first segments were not recorded: in one file, and in two
  const Recording late = recording_of({{"left", 0.0}, {"up", 2.0}}), side = recording_of({{"left", 0.0}}),
                  up = recording_of({{"up", 0.0}});
  EXPECT_EQ(marked_segments({plan_of(closed), {late}}).at(0).at(1).index, 3u);
  EXPECT_EQ(marked_segments({plan_of(closed), {side, up}}).at(1).at(0).index, 3u);
  // the last segment was not recorded: what follows shows that this is the first one
  const Recording early = recording_of({{"up", 0.0}, {"down", 2.0}});
  const auto repeated = marked_segments({plan_of(closed), {early, early}});
  for (const auto& marked : repeated) EXPECT_EQ(marked.at(0).index, 0u);
  EXPECT_EQ(repeated[1][0].start, 1u);
}

TEST(Stretches, SayWhichSegmentsWereNotRecorded) {
  const std::vector<Segment> schedule{{"up", 2.0}, {"down", 2.0}, {"left", 2.0}, {"up", 2.0}, {"other", 2.0, 2}};
  const Evidence evidence{plan_of(schedule), {recording_of({{"left", 0.0}, {"up", 2.0}})}};
  const auto test = stretches(evidence, {.role = "gyro"});
  ASSERT_EQ(test.stretches.size(), 2u);
  EXPECT_DOUBLE_EQ(test.stretches[1].power_on, -4.0);  // began at 2 s and is the segment from 6 s on
  ASSERT_EQ(test.findings.size(), 1u);                 // a run of which nothing was recorded is not meant to be there
  EXPECT_EQ(test.findings[0].where, "run 1");
  EXPECT_EQ(test.findings[0].occurrences.count, 2u);
  EXPECT_TRUE(is_finding(test.findings[0], "not_recorded", {{"segments", "'up', 'down'"}}));
}

TEST(MarkedSegments, OnePowerUpMayLieInSeveralFiles) {
  const Evidence evidence{
      plan_of(rest_and_turn),
      {recording_of({{"rest", 0.0}}), recording_of({{"turn", 0.0}}), recording_of({{"rest", 0.0}})}};
  const auto marked = marked_segments(evidence);
  EXPECT_EQ(marked[2][0].index, 2u);
  for (const auto& of_file : marked) EXPECT_EQ(of_file[0].start, 0u);
}

TEST(MarkedSegments, ARunThatIsRecordedAgainIsAnotherStart) {
  const Evidence evidence{plan_of(rest_and_turn),
                          {recording_of({{"rest", 0.0}}), recording_of(marks_of_it), recording_of(marks_of_it)}};
  // the first file ends before its time: what the others hold is whole
  const auto marked = marked_segments(evidence);
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t m = 0; m < marked[r].size(); ++m) {
      EXPECT_EQ(marked[r][m].index, m);
      EXPECT_EQ(marked[r][m].start, r);
    }
}

TEST(MarkedSegments, ARunThatTheScheduleLacksRepeatsOneThatItStates) {
  auto marks = marks_of_it;
  for (auto& mark : marks) mark.run = 2;
  const Evidence evidence{plan_of(rest_and_turn), {recording_of(marks_of_it), recording_of(marks)}};
  const auto marked = marked_segments(evidence);
  for (std::size_t m = 0; m < 3; ++m) {
    EXPECT_EQ(marked[1][m].index, m);
    EXPECT_EQ(marked[1][m].start, 1u);
  }
}

TEST(MarkedSegments, AMarkBeyondTheScheduleStandsForNothing) {
  const Evidence evidence{plan_of(rest_and_turn), {recording_of({{"rst", 0.0}, {"turn", 2.0}, {"turn", 4.0}})}};
  const auto marked = marked_segments(evidence).at(0);
  EXPECT_EQ(marked[0].planned, nullptr);
  EXPECT_NE(marked[1].planned, nullptr);
  EXPECT_EQ(marked[2].planned, nullptr);
}

TEST(Stretches, HoldViewsOfTheSamplesAfterSettling) {
  Evidence evidence{plan_of(rest_and_turn), {recording_of(marks_of_it)}};
  const auto test = stretches(evidence, {.role = "gyro", .scale = 2.0, .settling = 0.5});
  ASSERT_EQ(test.stretches.size(), 3u);
  const Stretch& turn = test.stretches[1];
  EXPECT_NEAR(turn.first, 2.5, 1e-12);
  EXPECT_EQ(turn.samples, 15u);
  EXPECT_NEAR(turn.duration(), 1.5, 1e-12);
  EXPECT_DOUBLE_EQ(turn.values[0], 2.0 * 26.0);
  EXPECT_TRUE(turn.steady);
  evidence.recordings[0].channels[0].values[25] = 7.0;
  EXPECT_DOUBLE_EQ(turn.values[0], 14.0);
  double sum = 0.0;
  for (const double v : turn.values) sum += v;
  EXPECT_DOUBLE_EQ(sum, 14.0 + 2.0 * (27 + 40) * 14 / 2);
}

TEST(Stretches, LostSamplesAreMissingOnesOfTheGrid) {
  Evidence evidence{plan_of({{"rest", 6.0}}), {recording_of({{"rest", 0.0}})}};
  Channel& channel = evidence.recordings[0].channels[0];
  std::vector<double> stamps, values;
  for (std::size_t i = 0; i < 60; ++i)
    if (i != 30 && i != 31) {
      stamps.push_back(0.1 * static_cast<double>(i));
      values.push_back(static_cast<double>(i));
    }
  channel.timeline = {0.0, 0.0, std::make_shared<const std::vector<double>>(stamps)};
  channel.values = values;
  const auto test = stretches(evidence, {.role = "gyro"});
  const auto& seen = test.stretches.at(0).values;
  ASSERT_EQ(seen.size(), 60u);
  EXPECT_TRUE(std::isnan(seen[30]) && std::isnan(seen[31]));
  EXPECT_DOUBLE_EQ(seen[32], 32.0);
}

TEST(Stretches, SayWhatIsNotUsed) {
  const Evidence evidence{plan_of({{"rest", 2.0}, {"short", 0.4}, {"lost", 2.0}}),
                          {recording_of({{"rest", 0.0}, {"short", 2.0}, {"lost", 9.0}, {"typo", 11.0}})}};
  const auto test = stretches(evidence, {.role = "gyro", .settling = 0.5});
  ASSERT_EQ(test.stretches.size(), 1u);
  ASSERT_EQ(test.findings.size(), 3u);
  const auto is_unused = [&](std::size_t i, const char* segment, const char* why) {
    return is_finding(test.findings[i], "segment_not_used", {{"segment", segment}, {"reason", Phrase{why}}});
  };
  EXPECT_TRUE(is_unused(0, "short", "no_sample_after_settling"));
  EXPECT_TRUE(is_unused(1, "lost", "no_sample_recorded"));
  EXPECT_TRUE(is_unused(2, "typo", "not_in_schedule"));
}

TEST(Stretches, AFileOfOneSegmentIsAPowerUpOfItsOwn) {
  Evidence evidence{plan_of({{"first", 2.0}, {"second", 3.0}}), {recording_of({{"second", 1.0}})}};
  evidence.plan.recordings = {{.file = "second.csv", .segment = "second"}};
  const auto test = stretches(evidence, {.role = "gyro"});
  const Stretch& second = test.stretches.at(0);
  EXPECT_DOUBLE_EQ(second.power_on, 1.0);
  EXPECT_DOUBLE_EQ(second.first, 0.0);
  EXPECT_DOUBLE_EQ(test.power_ups[second.power_up].offset, 2.0);
}

TEST(Stretches, APlanGivesTheSamplesThatItsRecordingWouldHold) {
  const Plan plan = plan_of(rest_and_turn);
  const auto planned = stretches(plan, {.role = "gyro", .settling = 0.5});
  const auto recorded = stretches(Evidence{plan, {recording_of(marks_of_it)}}, {.role = "gyro", .settling = 0.5});
  ASSERT_EQ(planned.stretches.size(), recorded.stretches.size());
  for (std::size_t g = 0; g < planned.stretches.size(); ++g) {
    EXPECT_EQ(planned.stretches[g].samples, recorded.stretches[g].samples);
    EXPECT_NEAR(planned.stretches[g].first, recorded.stretches[g].first, 1e-12);
    EXPECT_TRUE(planned.stretches[g].values.empty());
  }
}

TEST(Stretches, OfPowerUpsThatRepeatOneAreAlike) {
  const auto turning = [](int run, double rate) {
    return Segment{"turn", 20.0, run, {{"table", {.kind = Motion::Kind::rate, .value = rate}}}};
  };
  const auto alike_in = [](std::vector<Segment> schedule) {
    return first_alike(stretches(plan_of(std::move(schedule)), {}));
  };
  using Alike = std::vector<std::size_t>;
  EXPECT_EQ(alike_in({{"rest", 20.0, 1}, turning(1, 0.5), {"rest", 20.0, 2}, turning(2, 0.5)}), (Alike{0, 1, 0, 1}));
  // Another rate later in the power-up: the rig may begin to move otherwise, so that nothing of it is the same.
  EXPECT_EQ(alike_in({{"rest", 20.0, 1}, turning(1, 0.5), {"rest", 20.0, 2}, turning(2, -0.5)}), (Alike{0, 1, 2, 3}));
  // Samples that were recorded are looked at one by one.
  const std::vector<Segment> schedule{{"rest", 20.0, 1}, {"rest", 20.0, 2}};
  const Evidence evidence{plan_of(schedule),
                          {recording_of({{"rest", 0.0}}, 200), recording_of({{"rest", 0.0, 2}}, 200)}};
  EXPECT_EQ(first_alike(stretches(evidence, {.role = "gyro"})), (Alike{0, 1}));
}

TEST(Stretches, RefuseATestWithoutRigOrSamples) {
  Evidence evidence{plan_of(rest_and_turn), {recording_of({{"typo", 0.0}})}};
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"typo"}, .pattern = "is not used"},
                      [&] { stretches(evidence, {.role = "gyro"}); }));
  evidence.recordings = {recording_of(marks_of_it)};
  evidence.plan.rig_kind.clear();
  EXPECT_TRUE(
      refuses(Error::Kind::bad_input, Asked{.pattern = "[rig] kind"}, [&] { stretches(evidence, {.role = "gyro"}); }));
}

/// Stamps and the times of marks are rounded apart: by 2.4e-7 s at Unix time.
TEST(Stretches, SamplesBetweenTwoMarksAreTheSameByAnyClock) {
  for (const double origin : {0.0, 1e6 + 1.0 / 3.0, 1.7e9 + 0.1234567}) {
    const Channel channel = counting(300, origin);
    for (std::size_t k = 1; k < 250; ++k) {
      const double later = 0.3 + 0.1 * (static_cast<double>(k) - 3.0);
      const SampleRange range = samples_between(channel, origin + later, (origin + 0.7) + (later - 0.2));
      ASSERT_EQ(range.begin, k) << origin;
      ASSERT_EQ(range.end, k + 5) << origin;
    }
  }
}

TEST(SamplesBetween, CountStampsFromTheBeginningToBeforeTheEnd) {
  const Channel channel = counting(10, 5.0);
  const double forever = std::numeric_limits<double>::infinity();
  EXPECT_EQ(samples_between(channel, -forever, forever).size(), 10u);
  EXPECT_EQ(samples_between(channel, 5.15, 5.45).begin, 2u);
  EXPECT_EQ(samples_between(channel, 5.15, 5.45).end, 5u);
  EXPECT_EQ(samples_between(channel, 7.0, 8.0).size(), 0u);
}

}  // namespace
}  // namespace tumble
