#include "tumble/tasks/streamed.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "tumble/core/testing/asserts.hpp"
#include "tumble/math/noise_model.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr std::uintmax_t everything = 1'000'000'000'000, nothing = 1;
constexpr double rate = 100.0;

/// A folder that vanishes with the test.
struct Folder {
  std::filesystem::path path = std::filesystem::temp_directory_path() / ("streamed_" + std::to_string(getpid()));
  Folder() { std::filesystem::create_directories(path); }
  ~Folder() { std::filesystem::remove_all(path); }
  std::string file(const std::string& name) const { return (path / name).string(); }
};

/// 300 000 samples of white noise and random walk on two axes: more than one block.
Recording noise() {
  Recording recording;
  for (const char* name : {"gyro.x", "gyro.y"}) {
    Channel channel{name, QuantityKind::angular_rate, Unit::parse("deg/h"), {5.0, rate, nullptr}, {}};
    channel.values.assign(300'000, si(15.0, "deg/h"));
    add_noise({.angle_random_walk = si(0.1, "deg/sqrt(h)"), .rate_random_walk = si(200.0, "deg/h/sqrt(h)")}, rate,
              RandomStream(3).split(name), channel.values);
    recording.channels.push_back(std::move(channel));
  }
  return recording;
}

/// 12 samples lost, which the stamps tell.
void lose_some(Recording& recording) {
  std::vector<double> stamps;
  for (std::size_t i = 0; i < recording.channels[0].values.size(); ++i)
    stamps.push_back(5.0 + static_cast<double>(i < 280'000 ? i : i + 12) / rate);
  const auto shared = std::make_shared<const std::vector<double>>(std::move(stamps));
  for (auto& channel : recording.channels) channel.timeline = {0.0, 0.0, shared};
}

Estimate found(const std::string& file, std::uintmax_t memory, const Sets& sets = {}) {
  return identify(plan_for_method("allan_noise", sets), {file}, memory, {});
}

const Curve* curve(const Estimate& estimate, const std::string& name) {
  for (const auto& one : estimate.curves)
    if (one.name == name) return &one;
  return nullptr;
}

bool says(const Findings& findings, const std::string& words) {
  return std::ranges::any_of(findings,
                             [&](const Finding& finding) { return finding.message.find(words) != std::string::npos; });
}

/// Sums in another order, and an optimum found to about 1e-8 of an uncertainty.
void expect_same_parameters(const Estimate& whole, const Estimate& streamed) {
  ASSERT_EQ(whole.parameters.size(), streamed.parameters.size());
  ASSERT_GE(whole.parameters.size(), 4u);
  for (std::size_t i = 0; i < whole.parameters.size(); ++i) {
    const double sd = std::sqrt(whole.covariance(i, i));
    EXPECT_EQ(whole.parameters[i].name, streamed.parameters[i].name);
    EXPECT_NEAR(whole.parameters[i].value, streamed.parameters[i].value, 1e-6 * sd);
    EXPECT_NEAR(sd, std::sqrt(streamed.covariance(i, i)), 1e-6 * sd);
  }
}

class StreamedIdentify : public testing::TestWithParam<const char*> {};

TEST_P(StreamedIdentify, GivesWhatTheWholeRecordingGives) {
  const Folder folder;
  const auto file = folder.file(GetParam());
  write_recording(noise(), file);
  const Estimate whole = found(file, everything), streamed = found(file, nothing);
  expect_same_parameters(whole, streamed);
  EXPECT_EQ(whole.provenance.inputs[0].sha256, streamed.provenance.inputs[0].sha256);
  EXPECT_EQ(whole.title, streamed.title);
  EXPECT_FALSE(has_finding(whole.findings, "processed_in_blocks"));
  EXPECT_TRUE(has_finding(streamed.findings, "processed_in_blocks"));
  // Up to 1024 samples all terms are summed; beyond, the deviation is another estimate of the same (0.1 % of its
  // variance more): here within a tenth of the band.
  const Curve *a = curve(whole, "gyro.x allan_deviation"), *b = curve(streamed, "gyro.x allan_deviation");
  ASSERT_TRUE(a && b);
  std::size_t exact = 0;
  for (std::size_t i = 0; i < a->x.values.size() && a->x.values[i] <= 1024 / rate; ++i, ++exact) {
    EXPECT_EQ(a->x.values[i], b->x.values[i]);
    EXPECT_NEAR(a->y.values[i], b->y.values[i], 1e-9 * a->y.values[i]);
  }
  EXPECT_EQ(exact, 28u);  // 7 below ten, then 10 a decade, and 1000
  EXPECT_NEAR(b->x.values.back(), a->x.values.back(), 0.3 * a->x.values.back());
}

TEST_P(StreamedIdentify, PutsLostSamplesIn) {
  const Folder folder;
  const auto file = folder.file(GetParam());
  auto recording = noise();
  lose_some(recording);
  write_recording(recording, file);
  const Estimate whole = found(file, everything), streamed = found(file, nothing);
  EXPECT_TRUE(has_finding(whole.findings, "gap", {{"lost", 12}}));
  EXPECT_TRUE(says(streamed.findings, "12 missing samples"));
  // The clock's rate comes from a line through all stamps, or from the first and the last: 1e-9 of it.
  ASSERT_EQ(whole.parameters.size(), streamed.parameters.size());
  for (std::size_t i = 0; i < whole.parameters.size(); ++i)
    EXPECT_NEAR(whole.parameters[i].value, streamed.parameters[i].value, 1e-7 * std::abs(whole.parameters[i].value));
}

INSTANTIATE_TEST_SUITE_P(formats, StreamedIdentify, testing::Values("noise.h5", "noise.csv"),
                         [](const auto& each) { return std::string(each.index == 0 ? "hdf5" : "csv"); });

std::vector<std::string> refused(const std::string& file, Error::Kind kind, const Sets& sets = {}) {
  try {
    found(file, nothing, sets);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind, kind) << error.what();
    return texts_of(error.problems);
  }
  return {};
}

TEST(StreamedRecording, SaysWhatNeedsAllSamplesAtOnce) {
  const Folder folder;
  const auto file = folder.file("noise.h5");
  auto recording = noise();
  write_recording(recording, file);
  EXPECT_EQ(refused(file, Error::Kind::bad_input, {{"estimator", "allan"}, {"timing", "stamps"}}).size(), 2u);
  recording.marks = {{"first", 5.0, 1}, {"second", 900.0, 2}};
  const auto runs = folder.file("runs.h5");
  write_recording(recording, runs);
  const auto problems = refused(runs, Error::Kind::unsupported);
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_NE(problems[0].find("2 power-ups"), std::string::npos) << problems[0];
}

TEST(StreamedRecording, RefusesABackwardClockAndNamesFileAndTime) {
  const Folder folder;
  const auto file = folder.file("backward.h5");
  auto recording = noise();
  lose_some(recording);
  auto stamps = *recording.channels[0].timeline.stamps;
  for (std::size_t i = 290'000; i < stamps.size(); ++i) stamps[i] -= 50.0;
  const auto shared = std::make_shared<const std::vector<double>>(std::move(stamps));
  for (auto& channel : recording.channels) channel.timeline.stamps = shared;
  write_recording(recording, file);
  const auto problems = refused(file, Error::Kind::bad_data);
  ASSERT_EQ(problems.size(), 2u);  // one a channel
  EXPECT_NE(problems[0].find("backward.h5"), std::string::npos) << problems[0];
  EXPECT_NE(problems[0].find("2905.11 s"), std::string::npos) << problems[0];
  EXPECT_NO_THROW(found(file, nothing, {{"rate", "100"}}));
}

TEST(StreamedRecording, FindsLinesAndMotion) {
  const Folder folder;
  const auto file = folder.file("disturbed.h5");
  auto recording = noise();
  for (std::size_t i = 0; i < recording.channels[0].values.size(); ++i)
    recording.channels[0].values[i] +=
        si(20.0, "deg/h") * std::sin(2.0 * 3.14159265358979 * 0.05 * static_cast<double>(i));
  for (std::size_t i = 90'000; i < 90'400; ++i) recording.channels[1].values[i] += si(10.0, "deg/s");
  write_recording(recording, file);
  const auto estimate = found(file, nothing);
  EXPECT_NE(std::ranges::find(estimate.findings, "lines_avoided", &Finding::code), estimate.findings.end());
  EXPECT_TRUE(says(estimate.findings, "motion"));
}

}  // namespace
}  // namespace tumble
