#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "tumble/core/marks.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

/// Files in a folder of the test's own.
class Gather : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() / (std::string("gather_") + test->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }

  /// Four seconds of gyro and temperature from `start` on.
  std::string recording(const std::string& name, int start = 0) const {
    std::string text = "time[s],gyro[deg/h],temperature[degC],spare[V]\n";
    for (int i = 0; i < 4; ++i) text += std::to_string(start + i) + ",1,20,0\n";
    return write(name, text);
  }

  Plan plan(std::vector<RecordingEntry> entries,
            std::map<std::string, std::vector<ChannelChoice>> channels = {}) const {
    Plan plan;
    plan.file = "plan.toml";
    plan.method = "fog_thermal_bias";
    plan.recordings = std::move(entries);
    plan.channels = std::move(channels);
    plan.schedule = {{"soak", 1.0, 1, {}}, {"ramp", 2.0, 1, {}}, {"soak", 1.0, 2, {}}};
    return plan;
  }

  Problems problems(const Plan& plan, Error::Kind kind) const {
    const Refused refused = refusal_of([&] { gather(plan, {}, {}); });
    EXPECT_TRUE(refused.empty() || refuses(kind, Asked{}, refused));
    return refused.problems;
  }

  std::filesystem::path folder_;
};

TEST_F(Gather, WhatIsSaidOfReadingMustFitAFile) {
  Plan given = plan({{recording("a.csv"), "", 1}});
  given.reading = read_options({{"rate", "7 Hz"}, {"unit.gyr", "deg/h"}});
  const auto said = problems(given, Error::Kind::bad_input);
  ASSERT_EQ(said.size(), 2u);
  EXPECT_TRUE(is_problem(said[0], {.values = {"gyr", "gyr", "gyro"}}));
  EXPECT_TRUE(is_problem(said[1], {.values = {"1", "7"}}));
  given.reading = read_options({{"rate", "1 Hz"}, {"unit.spare", "V"}});  // of a column that no role needs
  EXPECT_TRUE(problems(given, Error::Kind::bad_input).empty());
}

// The file goes on for a minute after the last segment of the plan: what the instrument felt there nobody states.
TEST_F(Gather, TheLastSegmentEndsAsTheScheduleSays) {
  const Evidence evidence = gather(plan({{recording("a.csv"), "", 1}}), {}, {});
  const auto& marks = evidence.recordings[0].marks;
  ASSERT_EQ(marks.size(), 2u);
  EXPECT_EQ(end_of_mark(evidence.recordings[0], 0), 1.0);
  EXPECT_EQ(end_of_mark(evidence.recordings[0], 1), 3.0);  // the samples reach to 4 s
}

TEST_F(Gather, ALabelOfSeveralLengthsDoesNotSayWhenItEnds) {
  Plan uneven = plan({{recording("a.csv"), "soak", 1}});
  uneven.schedule[2].duration = 2.0;
  EXPECT_TRUE(std::isinf(end_of_mark(gather(uneven, {}, {}).recordings[0], 0)));
}

using Marks = std::vector<std::tuple<std::string, double, int>>;

Marks marks_of(const Recording& recording) {
  Marks marks;
  for (const auto& mark : recording.marks) marks.emplace_back(mark.label, mark.begin, mark.run);
  return marks;
}

TEST_F(Gather, MarksTheWholeScheduleFromTheFirstStamp) {
  const auto evidence = gather(plan({{recording("a.csv", 100), "", 0}}), {}, {});
  EXPECT_EQ(marks_of(evidence.recordings[0]), (Marks{{"soak", 100, 1}, {"ramp", 101, 1}, {"soak", 103, 2}}));
}

TEST_F(Gather, MarksARecordingByThePlanItBrings) {
  auto other = std::make_shared<Plan>();
  other->schedule = {{"spin", 2.0, 1, {}}, {"rest", 2.0, 1, {}}};
  const auto evidence =
      gather(plan({{recording("a.csv"), "", 0, nullptr}, {recording("b.csv", 50), "", 0, other}}), {}, {});
  EXPECT_EQ(marks_of(evidence.recordings[0]).size(), 3u);
  EXPECT_EQ(marks_of(evidence.recordings[1]), (Marks{{"spin", 50, 1}, {"rest", 52, 1}}));
  EXPECT_EQ(&plan_of(evidence, 0), &evidence.plan);
  EXPECT_EQ(&plan_of(evidence, 1), other.get());
}

TEST_F(Gather, MarksOneRunOrOneSegmentOfAFile) {
  const auto first = recording("a.csv", 5), second = recording("c.csv", 6), third = recording("d.csv", 7);
  const auto evidence =
      gather(plan({{first, "", 2}, {second, "ramp", 0}, {third, "ramp", 7}}), {recording("b.csv")}, {});
  ASSERT_EQ(evidence.recordings.size(), 4u);
  EXPECT_EQ(marks_of(evidence.recordings[0]), (Marks{{"soak", 5, 2}}));
  EXPECT_EQ(marks_of(evidence.recordings[1]), (Marks{{"ramp", 6, 1}}));
  EXPECT_EQ(marks_of(evidence.recordings[2]), (Marks{{"ramp", 7, 7}}));
  EXPECT_EQ(evidence.recordings[3].marks.size(), 3u);  // the command line's file comes last
}

