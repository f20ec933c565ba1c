#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <numbers>
#include <numeric>
#include <sstream>
#include <string>

#include "tumble/checks/check.hpp"
#include "tumble/math/random.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

Channel channel(std::string name, const char* unit, std::vector<double> values_in_unit, double rate = 100.0) {
  Channel made;
  made.name = std::move(name);
  made.unit = Unit::parse(unit);
  made.kind = kind_of(made.unit);
  made.timeline.rate = rate;
  made.values = std::move(values_in_unit);
  for (double& value : made.values) value = made.unit.to_si(value);
  return made;
}

Recording recording(std::vector<Channel> channels) {
  Recording made;
  made.channels = std::move(channels);
  return made;
}

std::vector<double> series(std::size_t count, const std::function<double(std::size_t)>& value) {
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = value(i);
  return values;
}

std::vector<double> white(std::size_t count, std::uint64_t seed) {
  std::vector<double> values(count);
  RandomStream(seed).normal(0, values);
  return values;
}

Findings findings_of(std::string_view check, const Recording& recording, const Plan* plan = nullptr) {
  for (const Check* entry : check_catalogue())
    if (entry->name == check) return entry->run(recording, plan);
  ADD_FAILURE() << "no check " << check;
  return {};
}

std::string said(const Findings& findings) {
  std::string text;
  for (const auto& finding : findings) text += finding.where + ": " + finding.message + "\n";
  return text;
}

/// The only finding, as "where: message".
std::string only(std::string_view check, const Recording& recording, const Plan* plan = nullptr) {
  const Findings findings = findings_of(check, recording, plan);
  EXPECT_EQ(findings.size(), 1u) << said(findings);
  return findings.empty() ? "" : findings[0].where + ": " + findings[0].message;
}

/// The only finding.
Finding finding_of(std::string_view check, const Recording& recording, const Plan* plan = nullptr) {
  const Findings findings = findings_of(check, recording, plan);
  EXPECT_EQ(findings.size(), 1u) << said(findings);
  return findings.empty() ? Finding{} : findings[0];
}

Recording stamped(std::vector<double> stamps) {
  Channel made = channel("gyro", "deg/h", white(stamps.size(), 1));
  made.timeline.rate = 0.0;
  made.timeline.stamps = std::make_shared<const std::vector<double>>(std::move(stamps));
  return recording({made});
}

// ---- what must be found

TEST(Checks, Gaps) {
  auto stamps = series(5000, [](std::size_t i) { return 0.01 * static_cast<double>(i + (i >= 1000 ? 30 : 0)); });
  EXPECT_EQ(
      only("gaps", stamped(stamps)),
      ": gap of 310 ms at 9.99 s: 30 samples lost; methods that need a constant rate cannot use data across a gap");
  for (std::size_t i = 2000; i < stamps.size(); ++i) stamps[i] += 0.02;
  EXPECT_EQ(
      only("gaps", stamped(stamps)),
      ": 2 gaps, 32 samples lost; the longest: 310 ms at 9.99 s; methods that need a constant rate cannot use data "
      "across a gap");
}

TEST(Checks, DuplicateAndBackwardStamps) {
  auto stamps = series(100, [](std::size_t i) { return 0.5 * static_cast<double>(i); });
  stamps[50] = stamps[49];
  EXPECT_EQ(only("duplicate_stamps", stamped(stamps)), ": one sample has the stamp of the sample before, at 24.5 s");
  stamps[70] = 1.0;
  EXPECT_EQ(only("backward_stamps", stamped(stamps)),
            ": the clock runs backwards once, at sample 70: 1 s after 34.5 s");
  EXPECT_EQ(findings_of("backward_stamps", stamped(stamps))[0].severity, Finding::Severity::error);
  for (std::size_t i = 0; i < stamps.size(); ++i) stamps[i] = std::floor(static_cast<double>(i) / 4.0);
  const Finding coarse = finding_of("duplicate_stamps", stamped(stamps));
  EXPECT_EQ(coarse.code, "coarse_stamps");
  EXPECT_EQ(coarse.occurrences.count, 75u);
}

