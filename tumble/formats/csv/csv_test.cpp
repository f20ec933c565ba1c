#include <gtest/gtest.h>

#include <cmath>

#include "tumble/formats/testing/text_table.hpp"

namespace tumble {
namespace {

struct Csv : TextTable {};

TEST_F(Csv, NamesUnitsValuesAndClock) {
  const auto recording = read("time[ms],gyro.x[deg/h],T[degC]\n0,1.5,20.1\n10,,-5\n20,-2,1e1\n");
  ASSERT_EQ(recording.channels.size(), 2u);
  const Channel& gyro = recording.channels[0];
  EXPECT_EQ(gyro.name, "gyro.x");
  EXPECT_EQ(gyro.unit.text(), "deg/h");
  EXPECT_EQ(gyro.kind, QuantityKind::angular_rate);
  EXPECT_TRUE(gyro.timeline.uniform());
  EXPECT_EQ(gyro.timeline.rate, 100.0);
  EXPECT_EQ(gyro.values[0], gyro.unit.to_si(1.5));
  EXPECT_TRUE(std::isnan(gyro.values[1]));
  EXPECT_EQ(recording.channels[1].values[0], Unit::parse("degC").to_si(20.1));
  EXPECT_EQ(recording.channels[1].values[2], 283.15);
  EXPECT_EQ(sha256_of(recording.origin).size(), 64u);
}

TEST_F(Csv, ANameThatASpreadsheetWouldTakeForAFormulaIsText) {
  for (const std::string name : {"=cmd|'/C calc'!A0", "+1", "-x", "@SUM(A1)"}) {
    Recording recording;
    recording.channels.push_back({name, QuantityKind::other, Unit::parse("deg/h"), {0.0, 1.0, nullptr}, {1.0, 2.0}});
    const std::string file = folder.file("formula.csv");
    write_recording(recording, file);
    EXPECT_NE(read_text_file(file).find(",\" " + name), std::string::npos) << name;
    EXPECT_EQ(read_recording(file, {}, {}).channels.at(0).name, name);
  }
}

TEST_F(Csv, ChecksumIsThatOfTheBytes) {
  // printf 'time[s],a[1]\n0,1\n1,2\n' | sha256sum
  EXPECT_EQ(sha256_of(read("time[s],a[1]\n0,1\n1,2\n").origin),
            "9dd4744de885f89f617e08f5279c42f5f31e55ed707cc999d9c592051c376347");
}

TEST_F(Csv, EveryCommonLayoutGivesTheSameNumbers) {
  const auto expected = read("time[s],a[m/s^2],b[deg]\n0,1.5,2\n1,-3,4.25\n2,5,-6\n");
  for (const char* content :
       {"time[s];a[m/s^2];b[deg]\n0;1.5;2\n1;-3;4.25\n2;5;-6\n",                      // semicolons
        "time[s]\ta[m/s^2]\tb[deg]\n0\t1.5\t2\n1\t-3\t4.25\n2\t5\t-6",                // tabs, no last line break
        "time[s] a[m/s^2] b[deg]\n0 1.5 2\n 1  -3 4.25\n2 \t5   -6  \n",              // blanks
        "\xEF\xBB\xBFtime[s],a[m/s^2],b[deg]\r\n0,1.5,2\r\n1,-3,4.25\r\n2,5,-6\r\n",  // BOM, CR LF
        "\"time [s]\",\"a[m/s^2]\",\"b [deg]\"\n0,1.5,2\n\"1\",-3,4.25\n2,5,-6\n",    // quotes
        "# made by hand\n\n#\ntime[s],a[m/s^2],b[deg],\n0,1.5,2,\n# pause\n1,-3,4.25,\n\n2,5,-6,,\n",  // comments, ends
        "time[s], a[m/s^2], b[deg]\n0, 1.5, 2\n1 , -3 , 4.25 \n2,  +5, -6\n",                          // blanks around
        "time[s];a[m/s^2];b[deg]\n0;1,5;2\n1;-3;4,25\n2;5;-6\n"}) {                                    // decimal commas
    const auto recording = read(content);
    ASSERT_EQ(recording.channels.size(), 2u) << content;
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(recording.channels[i].name, expected.channels[i].name) << content;
      EXPECT_EQ(recording.channels[i].unit, expected.channels[i].unit) << content;
      EXPECT_EQ(recording.channels[i].values, expected.channels[i].values) << content;
      EXPECT_EQ(recording.channels[i].timeline.rate, 1.0) << content;
    }
  }
}

TEST_F(Csv, DecimalCommaAndPointDoNotMix) {
  std::string rows = "time[s];a[1]\n0;1,5\n1;2,5\n";
  for (int i = 2; i < 20000; ++i) rows += std::to_string(i) + ";0,5\n";
  EXPECT_TRUE(refuses(rows + "20000;1.5\n", {.values = {"1.5"}, .pattern = "decimal mark", .line = 20002}));
  EXPECT_TRUE(refuses("time[s];a[1]\n0;1,234,5\n", {.values = {"1,234,5"}, .channel = "a", .line = 2}));
}

// A date with points said nothing, and no comma was believed.
TEST_F(Csv, DatesDoNotHideTheDecimalComma) {
  const std::string text = "20.11.2026 09:00:00,000;21,5\n20.11.2026 09:00:00,100;-1,25e1\n";
  options.columns = {"-", "a[1]"};
  options.rate = 10.0;
  EXPECT_EQ(read(text).channels[0].values, (std::vector{21.5, -12.5}));
}

TEST_F(Csv, TheDecimalMarkMayBeSaid) {
  options.decimal = ',';
  EXPECT_EQ(read("time[s];a[1]\n0;1\n1;2\n2;2,5\n").channels[0].values, (std::vector{1.0, 2.0, 2.5}));
  EXPECT_TRUE(refuses("time[s],a[1]\n0,1\n1,2\n", {.pattern = "decimal=comma"}));
  options.decimal = '.';
  EXPECT_TRUE(refuses("time[s];a[1]\n0;1,5\n", {.values = {"1,5"}, .channel = "a", .line = 2}));
}

TEST_F(Csv, WithoutTimeTheRateMustBeGiven) {
  EXPECT_TRUE(refuses("a[1]\n1\n2\n", {.pattern = "no time column"}));
  options.rate = 50.0;
  const auto recording = read("a[1]\n1\n2\n");
  EXPECT_EQ(recording.channels[0].timeline.rate, 50.0);
  EXPECT_EQ(recording.channels[0].timeline.start, 0.0);
}

TEST_F(Csv, BlankLinesInOneColumnAreMissingSamplesButNotAtTheEnd) {
  options.rate = 1.0;
  const auto recording = read("a[1]\n1\n\n\n4\n\n\n");
  ASSERT_EQ(recording.channels[0].values.size(), 4u);
  EXPECT_TRUE(std::isnan(recording.channels[0].values[2]));
  EXPECT_EQ(recording.channels[0].values[3], 4.0);
}

TEST_F(Csv, UnevenStampsAreKeptAndShared) {
  const auto recording = read("time[us],a[1],b[1]\n0,1,1\n10,1,1\n15,1,1\n");
  const auto& timeline = recording.channels[0].timeline;
  ASSERT_FALSE(timeline.uniform());
  EXPECT_EQ(*timeline.stamps, (std::vector<double>{0.0, 10 * 1e-6, 15 * 1e-6}));
  EXPECT_EQ(timeline.stamps, recording.channels[1].timeline.stamps);
}

TEST_F(Csv, TimeIsCalledTimeOrT) {
  EXPECT_EQ(read("Time[s],a[1]\n0,1\n1,1\n").channels.size(), 1u);
  EXPECT_EQ(read("t[s],a[1]\n0,1\n1,1\n").channels.size(), 1u);
  options.rate = 1.0;
  EXPECT_EQ(read("t[degC],T[degC],TIME_2[s]\n0,1,1\n1,1,2\n").channels.size(), 3u);
}

TEST_F(Csv, OneRowIsARecording) {
  const auto recording = read("time[s],a[1]\n5,1\n");
  EXPECT_EQ(recording.channels[0].values.size(), 1u);
  EXPECT_EQ(recording.channels[0].time(0), 5.0);
}

TEST_F(Csv, NothingInTheFileIsSaid) {
  EXPECT_TRUE(refuses("", {.pattern = "is empty"}));
  EXPECT_TRUE(refuses("# only a comment\n", {.pattern = "no header"}));
  EXPECT_TRUE(refuses("time[s],a[1]\n", {.pattern = "no samples"}));
  EXPECT_TRUE(refuses("time[s]\n1\n", {.pattern = "no channel"}));
  EXPECT_TRUE(refuses("0,1.5\n1,2.5\n", {.pattern = "name[unit]"}));
}

TEST_F(Csv, ColumnsWithoutUnitAreRefusedByName) {
  EXPECT_TRUE(refuses("time[s],gyro,acc[g],fog\n0,1,2,3\n", {.values = {"gyro", "fog", "gyro", "[deg/s]"}}));
  options.units = {{"gyro", Unit::parse("deg/h")}, {"fog", Unit::parse("deg/s")}};
  EXPECT_EQ(read("time[s],gyro,acc[g],fog\n0,1,2,3\n").channels[2].unit.text(), "deg/s");
}

TEST_F(Csv, EveryProblemOfTheHeaderAtOnce) {
  EXPECT_TRUE(
      refuses_with("time[m],a[furlong],b,b,[g]\n0,1,2,3,4\n", {{.values = {"1", "time[m]"}},
                                                               {.values = {"2", "a[furlong]", "furlong"}},
                                                               {.values = {"b"}, .pattern = "twice"},
                                                               {.values = {"5", "[g]"}},
                                                               {.values = {"b", "b"}, .part = "without a unit"}}));
}

TEST_F(Csv, OnlyWhatIsWantedIsRead) {
  options.only = {"b"};
  const auto recording = read("time[s],status,b[1]\n0,ok,1\n1,\"not, ok\",2\n");
  ASSERT_EQ(recording.channels.size(), 1u);
  EXPECT_EQ(recording.channels[0].values, (std::vector<double>{1, 2}));
}

TEST_F(Csv, BadCellsAreListedWithTheirPlace) {
  std::string content = "time[s],a[1],b[1]\n0,1,2\n1,NaN,2\n2,1,abc\n3,1\n4,1,2,3\n,1,2\n6,inf,1e999\n";
  EXPECT_TRUE(refuses_with(content, {{.values = {"NaN"}, .channel = "a", .line = 3, .column = 2},
                                     {.values = {"abc"}, .channel = "b", .line = 4, .column = 3},
                                     {.values = {"2", "3"}, .line = 5},
                                     {.values = {"4", "3"}, .line = 6},
                                     {.channel = "time", .line = 7, .column = 1},
                                     {.values = {"inf"}, .channel = "a", .line = 8, .column = 2},
                                     {.values = {"1e999"}, .channel = "b", .line = 8, .column = 3},
                                     {.values = {"NaN"}, .pattern = "--set missing="}}));
  for (int i = 7; i < 50; ++i) content += std::to_string(i) + ",?,1\n";
  EXPECT_TRUE(refuses_with(content, {{.values = {"50"}}, {.values = {"40"}}}));
}

TEST_F(Csv, WithoutAHeaderTheColumnsMustBeGiven) {
  const std::string content = "  0.5e0  33108  -2\n  1.5e0  33096  -3\n";
  EXPECT_TRUE(refuses(content, {.values = {"3"}, .part = "0.5e0  33108", .pattern = "[[recording]] columns"}));
  options.columns = {"time[s]", "a[LSB]", "-"};
  const auto recording = read(content);
  ASSERT_EQ(recording.channels.size(), 1u);
  EXPECT_EQ(recording.channels[0].name, "a");
  EXPECT_EQ(recording.channels[0].values, (std::vector<double>{33108, 33096}));
  EXPECT_EQ(recording.channels[0].time(0), 0.5);
  options.columns = {"time[s]", "a[LSB]"};
  EXPECT_TRUE(refuses(content, {.values = {"3", "2"}}));
  options.columns = {"time[s]", "a", "a[LSB]"};
  EXPECT_TRUE(
      refuses_with(content, {{.values = {"a"}, .pattern = "twice"}, {.values = {"a"}, .part = "without a unit"}}));
}

TEST_F(Csv, TheFirstLineWithoutAHeaderMayLackASample) {
  options.columns = {"time[s]", "a[1]", "b[1]"};
  options.missing = "NaN";
  const auto recording = read("# any\n0,NaN,\n1,2,3\n");
  EXPECT_TRUE(std::isnan(recording.channels[0].values[0]));
  EXPECT_TRUE(std::isnan(recording.channels[1].values[0]));
  EXPECT_EQ(recording.channels[1].values[1], 3.0);
  EXPECT_TRUE(refuses("0,1,2\n1,2\n", {.values = {"2", "3"}, .line = 2}));
}

TEST_F(Csv, TheColumnsGivenStandInPlaceOfTheHeader) {
  options.columns = {"time[s]", "a[deg/h]", "-"};
  const auto recording = read("t,rate,spare\n0,1,2\n1,2,3\n");
  EXPECT_EQ(recording.channels[0].name, "a");
  EXPECT_EQ(recording.channels[0].values.size(), 2u);
  ASSERT_EQ(recording.findings.size(), 1u);
  expect_holds(recording.findings[0].message, {"replace the header", "t,rate,spare"});
  EXPECT_TRUE(refuses("t,rate[deg/s],spare\n0,1,2\n", {.values = {"2", "rate[deg/s]", "a[deg/h]"}}));
}

TEST_F(Csv, LabelsBecomeMarksWhereTheyChange) {
  options.segment_column = "part";
  const std::string content = "time[s],part,a[1]\n10,up,1\n11, up ,2\n12,\"down\",3\n14,,4\n15,up,5\n";
  const auto recording = read(content);
  EXPECT_EQ(recording.channels[0].values, (std::vector<double>{1, 2, 3, 4, 5}));
  ASSERT_EQ(recording.marks.size(), 4u);
  const std::vector<std::pair<std::string, double>> expected{{"up", 10}, {"down", 12}, {"", 14}, {"up", 15}};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(recording.marks[i].label, expected[i].first);
    EXPECT_EQ(recording.marks[i].begin, expected[i].second);
  }
  options.segment_column = "prt";
  EXPECT_TRUE(refuses(content, {.values = {"prt", "part", "time, part, a"}}));
}