TEST_F(Gather, RefusesTheSameBytesTwice) {
  const auto file = recording("a.csv");
  EXPECT_EQ(problems(plan({{file, "", 1}, {file, "", 2}}), Error::Kind::bad_data).size(), 1u);
}

TEST_F(Gather, ReadsOnlyTheChannelsOfTheRoles) {
  const auto evidence = gather(plan({{recording("a.csv"), "", 0}}), {}, {});
  EXPECT_EQ(evidence.recordings[0].channels.size(), 2u);
  EXPECT_EQ(find_channel(evidence.recordings[0], "spare"), nullptr);
}

TEST_F(Gather, NamesEveryMissingColumnAndWrongUnitInEveryFile) {
  const auto wrong = write("wrong.csv", "time[s],gyr[deg/h],temperature[V]\n0,1,2\n1,1,2\n");
  const auto found = problems(plan({{recording("a.csv"), "", 0}, {wrong, "", 0}}), Error::Kind::bad_data);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_TRUE(is_problem(found[0], {.values = {"gyro", "gyro", "gyr", "gyr, temperature"}, .file = wrong}));
  EXPECT_TRUE(is_problem(found[1], {.values = {"temperature", "V"}, .file = wrong}));
}

TEST_F(Gather, RefusesASecondUnit) {
  const auto file = recording("a.csv");
  const std::vector<RecordingEntry> entries{{file, "", 0}};
  EXPECT_EQ(problems(plan(entries, {{"gyro", {{"gyro", Unit::parse("deg/s")}}}}), Error::Kind::bad_data).size(), 1u);
  auto given = plan(entries);
  given.reading = read_options({{"unit.gyro", "deg/s"}});
  EXPECT_EQ(problems(given, Error::Kind::bad_data).size(), 1u);
  given.reading = read_options({{"unit.gyro", "arcsec/s"}});  // the same unit
  EXPECT_EQ(problems(given, Error::Kind::bad_data).size(), 0u);
}

TEST_F(Gather, TakesUnitAndRateFromThePlanWhereTheFileHasNone) {
  const auto file = write("bare.csv", "gyro,temperature\n1,20\n2,20\n");
  auto bare = plan({{file, "", 0}}, {{"gyro", {{"gyro", Unit::parse("deg/h")}}},
                                     {"temperature", {{"temperature", Unit::parse("degC")}}}});
  bare.sample_rate = 2.0;
  const auto evidence = gather(bare, {}, {});
  const auto& gyro = evidence.recordings[0].channels[0];
  EXPECT_EQ(gyro.unit.text(), "deg/h");
  EXPECT_DOUBLE_EQ(gyro.values[1], si(2, "deg/h"));
  EXPECT_EQ(gyro.time(1), 0.5);
}

TEST_F(Gather, TakesColumnsAndLabelsFromTheEntryOrTheCommandLine) {
  const auto file = write("bare.log", "0 1 20 up\n1 2 20 up\n2 3 20 down\n");
  RecordingEntry entry{file, "", 0};
  entry.columns = {"time[s]", "gyro[deg/h]", "temperature[degC]", "part"};
  entry.segment_column = "part";
  const auto evidence = gather(plan({entry}), {}, {});
  ASSERT_EQ(evidence.recordings[0].marks.size(), 2u);
  EXPECT_EQ(evidence.recordings[0].marks[1].label, "down");
  auto given = plan({entry});
  given.reading = read_options({{"columns", "time[s], gyro[deg/s],temperature[degC],part"}});
  const auto other = gather(given, {}, {});
  EXPECT_DOUBLE_EQ(other.recordings[0].channels[0].values[0], si(1, "deg/s"));
}

TEST_F(Gather, SaysThatThereIsNoRecordingOrNoMethod) {
  EXPECT_EQ(problems(plan({}), Error::Kind::bad_input).size(), 1u);
  auto nothing = plan({{recording("a.csv"), "", 0}});
  nothing.method.clear();
  EXPECT_EQ(problems(nothing, Error::Kind::bad_input).size(), 1u);
}

TEST_F(Gather, NamesEveryFileThatCannotBeRead) {
  const auto none = (folder_ / "none.csv").string(), empty = write("empty.csv", "");
  EXPECT_EQ(problems(plan({{none, "", 0}, {empty, "", 0}}), Error::Kind::bad_file).size(), 2u);
}

TEST_F(Gather, InspectsWholeAndInBlocksAlike) {
  const auto file = recording("a.csv");
  const auto whole = inspect(file, {}, {});
  const auto streamed = inspect(file, {}, {}, 0);
  ASSERT_EQ(whole.channels.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(whole.channels[i].samples, 4u);
    EXPECT_EQ(whole.channels[i].mean, streamed.channels[i].mean);
    EXPECT_EQ(whole.channels[i].sd, streamed.channels[i].sd);
    EXPECT_EQ(whole.channels[i].last, streamed.channels[i].last);
  }
  EXPECT_EQ(whole.channels[0].rate(), 1.0);
}

}  // namespace
}  // namespace tumble