TEST(Checks, AClockThatStandsStill) {
  const Recording still = stamped(std::vector<double>(50, 0.0));
  EXPECT_EQ(only("duplicate_stamps", still),
            ": the clock stands still: all stamps are 0 s; the samples need a rate in place of stamps");
  EXPECT_EQ(findings_of("duplicate_stamps", still)[0].severity, Finding::Severity::error);
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

TEST(Checks, MissingSamples) {
  auto values = white(1000, 4);
  values[10] = values[500] = values[501] = NAN;
  EXPECT_EQ(only("missing_samples", recording({channel("gyro", "deg/h", values)})),
            "gyro: 3 of 1000 samples are missing (0.3 %), at most 2 in a row, from 5 s");
  EXPECT_EQ(only("missing_samples", recording({channel("gyro", "deg/h", {NAN, NAN})})),
            "gyro: every sample is missing");
  EXPECT_EQ(only("missing_samples", recording({channel("gyro", "deg/h", {})})), "gyro: the channel has no samples");
}

TEST(Checks, StuckOutput) {
  auto values = white(20'000, 5);
  for (std::size_t i = 3000; i < 3020; ++i) values[i] = values[3000];
  EXPECT_EQ(only("stuck_output", recording({channel("gyro", "deg/h", values)})),
            "gyro: the output is stuck once (20 samples), for 190 ms at 30 s");
  auto counts = white(20'000, 6);
  for (double& value : counts) value = std::round(2.0 * value);
  EXPECT_TRUE(findings_of("stuck_output", recording({channel("gyro", "pulse", counts)})).empty());
  for (std::size_t i = 3000; i < 3100; ++i) counts[i] = 1.0;
  EXPECT_EQ(findings_of("stuck_output", recording({channel("gyro", "pulse", counts)})).size(), 1u);
}

// Two positions of a quiet unit: one just between two pulses, one well within one.
TEST(Checks, QuietCountsOfAPositionAreNeitherStuckNorSaturated) {
  auto counts = white(400, 7);
  for (std::size_t i = 0; i < 400; ++i)
    counts[i] = i < 200 ? std::round(10.5 + 2.0 * counts[i]) : i < 300 ? 30.0 : std::round(20.5 + 0.5 * counts[i]);
  Recording two = recording({channel("accelerometer", "pulse", counts, 1.0)});
  EXPECT_EQ(findings_of("stuck_output", two).size() + findings_of("saturation", two).size(), 1u);
  two.marks = {{"a", 0.0, 1}, {"b", 200.0, 1}, {"c", 300.0, 1}};
  EXPECT_EQ(said(findings_of("stuck_output", two)) + said(findings_of("saturation", two)), "");
  // but stuck within its noise it is
  for (std::size_t i = 60; i < 140; ++i) two.channels[0].values[i] = 10.0;
  EXPECT_EQ(findings_of("stuck_output", two).size(), 1u);
}

TEST(Checks, ConstantCountsOfOnePositionAreNoError) {
  Recording one = recording({channel("accelerometer", "pulse", std::vector<double>(100, 14185.0))});
  one.origin.file = "p1.csv";
  EXPECT_EQ(findings_of("stuck_output", one)[0].severity, Finding::Severity::error);
  Plan plan;
  plan.recordings = {{"p1.csv", "up", 0, nullptr}};
  EXPECT_EQ(findings_of("stuck_output", one, &plan)[0].severity, Finding::Severity::info);
}

TEST(Checks, ConstantChannel) {
  const std::vector<double> flat(100, 25.0);
  EXPECT_EQ(only("stuck_output", recording({channel("gyro", "deg/h", flat)})),
            "gyro: the output is constant: 25 deg/h");
  EXPECT_EQ(findings_of("stuck_output", recording({channel("gyro", "deg/h", flat)}))[0].severity,
            Finding::Severity::error);
  EXPECT_EQ(findings_of("stuck_output", recording({channel("temperature", "degC", flat)}))[0].severity,
            Finding::Severity::info);
}

TEST(Checks, SaturatedNoiseAndOscillation) {
  auto noise = white(50'000, 7);
  for (double& value : noise) value = std::min(std::round(20.0 * value) / 20.0, 2.5);
  EXPECT_NE(only("saturation", recording({channel("gyro", "deg/h", noise)})).find("at the highest value, 2.5 deg/h"),
            std::string::npos);
  const auto sine = series(50'000, [](std::size_t i) {
    return std::clamp(6.0 * std::sin(2 * std::numbers::pi * 7.3 * static_cast<double>(i) / 100.0), -5.0, 5.0);
  });
  EXPECT_EQ(findings_of("saturation", recording({channel("accelerometer", "g", sine)})).size(), 2u);
}

// 50 Hz in 200 windows a second: the two windows about each peak hold the same count every time, and nothing is cut.
TEST(Checks, CountsThatRepeatWithTheWindowsAreNotSaturated) {
  const auto noise = white(20'000, 31);
  const auto tone = [&](double cycles, double amplitude, double top) {
    return series(20'000, [=](std::size_t i) {
      const double at = 10.0 + amplitude * std::sin(2 * std::numbers::pi * (cycles * static_cast<double>(i) + 0.125));
      return std::round(std::min(at, top) + 0.05 * noise[i]);
    });
  };
  for (const double cycles : {0.25, 0.1, 0.4})
    EXPECT_TRUE(findings_of("saturation", recording({channel("gyro", "pulse", tone(cycles, 29.7, 1e3))})).empty());
  EXPECT_EQ(findings_of("saturation", recording({channel("gyro", "pulse", tone(0.0731, 60.0, 40.0))})).size(), 1u);
}

// A count that rounding keeps at one number at rest, between two vibrations; one that stops while it is shaken.
TEST(Checks, CountsAtRestAreNotStuck) {
  auto counts = white(20'000, 32);
  for (std::size_t i = 0; i < counts.size(); ++i) counts[i] = i >= 5000 && i < 6000 ? 1.0 : std::round(8.0 * counts[i]);
  Recording rest = recording({channel("gyro", "pulse", counts)});
  EXPECT_EQ(findings_of("stuck_output", rest).size(), 1u);
  const auto at = [&](std::size_t i) { return rest.channels[0].time(i); };
  rest.marks = {{"shaken", at(0), 1}, {"rest", at(5000), 1}, {"shaken again", at(6000), 1}};
  EXPECT_TRUE(findings_of("stuck_output", rest).empty());
  rest.marks[1].begin = at(5005);  // the last segment comes to rest five samples before it ends
  EXPECT_TRUE(findings_of("stuck_output", rest).empty());
  rest.marks = {{"shaken", at(0), 1}, {"shaken again", at(5500), 1}};  // it stops in one and goes on in the next
  EXPECT_EQ(findings_of("stuck_output", rest).size(), 1u);
  rest.marks = {{"shaken", at(0), 1}, {"rest", at(10'000), 1}};
  EXPECT_EQ(findings_of("stuck_output", rest).size(), 1u);
}

// 19112.0 pulses in each window of every other segment, rounded in one running total: the counts repeat while the total
// lies within a pulse and flicker by one at its edge.
TEST(Checks, CountsNearAWholeNumberOfPulsesAreNotStuck) {
  for (const unsigned seed : {41u, 42u, 43u, 44u, 45u, 46u}) {
    auto counts = white(128'000, seed);
    double total = 0.45, last = 0.0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const std::size_t segment = i / 640;
      total += (segment % 2 == 1 ? 19112.0 : segment % 4 == 2 ? -19000.3 : 9000.4) + 0.04 * counts[i];
      counts[i] = std::floor(total) - last;
      last += counts[i];
    }
    EXPECT_EQ(said(findings_of("stuck_output", recording({channel("gyro", "pulse", counts, 10.0)}))), "") << seed;
  }
}

TEST(Checks, Outliers) {
  auto values = white(20'000, 8);
  values[1234] += 40.0;
  values[15'000] -= 25.0;
  const std::string found = only("outliers", recording({channel("gyro", "deg/h", values)}));
  EXPECT_NE(found.find("gyro: 2 samples are far from"), std::string::npos) << found;
  EXPECT_NE(found.find("at 12.34 s"), std::string::npos) << found;
}

/// At rest at 0, at 90 deg, then turning with 7 deg a sample.
std::vector<double> angles_that_begin_again(double lowest, double noise) {
  auto angles = white(3000, 5);
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const double turned = (i < 1000 ? 0.0 : i < 2000 ? 90.0 : 7.0 * static_cast<double>(i)) + noise * angles[i];
    angles[i] = turned - 360.0 * std::floor((turned - lowest) / 360.0);
    angles[i] = std::round(1e4 * angles[i]) / 1e4;
  }
  return angles;
}

TEST(Checks, AnAngleThatBeginsAgainAfterATurnIsNeitherDamagedNorSaturated) {
  for (const double lowest : {0.0, -180.0, -90.0})
    for (const double noise : {0.0, 2e-5, 1e-3}) {
      Recording one = recording({channel("table_angle", "deg", angles_that_begin_again(lowest, noise))});
      one.marks = {{"rest", 0.0, 1}, {"at 90 deg", 10.0, 1}, {"turn", 20.0, 1}};
      EXPECT_EQ(said(findings_of("outliers", one)) + said(findings_of("saturation", one)), "")
          << lowest << " " << noise;
    }
  Recording damaged = recording({channel("table_angle", "deg", angles_that_begin_again(0.0, 1e-3))});
  damaged.channels[0].values[500] = si(40.0, "deg");
  EXPECT_NE(said(findings_of("outliers", damaged)).find("40"), std::string::npos);
}

TEST(Checks, SamplesThatNoInstrumentPutsOutAreAnError) {
  auto values = white(20'000, 8);
  values[1234] += 40.0;
  values[15'000] = -1e30;
  const auto findings = findings_of("outliers", recording({channel("gyro", "deg/h", values)}));
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].code, "damaged_sample");
  EXPECT_EQ(findings[0].severity, Finding::Severity::error);
  EXPECT_EQ(findings[0].occurrences.count, 1u);
  EXPECT_EQ(findings[1].code, "outlier");
}

TEST(Checks, SmoothNoiseBesideMissingSamplesHoldsNoOutliers) {
  // What changes smoothly differs from its neighbours by many bends: before, each steep part beside a missing sample
  // was an outlier.
  auto values = white(20'000, 11);
  for (int time = 0; time < 3; ++time)
    for (std::size_t i = 0; i + 10 < values.size(); ++i)
      values[i] = std::accumulate(values.begin() + i, values.begin() + i + 10, 0.0) / 10.0;
  values.resize(values.size() - 30);
  for (std::size_t i = 7; i < values.size(); i += 20) values[i] = std::nan("");
  EXPECT_TRUE(findings_of("outliers", recording({channel("gyro", "deg/h", values)})).empty());
}

// What two channels show within two samples is one event, of which neither is accused.
TEST(Checks, OutliersOfSeveralChannelsAtOnceAreOneEvent) {
  auto x = white(20'000, 8), y = white(20'000, 9), z = white(20'000, 10);
  x[1234] += 40.0, y[1235] -= 60.0, z[7000] += 40.0;
  const auto findings =
      findings_of("outliers", recording({channel("x", "g", x), channel("y", "g", y), channel("z", "g", z)}));
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].where, "z");
  EXPECT_EQ(findings[1].code, "outliers_together");
  EXPECT_EQ(findings[1].severity, Finding::Severity::info);
  EXPECT_EQ(findings[1].occurrences.count, 1u);
  EXPECT_EQ(std::get<std::string>(findings[1].values[0].value), "x, y");
}

TEST(Checks, MoveBetweenSegmentsIsNoOutlier) {
  auto values = white(2000, 5);
  values[1001] = 500.0;
  Recording moved = recording({channel("gyro", "deg/h", values)});
  EXPECT_EQ(findings_of("outliers", moved).size(), 1u);
  moved.marks = {{"first", moved.channels[0].time(0), 1}, {"second", moved.channels[0].time(1000), 1}};
  EXPECT_TRUE(findings_of("outliers", moved).empty());
  // the last sample before the next move begins, where durations that were added up are off by a rounding
  moved.marks[1].begin = moved.channels[0].time(1002) * (1.0 + 1e-15);
  EXPECT_TRUE(findings_of("outliers", moved).empty());
}

TEST(Checks, Units) {
  EXPECT_EQ(only("units", recording({channel("gyro.x", "m/s^2", white(100, 9))})),
            "gyro.x: the channel is in m/s^2; for 'gyro.x', an angular rate or angle increment or a raw output is "
            "expected");
  EXPECT_EQ(finding_of("units", recording({channel("gyro", "1", white(100, 9))})).code, "no_unit");
  EXPECT_TRUE(findings_of("units", recording({channel("gyro", "V", white(100, 9))})).empty());
  EXPECT_TRUE(findings_of("units", recording({channel("gyroscope", "m", white(100, 9))})).empty());
  Plan plan;
  plan.channels["gyro"] = {{"ch1", {}}};
  EXPECT_NE(only("units", recording({channel("ch1", "g", white(100, 9))}), &plan).find("for 'gyro'"),
            std::string::npos);
  EXPECT_EQ(finding_of("units", recording({channel("temperature.case", "K", {25.0, 26.0})})).code, "implausibly_cold");
  EXPECT_EQ(only("units", recording({channel("temperature", "degC", {25.0, -300.0})})),
            "temperature: -300 degC lies below absolute zero");
}

TEST(Checks, GravityOfOneMetrePerSecondSquaredIsG) {
  const auto triad = [](const char* unit, double z) {
    std::vector<Channel> channels;
    for (const char* axis : {"x", "y", "z"}) {
      auto values = white(100, 9);
      for (double& value : values) value = 0.01 * value + (*axis == 'z' ? z : 0.0);
      channels.push_back(channel(std::string("imu.accelerometer.") + axis, unit, values));
    }
    return findings_of("units", recording(channels));
  };
  ASSERT_EQ(triad("m/s^2", 1.0).size(), 1u);
  EXPECT_EQ(triad("m/s^2", 1.0).front().code, "force_probably_in_g");
  EXPECT_TRUE(triad("g", 1.0).empty());
  EXPECT_TRUE(triad("m/s^2", -9.81).empty());
  EXPECT_TRUE(triad("m/s^2", 0.0).empty());
}

Plan two_runs() {
  Plan plan;
  plan.schedule = {{"soak", 60.0, 1, {}}, {"ramp", 120.0, 1, {}}, {"soak", 60.0, 2, {}}, {"ramp", 120.0, 2, {}}};
  return plan;
}

TEST(Checks, ScheduleMismatch) {
  const Plan plan = two_runs();
  Recording made = recording({channel("gyro", "deg/h", white(40'000, 10))});  // 400 s: 40 s between the runs
  made.marks = {{"soak", 0.0, 1}, {"ramp", 60.0, 1}, {"soak", 220.0, 2}, {"ramp", 280.0, 2}};
  EXPECT_TRUE(findings_of("schedule_mismatch", made, &plan).empty());
  EXPECT_TRUE(findings_of("schedule_mismatch", made, nullptr).empty());
  made.marks[1].begin = 50.0;
  EXPECT_EQ(only("schedule_mismatch", made, &plan), "0 s: segment 'soak' of run 1 lasts 50 s, but the plan says 60 s");
  made.marks[1].begin = 60.0;
  made.marks[3].label = "slope";
  EXPECT_EQ(said(findings_of("schedule_mismatch", made, &plan)),
            "280 s: segment 'slope' of run 2 is not in the schedule, or not as often as it was recorded\n: segment "
            "'ramp' of run 2 is not in the recording\n");
  made.marks = {{"soak", 0.0, 1}, {"ramp", 50.0, 1}, {"soak", 220.0, 2}, {"ramp", 260.0, 2}};
  EXPECT_EQ(
      only("schedule_mismatch", made, &plan),
      ": 3 segments last longer or shorter than the plan says; the most: 'soak' of run 2 lasts 40 s instead of 60 s");
  made.marks.clear();
  EXPECT_TRUE(findings_of("schedule_mismatch", made, &plan).empty());
  made.channels[0].values.resize(10'000);
  EXPECT_EQ(only("schedule_mismatch", made, &plan),
            ": the recording lasts 100 s, the schedule 360 s, and no run or segment of it lasts as long");
  made.channels[0].values.resize(18'000);
  EXPECT_TRUE(findings_of("schedule_mismatch", made, &plan).empty());  // one run
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
  made.marks = {{"a", 0.0}, {"b", 9.0}};
  EXPECT_TRUE(findings_of("samples_end_early", made).empty()) << "b ends with the data";
  made.marks.push_back({"c", 11.0});
  EXPECT_EQ(finding_of("samples_end_early", made).occurrences.count, 1u);
}

TEST(Checks, HostileRecordings) {
  const Plan plan = two_runs();
  for (const auto& values : std::vector<std::vector<double>>{{},
                                                             {1},
                                                             {NAN},
                                                             {1, 2},
                                                             {NAN, 1, NAN},
                                                             {INFINITY, 1, 2},
                                                             std::vector<double>(100, NAN),
                                                             std::vector<double>(100, INFINITY),
                                                             {1e308, -1e308, 1e308, 5}}) {
    run_checks(recording({channel("gyro", "deg/h", values)}), &plan);
    run_checks(stamped(values), &plan);
  }
  EXPECT_TRUE(run_checks({}, nullptr).empty());
}

Channel counts(std::vector<double> values) { return channel("accelerometer", "pulse", std::move(values)); }

TEST(Checks, CounterThatRunsOver) {
  const auto noise = white(4000, 31);
  // 65 530 pulses a window and a scatter of 3, in 16 bits.
  auto wrapped = series(4000, [&](std::size_t i) { return std::round(65'530.0 + 3.0 * noise[i]); });
  std::size_t over = 0;
  for (double& value : wrapped)
    if (value > 65'535.0) value -= 65'536.0, ++over;
  ASSERT_GT(over, 50u);
  const Findings found = findings_of("counter_overflow", recording({counts(wrapped)}));
  ASSERT_EQ(found.size(), 1u) << said(found);
  EXPECT_EQ(found[0].severity, Finding::Severity::error);
  EXPECT_NE(found[0].message.find("passed the end of its unsigned register of 16 bits"), std::string::npos);
  EXPECT_NE(found[0].message.find("add or subtract 65536"), std::string::npos) << found[0].message;
  // With sign, and a total that runs on.
  for (const int bits : {16, 24, 32}) {
    const double size = std::ldexp(1.0, bits), step = size / 500.0;
    const auto total = series(4000, [&](std::size_t i) {
      const double sum = std::floor(step * static_cast<double>(i));
      return sum - size * std::floor(sum / size + 0.5);
    });
    EXPECT_NE(only("counter_overflow", recording({counts(total)}))
                  .find("signed register of " + std::to_string(bits) + " bits 8 times"),
              std::string::npos)
        << bits;
  }
}

TEST(Checks, CounterThatStopsAtItsEnd) {
  const auto noise = white(4000, 32);
  const auto stopped =
      series(4000, [&](std::size_t i) { return std::min(4095.0, std::round(4090.0 + 5.0 * noise[i])); });
  EXPECT_NE(only("counter_overflow", recording({counts(stopped)}))
                .find("stays at 4095, the end of its unsigned register of 12 bits, in "),
            std::string::npos);
}

TEST(Checks, CounterReadTooLate) {
  const auto noise = white(4000, 33);
  auto values = series(4000, [&](std::size_t i) { return std::round(500.0 + 4.0 * noise[i]); });
  values[1000] = 1003.0;
  values[2000] = 2498.0;
  EXPECT_EQ(
      only("missed_windows", recording({counts(values)})),
      "accelerometer: 2 windows hold the pulses of several (the first, at 10 s, 2 times those of its neighbours), 5 "
      "windows missed: the card was read too late, after it had counted further; leave such windows blank, or "
      "distribute "
      "their pulses over the missed windows");
  EXPECT_TRUE(findings_of("missed_windows", recording({channel("gyro", "deg/h", values)})).empty());
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
  EXPECT_EQ(said(of("pulse", 9.99)),
            ": the stamps have 9.99 Hz, and 10 Hz is stated (-1000 ppm): the stamps are used; if they are wrong, rates "
            "and scale factors from the counts are wrong by as much\n");
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

TEST(Checks, UnequalWindows) {
  const auto noise = white(4000, 34), other = white(4000, 35);
  std::vector<double> stamps(4000), follow(4000), late(4000);
  double now = 0.0;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    stamps[i] = now;
    const double length = 0.005 * (1.0 + 0.02 * noise[i]);
    now += length;
    follow[i] = std::round(1e5 * length + other[i]);
    late[i] = std::round(500.0 + other[i]);
  }
  const auto made = [&](std::vector<double> values) {
    Channel c = counts(std::move(values));
    c.timeline.rate = 0.0;
    c.timeline.stamps = std::make_shared<const std::vector<double>>(stamps);
    return recording({c});
  };
  const Finding unequal = finding_of("unequal_windows", made(follow));
  EXPECT_EQ(unequal.code, "unequal_windows");
  EXPECT_NEAR(std::get<double>(unequal.values.at(0).value), 0.02, 0.0011);  // 4 sd: 4 * 0.02 sqrt(1.5/8000)
  EXPECT_TRUE(findings_of("unequal_windows", made(late)).empty());
}

// ---- what must not be found

struct Clean {
  const char* what;
  std::function<double(std::size_t, double)> value;  ///< of index and white noise
};

double step_to(double value, double quantum) { return std::round(value / quantum) * quantum; }

double trapezoid(std::size_t i) {
  const double t = static_cast<double>(i % 10'000) / 100.0;
  return 100.0 * std::clamp(std::min(t - 10.0, 60.0 - t) / 10.0, 0.0, 1.0);
}

const std::vector<Clean>& clean_signals() {
  static const std::vector<Clean> all{
      {"white noise", [](std::size_t, double w) { return w; }},
      {"noise of 3 LSB", [](std::size_t, double w) { return std::round(3.0 * w); }},
      {"noise of 1 LSB", [](std::size_t, double w) { return std::round(w); }},
      {"noise of 0.4 LSB", [](std::size_t, double w) { return std::round(0.4 * w); }},
      {"noise of 0.3 LSB off centre", [](std::size_t, double w) { return std::round(0.3 * w + 0.4); }},
      {"temperature ramp", [](std::size_t i, double w) { return -20.0 + 1e-3 * static_cast<double>(i) + 0.01 * w; }},
      {"coarse temperature ramp then dwell",
       [](std::size_t i, double w) {
         return step_to(20.0 + 1e-3 * static_cast<double>(std::min<std::size_t>(i, 15'000)) + 0.003 * w, 0.0625);
       }},
      {"coarse temperature without noise",
       [](std::size_t i, double) { return step_to(20.0 + 5.0 * std::sin(static_cast<double>(i) / 8000.0), 0.0625); }},
      {"noise-free rate table", [](std::size_t i, double) { return trapezoid(i); }},
      {"noisy rate table", [](std::size_t i, double w) { return trapezoid(i) + 0.05 * w; }},
      {"noisy coarse rate table", [](std::size_t i, double w) { return step_to(trapezoid(i) + 0.05 * w, 0.02); }},
      {"encoder at rest and slewing", [](std::size_t i, double) { return step_to(30.0 * trapezoid(i), 0.36); }},
      {"sine", [](std::size_t i, double) { return std::sin(0.3 * static_cast<double>(i)); }},
      {"coarse sine", [](std::size_t i, double) { return std::round(400.0 * std::sin(0.3 * static_cast<double>(i))); }},
      {"rest and shake",
       [](std::size_t i, double w) { return (i / 2000 % 2 == 0 ? 0.01 : 1.0) * w + (i / 2000 % 2 == 0 ? 0.0 : 5.0); }},
      {"quiet and shaken, too coarse for the quiet",
       [](std::size_t i, double w) { return std::round((i / 2000 % 2 == 0 ? 0.2 : 20.0) * w); }},
      {"knocks that ring",
       [](std::size_t i, double w) {
         const double since = static_cast<double>(i % 3000);
         return 0.01 * w + 5.0 * std::exp(-since / 3.0) * std::cos(2.5 * since);
       }},
      {"steps between positions",
       [](std::size_t i, double w) {
         const std::size_t position = i / 3000;
         return std::cos(static_cast<double>(position)) + 1e-4 * w;
       }},
      {"few pulses", [](std::size_t i, double) { return i % 7 == 3 ? 1.0 : 0.0; }},
      {"random pulses", [](std::size_t, double w) { return w > 1.5 ? 1.0 : 0.0; }},
      {"truncated rate", [](std::size_t i, double w) { return std::floor(2.0 * w + 1e-4 * static_cast<double>(i)); }},
  };
  return all;
}

TEST(ChecksStaySilent, OnCleanSignals) {
  for (const Clean& clean : clean_signals())
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      const auto noise = white(30'000, 100 + seed);
      const auto values = series(30'000, [&](std::size_t i) { return clean.value(i, noise[i]); });
      const Findings findings = run_checks(recording({channel("output", "deg/s", values)}), nullptr);
      EXPECT_TRUE(findings.empty()) << clean.what << ", seed " << seed << ": " << said(findings);
    }
}

TEST(ChecksStaySilent, OnRandomWalksAndLongRecords) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    double sum = 0.0;
    auto walk = white(30'000, 200 + seed);
    for (double& value : walk) value = sum += value;
    auto coarse = walk;
    for (double& value : coarse) value = std::round(value);
    const Findings findings =
        run_checks(recording({channel("a", "deg/s", walk), channel("b", "deg/s", coarse)}), nullptr);
    EXPECT_TRUE(findings.empty()) << "seed " << seed << ": " << said(findings);
  }
  auto counts = white(3'000'000, 300);
  for (double& value : counts) value = std::round(1.5 * value);
  const Findings findings =
      run_checks(recording({channel("a", "deg/s", white(3'000'000, 301)), channel("b", "pulse", counts)}), nullptr);
  EXPECT_TRUE(findings.empty()) << said(findings);
}

// Counts of an accelerometer at rest, in sine and in random vibration, wide and narrow, of either sign.
TEST(ChecksStaySilent, OnPulseCounts) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto noise = white(20'000, 400 + seed);
    for (const double level : {-200.0, 0.0, 10.0, 100.0, 255.0, 1000.0, 32'000.0, 65'535.0})
      for (const double spread : {0.3, 3.0, 30.0}) {
        const auto values = series(20'000, [&](std::size_t i) {
          const double shaken = i / 5000 % 2 == 0 ? noise[i] : 10.0 * std::sin(0.9 * static_cast<double>(i));
          return std::round(level + spread * shaken);
        });
        for (const char* check : {"counter_overflow", "missed_windows", "unequal_windows"}) {
          const Findings findings = findings_of(check, recording({counts(values)}));
          EXPECT_TRUE(findings.empty()) << level << ", " << spread << ", seed " << seed << ": " << said(findings);
        }
      }
  }
}

// Nine minutes of an MPU-6050 at rest whose samples arrive in bursts: nothing is wrong with it but its stamps.
TEST(ChecksStaySilent, OnARealStaticRecord) {
  std::ifstream stream(TUMBLE_SOURCE_DIR "/examples/data/mpu6050_static.csv");
  std::string line, cell;
  ASSERT_TRUE(std::getline(stream, line));
  std::vector<std::vector<double>> columns(5);
  while (std::getline(stream, line)) {
    std::istringstream cells(line);
    for (auto& column : columns) {
      std::getline(cells, cell, ',');
      column.push_back(std::stod(cell));
    }
  }
  const auto stamps = std::make_shared<const std::vector<double>>(columns[0]);
  Recording made = recording({channel("gyro.x", "deg/s", columns[1]), channel("gyro.y", "deg/s", columns[2]),
                              channel("gyro.z", "deg/s", columns[3]), channel("temperature", "degC", columns[4])});
  for (Channel& part : made.channels) part.timeline = {0.0, 0.0, stamps};
  const Findings findings = run_checks(made, nullptr);
  ASSERT_EQ(findings.size(), 1u) << said(findings);
  EXPECT_EQ(findings[0].severity, Finding::Severity::info);
  EXPECT_EQ(findings[0].code, "jitter_with_pauses") << said(findings);
}

}  // namespace
}  // namespace tumble
