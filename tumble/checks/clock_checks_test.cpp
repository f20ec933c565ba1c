// Checks of stamps, rates and segments.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

#include "tumble/checks/testing/made_recordings.hpp"

namespace tumble {
namespace {

using namespace testing;

TEST(Checks, Gaps) {
  auto stamps = series(5000, [](std::size_t i) { return 0.01 * static_cast<double>(i + (i >= 1000 ? 30 : 0)); });
  const Finding one = finding_of("gaps", stamped(stamps));
  EXPECT_TRUE(is_finding(one, "gap", {{"lost", 30}, {"longest", 0.31, "s"}}, ""));
  EXPECT_EQ(one.occurrences.count, 1u);
  EXPECT_DOUBLE_EQ(one.occurrences.first.time, 9.99);
  for (std::size_t i = 2000; i < stamps.size(); ++i) stamps[i] += 0.02;
  const Finding two = finding_of("gaps", stamped(stamps));
  EXPECT_TRUE(is_finding(two, "gap", {{"lost", 32}, {"longest", 0.31, "s"}}, ""));
  EXPECT_EQ(two.occurrences.count, 2u);
  EXPECT_DOUBLE_EQ(two.occurrences.worst.time, 9.99);
}

TEST(Checks, DuplicateAndBackwardStamps) {
  auto stamps = series(100, [](std::size_t i) { return 0.5 * static_cast<double>(i); });
  stamps[50] = stamps[49];
  const Finding twice = finding_of("duplicate_stamps", stamped(stamps));
  EXPECT_TRUE(is_finding(twice, "duplicate_stamps", {}, ""));
  EXPECT_EQ(twice.occurrences.count, 1u);
  EXPECT_EQ(twice.occurrences.first.time, 24.5);
  stamps[70] = 1.0;
  const Finding backward = finding_of("backward_stamps", stamped(stamps));
  EXPECT_TRUE(
      is_finding(backward, "backward_stamps", {{"sample", 70}, {"stamp", 1.0, "s"}, {"before", 34.5, "s"}}, ""));
  EXPECT_EQ(backward.occurrences.count, 1u);
  EXPECT_EQ(backward.severity, Finding::Severity::error);
  for (std::size_t i = 0; i < stamps.size(); ++i) stamps[i] = std::floor(static_cast<double>(i) / 4.0);
  const Finding coarse = finding_of("duplicate_stamps", stamped(stamps));
  EXPECT_EQ(coarse.code, "coarse_stamps");
  EXPECT_EQ(coarse.occurrences.count, 75u);
}

TEST(Checks, AClockThatStandsStill) {
  const Recording still = stamped(std::vector<double>(50, 0.0));
  const Finding finding = finding_of("duplicate_stamps", still);
  EXPECT_TRUE(is_finding(finding, "clock_stands_still", {{"stamp", 0.0, "s"}}, ""));
  EXPECT_EQ(finding.severity, Finding::Severity::error);
  EXPECT_TRUE(findings_of("jitter", still).empty());
}

TEST(Checks, Jitter) {
  const auto noise = white(5000, 2);
  const auto late =
      series(5000, [&](std::size_t i) { return 0.01 * static_cast<double>(i) + 0.002 * std::abs(noise[i]); });
  const Findings even = findings_of("jitter", stamped(late));
  ASSERT_EQ(even.size(), 1u);
  EXPECT_EQ(even[0].severity, Finding::Severity::info);
  EXPECT_EQ(even[0].code, "jitter");
  double t = 0.0;
  const RandomStream random(3);
  const auto irregular = series(5000, [&](std::size_t i) { return t -= 0.01 * std::log(random.uniform(i)); });
  const Recording uneven = stamped(irregular);
  const Findings found = run_checks(uneven, nullptr);
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0].severity, Finding::Severity::warning);
  EXPECT_EQ(found[0].code, "rate_not_constant");
}