TEST_F(Csv, LabelsOverManyPiecesAndInBlocksAreTheSame) {
  std::string content = "part,no,a\n";
  for (int i = 0; i < 60000; ++i) content += "s" + std::to_string(i / 7000 % 4) + "," + std::to_string(i) + ",1.25\n";
  options.segment_column = "part";
  options.rate = 204.8;
  options.units = {{"a", Unit::parse("LSB")}};
  options.only = {"a"};
  const auto whole = read(content);
  ASSERT_EQ(whole.marks.size(), 9u);
  for (std::size_t i = 0; i < whole.marks.size(); ++i) {
    EXPECT_EQ(whole.marks[i].label, "s" + std::to_string(i % 4));
    EXPECT_EQ(whole.marks[i].begin, static_cast<double>(7000 * i) / 204.8);
  }
  std::vector<Mark> first;
  format_of(file(content))
      .stream(file(content), options, 5000,
              [&](const Recording& block) {
                if (first.empty()) first = block.marks;
              },
              {});
  ASSERT_EQ(first.size(), whole.marks.size());
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first[i].begin, whole.marks[i].begin);
}

TEST_F(Csv, AMatlabFileIsNamed) {
  EXPECT_TRUE(refuses(std::string("MATLAB 5.0 MAT-file, Platform: GLNXA64") + '\0' + "\x01IM",
                      {.pattern = "is a MATLAB binary file"}));
}

