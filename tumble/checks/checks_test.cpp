#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <numbers>
#include <numeric>
#include <sstream>
#include <string>

#include "tumble/checks/testing/made_recordings.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

using namespace testing;

// ---- what must be found

TEST(Checks, MissingSamples) {
  auto values = white(1000, 4);
  values[10] = values[500] = values[501] = NAN;
  const Finding found = finding_of("missing_samples", recording({channel("gyro", "deg/h", values)}));
  EXPECT_TRUE(is_finding(found, "missing_samples", {{"samples", 1000}, {"part", 0.003}, {"longest", 2}}, "gyro"));
  EXPECT_EQ(found.occurrences.count, 3u);
  EXPECT_DOUBLE_EQ(found.occurrences.worst.time, 5.0);
  const auto code = [](const std::vector<double>& of) {
    return finding_of("missing_samples", recording({channel("gyro", "deg/h", of)})).code;
  };
  EXPECT_EQ(code({NAN, NAN}), "all_samples_missing");
  EXPECT_EQ(code({}), "no_samples");
}

TEST(Checks, StuckOutput) {
  auto values = white(20'000, 5);
  for (std::size_t i = 3000; i < 3020; ++i) values[i] = values[3000];
  const Finding stuck = finding_of("stuck_output", recording({channel("gyro", "deg/h", values)}));
  EXPECT_TRUE(is_finding(stuck, "stuck_output", {{"samples", 20}, {"longest", 0.19, "s"}}, "gyro"));
  EXPECT_EQ(stuck.occurrences.count, 1u);
  EXPECT_DOUBLE_EQ(stuck.occurrences.worst.time, 30.0);
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
  const Finding constant = finding_of("stuck_output", recording({channel("gyro", "deg/h", flat)}));
  EXPECT_TRUE(is_finding(constant, "constant_output", {{"value", si(25.0, "deg/h")}}, "gyro"));
  EXPECT_EQ(constant.severity, Finding::Severity::error);
  EXPECT_EQ(findings_of("stuck_output", recording({channel("temperature", "degC", flat)}))[0].severity,
            Finding::Severity::info);
}

TEST(Checks, SaturatedNoiseAndOscillation) {
  auto noise = white(50'000, 7);
  for (double& value : noise) value = std::min(std::round(20.0 * value) / 20.0, 2.5);
  EXPECT_TRUE(is_finding(finding_of("saturation", recording({channel("gyro", "deg/h", noise)})), "saturated_highest",
                         {{"value", si(2.5, "deg/h")}}, "gyro"));
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
  const Finding found = finding_of("outliers", recording({channel("gyro", "deg/h", values)}));
  EXPECT_TRUE(is_finding(found, "outlier", {}, "gyro"));
  EXPECT_EQ(found.occurrences.count, 2u);
  EXPECT_DOUBLE_EQ(found.occurrences.worst.time, 12.34);
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
  // to the nearer neighbour, each of them with a noise of 1e-3 deg: five standard deviations
  EXPECT_NEAR(value_of(findings_of("outliers", damaged), "outlier", "distance"), si(40.0, "deg"), si(0.005, "deg"));
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
  EXPECT_TRUE(is_finding(finding_of("units", recording({channel("gyro.x", "m/s^2", white(100, 9))})), "unexpected_unit",
                         {{"unit", "m/s^2"}, {"name", "gyro.x"}}, "gyro.x"));
  EXPECT_EQ(finding_of("units", recording({channel("gyro", "1", white(100, 9))})).code, "no_unit");
  EXPECT_TRUE(findings_of("units", recording({channel("gyro", "V", white(100, 9))})).empty());
  EXPECT_TRUE(findings_of("units", recording({channel("gyroscope", "m", white(100, 9))})).empty());
  Plan plan;
  plan.channels["gyro"] = {{"ch1", {}}};
  EXPECT_TRUE(is_finding(finding_of("units", recording({channel("ch1", "g", white(100, 9))}), &plan), "unexpected_unit",
                         {{"unit", "g"}, {"name", "gyro"}}, "ch1"));
  EXPECT_EQ(finding_of("units", recording({channel("temperature.case", "K", {25.0, 26.0})})).code, "implausibly_cold");
  EXPECT_TRUE(is_finding(finding_of("units", recording({channel("temperature", "degC", {25.0, -300.0})})),
                         "below_absolute_zero", {{"lowest", 273.15 - 300.0}}, "temperature"));
  EXPECT_EQ(finding_of("units", recording({channel("temperature", "degC", {243.1, 333.2})})).code, "probably_kelvin");
  EXPECT_TRUE(findings_of("units", recording({channel("temperature", "degC", {-55.0, 175.0})})).empty());
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

// ---- what must not be found

struct Clean {
  const char* what;
  std::function<double(std::size_t, double)> value;  ///< of index and white noise
  bool coarse = false;                               ///< its steps are greater than its noise, and that is all
};

double step_to(double value, double quantum) { return std::round(value / quantum) * quantum; }

double trapezoid(std::size_t i) {
  const double t = static_cast<double>(i % 10'000) / 100.0;
  return 100.0 * std::clamp(std::min(t - 10.0, 60.0 - t) / 10.0, 0.0, 1.0);
}

// NOLINTNEXTLINE(readability-function-size): a table, one entry after another
const std::vector<Clean>& clean_signals() {
  static const std::vector<Clean> all{
      {"white noise", [](std::size_t, double w) { return w; }},
      {"noise of 3 LSB", [](std::size_t, double w) { return std::round(3.0 * w); }},
      {"noise of 1 LSB", [](std::size_t, double w) { return std::round(w); }},
      {"noise of 0.4 LSB", [](std::size_t, double w) { return std::round(0.4 * w); }, true},
      {"noise of 0.3 LSB off centre", [](std::size_t, double w) { return std::round(0.3 * w + 0.4); }, true},
      {"temperature ramp", [](std::size_t i, double w) { return -20.0 + 1e-3 * static_cast<double>(i) + 0.01 * w; }},
      {"coarse temperature ramp then dwell",
       [](std::size_t i, double w) {
         return step_to(20.0 + 1e-3 * static_cast<double>(std::min<std::size_t>(i, 15'000)) + 0.003 * w, 0.0625);
       },
       true},
      {"coarse temperature without noise",
       [](std::size_t i, double) { return step_to(20.0 + 5.0 * std::sin(static_cast<double>(i) / 8000.0), 0.0625); },
       true},
      {"noise-free rate table", [](std::size_t i, double) { return trapezoid(i); }},
      {"noisy rate table", [](std::size_t i, double w) { return trapezoid(i) + 0.05 * w; }},
      {"noisy coarse rate table", [](std::size_t i, double w) { return step_to(trapezoid(i) + 0.05 * w, 0.02); }},
      {"encoder at rest and slewing", [](std::size_t i, double) { return step_to(30.0 * trapezoid(i), 0.36); }},
      {"sine", [](std::size_t i, double) { return std::sin(0.3 * static_cast<double>(i)); }},
      {"coarse sine", [](std::size_t i, double) { return std::round(400.0 * std::sin(0.3 * static_cast<double>(i))); }},
      {"rest and shake",
       [](std::size_t i, double w) { return (i / 2000 % 2 == 0 ? 0.01 : 1.0) * w + (i / 2000 % 2 == 0 ? 0.0 : 5.0); }},
      {"quiet and shaken, too coarse for the quiet",
       [](std::size_t i, double w) { return std::round((i / 2000 % 2 == 0 ? 0.2 : 20.0) * w); }, true},
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
      {"few pulses", [](std::size_t i, double) { return i % 7 == 3 ? 1.0 : 0.0; }, true},
      {"random pulses", [](std::size_t, double w) { return w > 1.5 ? 1.0 : 0.0; }, true},
      {"truncated rate", [](std::size_t i, double w) { return std::floor(2.0 * w + 1e-4 * static_cast<double>(i)); }},
  };
  return all;
}

TEST(ChecksStaySilent, OnCleanSignals) {
  for (const Clean& clean : clean_signals())
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      const auto noise = white(30'000, 100 + seed);
      const auto values = series(30'000, [&](std::size_t i) { return clean.value(i, noise[i]); });
      Findings findings = run_checks(recording({channel("output", "deg/s", values)}), nullptr);
      const auto steps = std::erase_if(findings, [](const Finding& one) { return one.code == "steps_exceed_noise"; });
      EXPECT_EQ(steps > 0, clean.coarse) << clean.what << ", seed " << seed;
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