TEST(Checks, ScheduleMismatch) {
  const Plan plan = two_runs();
  Recording made = recording({channel("gyro", "deg/h", white(40'000, 10))});  // 400 s: 40 s between the runs
  made.marks = {{"soak", 0.0, 1}, {"ramp", 60.0, 1}, {"soak", 220.0, 2}, {"ramp", 280.0, 2}};
  EXPECT_TRUE(findings_of("schedule_mismatch", made, &plan).empty());
  EXPECT_TRUE(findings_of("schedule_mismatch", made, nullptr).empty());
  made.marks[1].begin = 50.0;
  EXPECT_TRUE(is_finding(finding_of("schedule_mismatch", made, &plan), "segment_duration",
                         {{"segment", "soak"}, {"run", 1}, {"recorded", 50.0, "s"}, {"planned", 60.0, "s"}}, "0 s"));
  made.marks[1].begin = 60.0;
  made.marks[3].label = "slope";
  const Findings renamed = findings_of("schedule_mismatch", made, &plan);
  ASSERT_EQ(renamed.size(), 2u);
  EXPECT_TRUE(is_finding(renamed[0], "segment_not_scheduled", {{"segment", "slope"}, {"run", 2}}, "280 s"));
  EXPECT_TRUE(is_finding(renamed[1], "segment_not_recorded", {{"segment", "ramp"}, {"run", 2}}, ""));
  made.marks = {{"soak", 0.0, 1}, {"ramp", 50.0, 1}, {"soak", 220.0, 2}, {"ramp", 260.0, 2}};
  const Finding gathered = finding_of("schedule_mismatch", made, &plan);
  EXPECT_TRUE(is_finding(gathered, "segment_duration",
                         {{"segment", "soak"}, {"run", 2}, {"recorded", 40.0, "s"}, {"planned", 60.0, "s"}}, ""));
  EXPECT_EQ(gathered.occurrences.count, 3u);
  EXPECT_EQ(gathered.occurrences.worst.label, "'soak' of run 2");
  made.marks.clear();
  EXPECT_TRUE(findings_of("schedule_mismatch", made, &plan).empty());
  made.channels[0].values.resize(10'000);
  EXPECT_TRUE(is_finding(finding_of("schedule_mismatch", made, &plan), "length_of_no_part",
                         {{"recorded", 100.0, "s"}, {"planned", 360.0, "s"}}, ""));
  made.channels[0].values.resize(18'000);
  EXPECT_TRUE(findings_of("schedule_mismatch", made, &plan).empty());  // one run
}

// Samples that begin 0.5 s after the first mark and end 0.5 s after the plan are late; at the end alone, the last segment is long.
TEST(Checks, SamplesLateOnMarks) {
  Plan plan = two_runs();
  plan.schedule.resize(2);  // 60 s and 100 s
  const double length = plan.schedule[0].duration + plan.schedule[1].duration;
  Recording made = recording({channel("gyro", "deg/h", white(static_cast<std::size_t>(100.0 * length), 10))});
  made.marks = {{"soak", 0.0, 1}, {"ramp", plan.schedule[0].duration, 1}};
  EXPECT_TRUE(findings_of("schedule_mismatch", made, &plan).empty());
  made.channels[0].timeline.start = 2.5;
  EXPECT_TRUE(
      is_finding(finding_of("schedule_mismatch", made, &plan), "samples_late_on_marks", {{"shift", 2.5, "s"}}, ""));
  made.channels[0].timeline.start = 0.0;
  made.channels[0].values.resize(made.channels[0].values.size() + 250);
  EXPECT_EQ(finding_of("schedule_mismatch", made, &plan).code, "segment_duration");
}

/// 10 s of samples at 100 Hz; a stream may come late by half a second.
TEST(Checks, SegmentsBehindTheLastSample) {
  Recording made = recording({channel("gyro", "deg/h", white(1000, 1))});
  made.marks = {{"a", 0.0, 1, 4.0}, {"b", 4.0, 1, 10.4}};
  EXPECT_TRUE(findings_of("samples_end_early", made).empty());
  made.marks.back().end = 10.6;
  EXPECT_EQ(finding_of("samples_end_early", made).occurrences.count, 1u);
  made.marks = {{"a", 0.0, 1, 4.0}, {"b", 4.0, 1, 12.0}, {"", 12.0}, {"c", 13.0, 1, 15.0}, {"d", 16.0, 1, 18.0}};
  const Finding finding = finding_of("samples_end_early", made);
  EXPECT_EQ(finding.occurrences.count, 3u);
  EXPECT_EQ(std::get<double>(finding.values[1].value), 10.0);
  EXPECT_EQ(std::get<double>(finding.values[2].value), 18.0);
  Plan plan;
  plan.schedule = {{.label = "d", .duration = 2.0}};
  EXPECT_EQ(finding_of("samples_end_early", made, &plan).occurrences.count, 2u) << "only the plan says that d goes on";
  made.marks = {{"a", 0.0}, {"b", 9.0}};
  EXPECT_TRUE(findings_of("samples_end_early", made).empty()) << "b ends with the data";
  made.marks.push_back({"c", 11.0});
  EXPECT_EQ(finding_of("samples_end_early", made).occurrences.count, 1u);
}

// F = counts over time: stamps of 9.990 Hz where 10 Hz is stated make a scale factor wrong by 1000 ppm, if they are
// wrong.
TEST(Checks, StatedRate) {
  Plan plan;
  plan.sample_rate = 10.0;
  const auto counts = series(2000, [](std::size_t i) { return 1000.0 + static_cast<double>(i * 7919 % 13); });
  const auto of = [&](const char* unit, double rate) {
    return findings_of("stated_rate", recording({channel("gyro", unit, counts, rate)}), &plan);
  };
  EXPECT_TRUE(of("pulse", 10.0).empty());
  ASSERT_EQ(of("pulse", 9.99).size(), 1u);
  EXPECT_EQ(of("pulse", 9.99)[0].severity, Finding::Severity::warning);
  EXPECT_TRUE(is_finding(of("pulse", 9.99)[0], "rate_of_counts_differs",
                         {{"rate", 9.99, "Hz"}, {"stated", 10.0, "Hz"}, {"difference", -1e-3}}, ""));
  EXPECT_EQ(of("pulse", 10.0005)[0].severity, Finding::Severity::info);  // quartz
  EXPECT_EQ(of("deg/h", 9.99)[0].severity, Finding::Severity::info);     // the oscillator of a cheap sensor
  EXPECT_EQ(of("deg/h", 9.6)[0].severity, Finding::Severity::warning);
  EXPECT_TRUE(findings_of("stated_rate", recording({channel("gyro", "deg/h", counts, 9.99)}), nullptr).empty());
  // a table at another rate is not the instrument
  EXPECT_TRUE(findings_of("stated_rate",
                          recording({channel("table", "deg", counts, 400.0), channel("gyro", "pulse", counts, 10.0)}),
                          &plan)
                  .empty());
}

// Stamps that scatter over a short record exclude nothing.
TEST(Checks, StatedRateWithinWhatTheStampsLeaveOpen) {
  Plan plan;
  plan.sample_rate = 100.0;
  Channel gyro = channel("gyro", "pulse", series(200, [](std::size_t i) { return static_cast<double>(i % 7); }));
  std::vector<double> stamps;
  for (std::size_t i = 0; i < 200; ++i)
    stamps.push_back(0.010001 * static_cast<double>(i) + (i % 3 == 0 ? 0.002 : 0.0));
  gyro.timeline = {0.0, 0.0, std::make_shared<const std::vector<double>>(stamps)};
  EXPECT_TRUE(findings_of("stated_rate", recording({gyro}), &plan).empty());
}

}  // namespace
}  // namespace tumble