TEST_F(Csv, AWordForAMissingSample) {
  options.missing = "nan";
  const auto recording = read("time[s],a[1]\n0,NaN\n1,2\n");
  EXPECT_TRUE(std::isnan(recording.channels[0].values[0]));
  EXPECT_EQ(recording.channels[0].values[1], 2.0);
}

/// The pass that finds the clock looks at no more of a line than the time.
TEST_F(Csv, StreamingSeesWhatReadingSees) {
  const auto streamed = [&](const std::string& content) {
    std::string seen;
    const auto path = file(content);
    format_of(path).stream(path, options, 2,
                           [&](const Recording& block) {
                             for (std::size_t i = 0; i < block.channels[0].values.size(); ++i)
                               seen += std::to_string(block.channels[0].time(i)) + " " +
                                       std::to_string(block.channels[0].values[i]) + "\n";
                           },
                           {});
    return seen;
  };
  for (const char* good :
       {"time[s],a[1],b[1]\n0,1,2\n1,,\n2,5,6\n", "a[1];time[s];b[1]\n1;0;\"2\"\n\n# note\n3;1;4\n5;2;6",
        "time[s] a[1]\r\n0 1\r\n1\t3\r\n2 5\r\n"}) {
    const auto whole = read(good);
    std::string seen;
    for (std::size_t i = 0; i < whole.channels[0].values.size(); ++i)
      seen += std::to_string(whole.channels[0].time(i)) + " " + std::to_string(whole.channels[0].values[i]) + "\n";
    EXPECT_EQ(streamed(good), seen);
  }
  for (const char* bad :
       {"time[s],a[1],b[1]\n0,1,2\n1,3\n2,5,6,7\n", "time[s],a[1]\n0,1\n1,x\n2,1\n", "time[s],a[1]\n0,1\n1y,1\n"})
    EXPECT_EQ(refusal_of([&] { streamed(bad); }).problems, refusal(bad).problems) << bad;
}

TEST_F(Csv, ManyPiecesGiveTheSameAsOne) {
  std::string content = "time[s],a[deg/h],b[g]\n";
  for (int i = 0; i < 60000; ++i)  // 1.7 MB: several pieces and batches
    content += std::to_string(i / 100.0) + "," + std::to_string(i * 0.37) +
               (i % 7 == 0 ? ",\n" : "," + std::to_string(-i) + "\n");
  const auto whole = read(content);
  ASSERT_EQ(whole.channels[0].values.size(), 60000u);
  EXPECT_EQ(whole.channels[0].timeline.rate, 100.0);
  for (int i = 0; i < 60000; i += 997) {
    EXPECT_EQ(whole.channels[0].values[i], whole.channels[0].unit.to_si(std::stod(std::to_string(i * 0.37))));
    EXPECT_EQ(std::isnan(whole.channels[1].values[i]), i % 7 == 0);
  }
}

TEST_F(Csv, AnnotationsThatCannotBeReadAreComments) {
  const auto recording =
      read("# marks: [{\"label\": 3}]\n# meta: {]\n# clock: {\"rate\": -1}\n# meta: " + std::string(100000, '[') +
           "\ntime[s],a[1]\n0,1\n1,1\n");
  EXPECT_TRUE(recording.marks.empty());
  EXPECT_TRUE(recording.meta.empty());
}

TEST_F(Csv, AClockCommentThatLiesIsNotBelieved) {
  const auto recording = read("# clock: {\"start\": 0, \"rate\": 7}\ntime[s],a[1]\n0,1\n1,1\n2,1\n");
  EXPECT_EQ(recording.channels[0].timeline.rate, 1.0);
  EXPECT_EQ(recording.findings.size(), 1u);
}

}  // namespace
}  // namespace tumble
