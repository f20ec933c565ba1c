// Text tables as loggers, laboratories and robots write them.
#include <gtest/gtest.h>

#include <cmath>

#include "tumble/formats/testing/text_table.hpp"

namespace tumble {
namespace {

struct CsvTexts : TextTable {};

TEST_F(CsvTexts, ATimeThatIsNotUnderstoodIsNamedAsSuch) {
  const std::string table = "time,gyro[deg/s]\n20-Okt-2026 09:00:00,1\n20-Okt-2026 09:00:01,2\n";
  EXPECT_TRUE(refuses(table, {.values = {"time", "20-Okt-2026 09:00:00"}}));
  EXPECT_FALSE(refuses(table, {.pattern = "without a unit"}));
  options.time = "-";
  options.rate = 1.0;
  EXPECT_EQ(read(table).channels.at(0).values.size(), 2u);
}

TEST_F(CsvTexts, TheClocksOfArduinoHaveTheirUnitInTheirNames) {
  const Recording log = read("millis,gyro[deg/s]\n100,1\n110,2\n120,3\n");
  ASSERT_EQ(log.channels.size(), 1u);
  EXPECT_DOUBLE_EQ(log.channels[0].timeline.rate, 100.0);
  EXPECT_DOUBLE_EQ(read("micros,gyro[deg/s]\n100,1\n200,2\n300,3\n").channels.at(0).timeline.rate, 1e4);
}

TEST_F(CsvTexts, MillisecondsMayHaveAColumnOfTheirOwn) {
  for (const char* table : {"date,time,ms,gyro[deg/s]\n2024-03-05,12:00:59,980,1\n2024-03-05,12:00:59,990,2\n"
                            "2024-03-05,12:01:00,0,3\n",
                            "Date Time,Milliseconds,gyro[deg/s]\n05.03.2024 12:00:59,980,1\n05.03.2024 12:00:59,990,2\n"
                            "05.03.2024 12:01:00,000,3\n"}) {
    const Recording recording = read(table);
    ASSERT_EQ(recording.channels.size(), 1u) << table;
    EXPECT_EQ(recording.channels[0].timeline.rate, 100.0) << table;
    EXPECT_EQ(recording.meta.at("clock_start"), "2024-03-05T12:00:59.98") << table;
  }
  const Recording fine = read("time,usec,gyro[deg/s]\n23:59:59,999900,1\n00:00:00,0,2\n00:00:00,100,3\n");
  EXPECT_DOUBLE_EQ(fine.channels.at(0).timeline.rate, 1e4);
  expect_holds(said(fine.findings, "clock_recognised"), {"'time', time of day, and 'usec' in us"});
  // A count since the start of the device passes the second; with a fraction in the time, ms means something else.
  std::string table = "time,ms,gyro[deg/s]\n";
  for (int k = 0; k < 9000; ++k) table += "12:00:0" + std::to_string(k / 1000) + "," + std::to_string(k / 2) + ",1\n";
  EXPECT_TRUE(refuses(table, {.values = {"1000"}, .channel = "ms", .column = 2}));
  EXPECT_TRUE(refuses("time,ms,gyro[deg/s]\n12:00:00.5,1,1\n12:00:01.5,2,1\n", {.values = {"ms", "ms", "[deg/h]"}}));
}

TEST_F(CsvTexts, MarksBetweenThousandsAreNoDecimalMarks) {
  const Asked decimal{.pattern = "decimal=comma"};
  EXPECT_TRUE(
      refuses_with("time[s];a[1];b[1]\n0;1,000.50;2.5\n1;1,001.50;2.5\n",
                   {{.values = {"2"}}, {.values = {"1,000.50"}, .line = 2}, {.values = {"1000.50", "1,000.50"}}}));
  EXPECT_FALSE(refuses("time[s];a[1];b[1]\n0;1,000.50;2.5\n", decimal));
  EXPECT_TRUE(refuses_with("time[s];a[1];b[1]\n0;1.000,50;2,5\n1;1.001,50;2,5\n",
                           {{.values = {"2"}}, {.values = {"1000,50", "1.000,50"}}}));
  EXPECT_TRUE(refuses_with("time[s];a[1];b[1]\n0;1,000;2.5\n", {{.values = {"1000", "1,000"}}, decimal}));
}

TEST_F(CsvTexts, CommasThatMaySeparateThousandsAreSaid) {
  const Recording open = read("time[s];a[1]\n0;1,000\n1;12,345\n2;13\n");
  EXPECT_EQ(open.channels.at(0).values, (std::vector{1.0, 12.345, 13.0}));
  expect_holds(said(open.findings, "decimal_comma_or_thousands"), {"1,000 is 1.000"});
  for (const char* decimal : {"time[s];a[1]\n0;1,000\n1;0,345\n", "time[s];a[1]\n0;1,000\n0,5;2,000\n"})
    EXPECT_EQ(said(read(decimal).findings, "decimal_comma_or_thousands"), "") << decimal;
  options.decimal = ',';
  EXPECT_EQ(said(read("time[s];a[1]\n0;1,000\n1;2,345\n").findings, "decimal_comma_or_thousands"), "");
}

std::string utf16(const std::string& text, bool little, bool mark) {
  std::string bytes = mark ? (little ? "\xff\xfe" : "\xfe\xff") : "";
  for (const char c : text) {
    EXPECT_LT(static_cast<unsigned char>(c), 0x80);
    bytes += little ? std::string{c, '\0'} : std::string{'\0', c};
  }
  return bytes;
}

const std::string german_rows =
    "20.11.2026 09:00:00,000;21,5;1,002451\r\n20.11.2026 09:00:00,100;21,5;-0,5\r\n20.11.2026 "
    "09:00:00,200;21,25;1e-3\r\n";

TEST_F(CsvTexts, AGermanLaboratoryInLatin1) {
  const auto recording = read(
      "Zeit;Temperatur;Beschl. X\r\n;\xb0"
      "C;g\r\n" +
      german_rows);
  ASSERT_EQ(recording.channels.size(), 2u);
  EXPECT_EQ(recording.channels[0].name, "Temperatur");
  EXPECT_EQ(recording.channels[0].unit.text(), "°C");
  EXPECT_EQ(recording.channels[1].name, "Beschl. X");
  EXPECT_EQ(recording.channels[1].values, (std::vector{Unit::parse("g").to_si(1.002451), Unit::parse("g").to_si(-0.5),
                                                       Unit::parse("g").to_si(1e-3)}));
  EXPECT_EQ(recording.channels[0].timeline.rate, 10.0);
  EXPECT_EQ(recording.channels[0].timeline.start, 0.0);
  EXPECT_EQ(recording.meta.at("clock_start"), "2026-11-20T09:00:00");
  expect_holds(said(recording.findings, "text_encoding"), {"Windows-1252", "--set encoding="});
  expect_holds(said(recording.findings, "units_row"), {"line 2"});
  expect_holds(said(recording.findings, "clock_recognised"), {"'Zeit'", "date and time"});
  EXPECT_NE(said(recording.findings, "decimal_comma"), "");
  EXPECT_FALSE(recording.recognised.empty());
}

TEST_F(CsvTexts, WithoutAHeaderTheDateMayBeTheTime) {
  options.columns = {"time", "t[degC]", "x[g]"};
  const auto recording = read(german_rows);
  EXPECT_EQ(recording.channels.size(), 2u);
  EXPECT_EQ(recording.channels[0].timeline.rate, 10.0);
}

// printf '时间;温度;加速度X\n;℃;g\n' | iconv -t GBK | xxd
TEST_F(CsvTexts, AChineseLaboratoryInGbk) {
  const auto recording = read(
      "\xca\xb1\xbc\xe4;\xce\xc2\xb6\xc8;\xbc\xd3\xcb\xd9\xb6\xc8X\r\n;\xa1\xe6;g\r\n"
      "2026-11-20 09:00:00.000;21,5;1,5\r\n2026-11-20 09:00:00.100;21,5;2,5\r\n");
  ASSERT_EQ(recording.channels.size(), 2u);
  EXPECT_EQ(recording.channels[0].name, "温度");
  EXPECT_EQ(recording.channels[0].unit.text(), "℃");
  EXPECT_EQ(recording.channels[1].name, "加速度X");
  EXPECT_EQ(recording.channels[0].values[0], Unit::parse("degC").to_si(21.5));
  expect_holds(said(recording.findings, "text_encoding"), {"GB18030"});
}

TEST_F(CsvTexts, TheEncodingMayBeSaid) {
  options.encoding = "gbk";
  EXPECT_EQ(read("time[s],\xce\xc2\xb6\xc8[1]\n0,1\n1,1\n").channels[0].name, "温度");
  options.encoding = "latin-1";
  EXPECT_EQ(read("time[s],\xce\xc2\xb6\xc8[1]\n0,1\n1,1\n").channels[0].name, "ÎÂ¶È");
  options.encoding = "klingon";
  EXPECT_TRUE(refuses("time[s],a[1]\n0,1\n1,1\n", {.values = {"klingon"}, .pattern = "gb18030"}));
}

TEST_F(CsvTexts, Utf16OfBothOrdersWithAndWithoutMark) {
  const std::string text = "time[s],a[1]\r\n0,1.5\r\n1,-2\r\n2,3\r\n";
  for (const bool little : {false, true})
    for (const bool mark : {false, true}) {
      const auto recording = read(utf16(text, little, mark));
      ASSERT_EQ(recording.channels.size(), 1u);
      EXPECT_EQ(recording.channels[0].values, (std::vector<double>{1.5, -2, 3}));
      EXPECT_EQ(said(recording.findings, "text_encoding").empty(), mark);
    }
}

TEST_F(CsvTexts, Utf16OverManyPieces) {
  std::string text = "time[s],a[1]\r\n";
  std::vector<double> expected;
  for (int i = 0; i < 40000; ++i) {
    text += std::to_string(i) + "," + std::to_string(i % 977) + "\r\n";
    expected.push_back(i % 977);
  }
  EXPECT_EQ(read(utf16(text, true, true)).channels[0].values, expected);
}

TEST_F(CsvTexts, LineEndsOfEveryKind) {
  for (const char* content : {"time[s],a[1]\n0,1\n1,2\n", "time[s],a[1]\r\n0,1\r\n1,2\r\n",
                              "time[s],a[1]\r\r\n0,1\r\r\n1,2\r\r\n", "time[s],a[1]\r0,1\r1,2\r"})
    EXPECT_EQ(read(content).channels[0].values, (std::vector<double>{1, 2})) << content;
  EXPECT_TRUE(refuses("time[s],a[1]\r0,1\n1,2\n", {.pattern = "CR alone"}));
}

TEST_F(CsvTexts, APreambleIsSkippedAndSaid) {
  const auto recording = read(
      "Device;Logger 7\nOperator;N. "
      "N.\nSamples;1000\n\nsep=;\nZeit;Rate;T\ns;deg/h;degC\n0;1,5;20\n0,5;2,5;20\n1;3;21\n");
  ASSERT_EQ(recording.channels.size(), 2u);
  EXPECT_EQ(recording.channels[0].name, "Rate");
  EXPECT_EQ(recording.channels[0].values[1], Unit::parse("deg/h").to_si(2.5));
  EXPECT_EQ(recording.channels[0].timeline.rate, 2.0);
  expect_holds(said(recording.findings, "lines_before_samples_skipped"), {"4 lines", "Device;Logger 7"});
}

TEST_F(CsvTexts, APreambleAsWideAsTheTable) {
  const auto recording = read("Operator;N. N.\nZeit;Rate\ns;deg/h\n0;1\n1;2\n2;3\n");
  ASSERT_EQ(recording.channels.size(), 1u);
  EXPECT_EQ(recording.channels[0].name, "Rate");
  expect_holds(said(recording.findings, "lines_before_samples_skipped"), {"1 line", "Operator"});
}

TEST_F(CsvTexts, LinesToSkipMayBeSaid) {
  options.skip = 2;
  const auto recording = read("1,2\nx,y\ntime[s],a[1]\n0,1\n1,2\n");
  EXPECT_EQ(recording.channels[0].values, (std::vector<double>{1, 2}));
  options.skip = 0;
  EXPECT_TRUE(refuses("1,2\nx,y\ntime[s],a[1]\n0,1\n1,2\n", {}));
}

TEST_F(CsvTexts, ProposesTheUnitsThatNamesEndIn) {
  const char* table = "time_s,ax_g,gyro_x_lsb,gx_dps,temp_C,acc_z\n0,1,2,3,4,9.8\n0.1,1,2,3,4,9.8\n";
  for (const char* unit : {"ax_g=g ", "gyro_x_lsb=LSB ", "gx_dps=deg/s ", "temp_C=degC ", "acc_z=m/s^2"})
    EXPECT_TRUE(refuses(table, {.part = std::string("unit.") + unit}));
}

// A Campbell data logger writes four lines before its samples.
TEST_F(CsvTexts, FourHeaderLines) {
  const std::string content =
      "\"TOA5\",\"CR1000\",\"7\",\"prog\"\n\"TIMESTAMP\",\"RECORD\",\"Batt\",\"Temp\"\n"
      "\"TS\",\"RN\",\"Volts\",\"degC\"\n\"\",\"\",\"Avg\",\"Smp\"\n"
      "\"2026-11-20 09:00:00\",0,12.5,20.1\n\"2026-11-20 09:00:01\",1,12.5,20.2\n";
  EXPECT_TRUE(refuses_with(content, {{.values = {"RECORD", "RN"}}, {.part = "--set unit.RECORD=1"}}));
  options.units = {{"RECORD", Unit::parse("1")}};
  const auto recording = read(content);
  ASSERT_EQ(recording.channels.size(), 3u);
  EXPECT_EQ(recording.channels[2].values[1], Unit::parse("degC").to_si(20.2));
  EXPECT_EQ(recording.channels[2].timeline.rate, 1.0);
  expect_holds(said(recording.findings, "lines_before_samples_skipped"), {"2 lines", "TOA5"});
}

TEST_F(CsvTexts, UnixTimeIsRecognisedByItsSize) {
  const std::pair<const char*, const char*> files[] = {
      {"stamp,a[1]\n1700000000.000,1\n1700000000.005,2\n1700000000.010,3\n", "Unix time in s"},
      {"stamp,a[1]\n1700000000000,1\n1700000000005,2\n1700000000010,3\n", "Unix time in ms"},
      {"stamp,a[1]\n1700000000000000,1\n1700000000005000,2\n1700000000010000,3\n", "Unix time in us"},
      {"stamp,a[1]\n1700000000000000000,1\n1700000000005000000,2\n1700000000010000000,3\n", "Unix time in ns"}};
  for (const auto& [content, how] : files) {
    const auto recording = read(content);
    EXPECT_EQ(recording.channels[0].timeline.rate, 200.0) << content;
    EXPECT_EQ(recording.channels[0].timeline.start, 0.0) << content;
    EXPECT_EQ(recording.meta.at("clock_start"), "2023-11-14T22:13:20Z") << content;
    expect_holds(said(recording.findings, "clock_recognised"), {"'stamp'", how});
  }
}

TEST_F(CsvTexts, SmallNumbersWithoutUnitAreNotGuessed) {
  EXPECT_TRUE(refuses_with("stamp,a[1]\n0.00,1\n0.01,2\n",
                           {{.values = {"stamp", "stamp", "[s]"}}, {.part = "--set unit.stamp=s"}}));
  options.units = {{"stamp", Unit::parse("s")}};
  EXPECT_EQ(read("stamp,a[1]\n0.00,1\n0.01,2\n").channels[0].timeline.rate, 100.0);
}

TEST_F(CsvTexts, SplitStampsOfRos) {
  const auto recording = read(
      "header.stamp.sec,header.stamp.nanosec,header.frame_id,angular_velocity.x,linear_acceleration.z,"
      "angular_velocity_covariance[0],angular_velocity_covariance[1]\n"
      "1700000000,999000000,imu_link,0.5,9.81,0,0\n1700000001,4000000,imu_link,0.25,9.5,0,0\n"
      "1700000001,9000000,imu_link,0.125,9.25,0,0\n");
  ASSERT_EQ(recording.channels.size(), 2u);
  EXPECT_EQ(recording.channels[0].name, "angular_velocity.x");
  EXPECT_EQ(recording.channels[0].unit.text(), "rad/s");
  EXPECT_EQ(recording.channels[1].unit.text(), "m/s^2");
  EXPECT_EQ(recording.channels[0].timeline.rate, 200.0);
  expect_holds(said(recording.findings, "clock_recognised"),
               {"'header.stamp.sec' in s and 'header.stamp.nanosec' in ns"});
  expect_holds(said(recording.findings, "units_by_convention"), {"'angular_velocity.x' in rad/s"});
  expect_holds(said(recording.findings, "columns_not_read"), {"'header.frame_id' (text)", "(covariance)"});
}

TEST_F(CsvTexts, TheStampOfTheSensorComesBeforeThatOfReceipt) {
  const auto recording = read(
      "%time,field.header.seq,field.header.stamp,field.angular_velocity.x\n"
      "1700000000123456789,0,1700000000000000000,0.5\n1700000000129000000,1,1700000000005000000,0.25\n");
  EXPECT_EQ(recording.channels.size(), 1u);
  EXPECT_EQ(recording.channels[0].timeline.rate, 200.0);
  expect_holds(said(recording.findings, "clock_recognised"), {"'field.header.stamp'"});
  expect_holds(said(recording.findings, "columns_not_read"),
               {"'%time' (another clock)", "'field.header.seq' (counter)"});
  options.time = "%time";
  EXPECT_NEAR(
      read("%time,stamp,a[1]\n1700000000000000000,1700000000000000000,1\n1700000000001000000,1700000000005000000,2\n")
          .channels[0]
          .timeline.rate,
      1000.0, 1e-9);
}

TEST_F(CsvTexts, TheColumnOfTheClockMayBeSaid) {
  options.time = "elapsed";
  EXPECT_EQ(read("elapsed[ms],time[s],a[1]\n0,0,1\n10,1,2\n20,2,3\n").channels[0].timeline.rate, 100.0);
  options.time = "elapse";
  EXPECT_TRUE(refuses("elapsed[ms],a[1]\n0,1\n10,2\n", {.values = {"elapse", "elapsed"}}));
  options.time = "-";
  options.rate = 7.0;
  EXPECT_EQ(read("time[s],a[1]\n0,1\n10,2\n").channels.size(), 2u);
}

TEST_F(CsvTexts, DatesOfManyKindsGiveOneClock) {
  for (const char* rows :
       {"2026-11-20T09:00:00.000Z,1\n2026-11-20T09:00:00.250Z,2\n", "2026-11-20 09:00:00,1\n2026-11-20 09:00:00.25,2\n",
        "2026/11/20 09:00:00.000,1\n2026/11/20 09:00:00.250,2\n",
        "20-Nov-2026 09:00:00.00,1\n20-Nov-2026 09:00:00.25,2\n",
        "11/20/2026 9:00:00.00 AM,1\n11/20/2026 9:00:00.25 AM,2\n",
        "20/11/2026 09:00:00:000,1\n20/11/2026 09:00:00:250,2\n",
        "2026-11-20T17:00:00.00+08:00,1\n2026-11-20T17:00:00.25+08:00,2\n",
        "2026年11月20日 09:00:00.00,1\n2026年11月20日 09:00:00.25,2\n"}) {
    const auto recording = read(std::string("stamp,a[1]\n") + rows);
    EXPECT_EQ(recording.channels[0].timeline.rate, 4.0) << rows;
    const std::string_view row(rows);
    const bool zoned = row.find("Z,") != row.npos || row.find("+08:00") != row.npos;
    EXPECT_EQ(recording.meta.at("clock_start"), zoned ? "2026-11-20T09:00:00Z" : "2026-11-20T09:00:00") << rows;
  }
}

TEST_F(CsvTexts, DateAndTimeOfDayMayStandInTwoColumns) {
  const auto recording =
      read("Datum;Uhrzeit;a [g]\n20.11.2026;23:59:59,900;1\n21.11.2026;00:00:00,000;2\n21.11.2026;00:00:00,100;3\n");
  EXPECT_EQ(recording.channels[0].timeline.rate, 10.0);
  EXPECT_EQ(recording.channels.size(), 1u);
}

TEST_F(CsvTexts, ATimeOfDayPassesMidnight) {
  const auto recording = read("Time,a[1]\n23:59:59.5,1\n00:00:00.0,2\n00:00:00.5,3\n");
  EXPECT_EQ(recording.channels[0].timeline.rate, 2.0);
  EXPECT_NE(said(recording.findings, "clock_past_midnight"), "");
}

TEST_F(CsvTexts, MonthOrDayFirstIsAsked) {
  const std::string rows = "date,a[1]\n03/04/2026 09:00:00,1\n03/04/2026 09:00:01,2\n";
  EXPECT_TRUE(refuses(rows, {.values = {"date", "03/04/2026 09:00:00"}, .pattern = "--set date=dmy"}));
  options.date = "mdy";
  EXPECT_EQ(read(rows).meta.at("clock_start"), "2026-03-04T09:00:00");
  options.date = "dmy";
  EXPECT_EQ(read(rows).meta.at("clock_start"), "2026-04-03T09:00:00");
  options.date = "";
  EXPECT_EQ(read("date,a[1]\n03/04/2026 09:00:00,1\n03/14/2026 09:00:01,2\n").meta.at("clock_start"),
            "2026-03-04T09:00:00");
}

TEST_F(CsvTexts, AStampThatIsDamagedIsNamed) {
  std::string rows = "stamp,a[1]\n";
  for (int i = 0; i < 8; ++i) rows += "2026-11-20T09:00:0" + std::to_string(i) + ",1\n";
  EXPECT_TRUE(refuses_with(rows + "2026-11-20T09:00:0x,2\n2026-02-30T09:00:02,3\n,4\n",
                           {{.channel = "stamp", .line = 10, .column = 1},
                            {.channel = "stamp", .line = 11, .column = 1},
                            {.pattern = "a row without its time", .line = 12}}));
}

TEST_F(CsvTexts, UnitsInTheWordsOfTheHeader) {
  const auto recording =
      read("\"Time (s)\",\"Gyroscope x (rad/s)\",T / °C,\"a (m/s^2)\",w [rad s^-1]\n0,1,20,2,3\n0.01,1,20,2,3\n");
  ASSERT_EQ(recording.channels.size(), 4u);
  EXPECT_EQ(recording.channels[0].name, "Gyroscope x");
  EXPECT_EQ(recording.channels[0].unit.text(), "rad/s");
  EXPECT_EQ(recording.channels[1].name, "T");
  EXPECT_EQ(recording.channels[1].values[0], 293.15);
  EXPECT_EQ(recording.channels[3].unit.dimension(), Unit::parse("rad/s").dimension());
  EXPECT_EQ(recording.channels[0].timeline.rate, 100.0);
  expect_holds(said(recording.findings, "units_in_words"), {"'Gyroscope x' in rad/s"});
}

TEST_F(CsvTexts, TheHeaderMayBeAComment) {
  const auto recording =
      read("#timestamp [ns],w_x [rad s^-1],a_x [m s^-2]\n1403636579758555392,0.5,9.81\n1403636579763555584,0.25,9.8\n");
  ASSERT_EQ(recording.channels.size(), 2u);
  EXPECT_EQ(recording.channels[0].name, "w_x");
  EXPECT_NE(said(recording.findings, "header_in_comment"), "");
  EXPECT_NEAR(recording.channels[0].timeline.rate, 1e3 / 5.000192, 0.01);  // stamps of 1.4e9 s have steps of 2.4e-7 s
}

TEST_F(CsvTexts, AColumnOfLabelsIsProposed) {
  const std::string content = "time[s],part,a[1]\n0,x_up,1\n1,x_up,2\n2,x_down,3\n";
  expect_holds(said(read(content).findings, "segment_column_proposed"), {"--set segment_column=part"});
  options.segment_column = "part";
  EXPECT_EQ(read(content).marks.size(), 2u);
}

TEST_F(CsvTexts, OptionsAreProposedAsOneCommand) {
  options.missing = "NA";
  const char* table = "stamp;gyro x;temp\n0;1;2\n1;2;3\n";
  for (const char* part :
       {"tumble inspect ", " --set missing=NA", " --set unit.stamp=s --set 'unit.gyro x=deg/s' --set unit.temp=degC"})
    EXPECT_TRUE(refuses(table, {.part = part})) << part;
}

TEST_F(CsvTexts, APlainTableHasNothingToBeRecognised) {
  const auto recording = read("time[s],a[1]\n0,1\n1,2\n");
  EXPECT_TRUE(recording.findings.empty());
  EXPECT_TRUE(recording.recognised.empty());
}

TEST_F(CsvTexts, StreamsSeeTheSameClock) {
  std::string content = "stamp,a[1]\n";
  for (int i = 0; i < 5000; ++i)
    content += "1700000" + std::to_string(100 + i / 1000) + "." + std::to_string(1000 + i % 1000).substr(1) + "," +
               std::to_string(i) + "\n";
  const auto whole = read(content);
  EXPECT_EQ(whole.channels[0].timeline.rate, 1000.0);
  std::size_t samples = 0;
  stream_recording(format_of(file(content)), file(content), options, 1000,
                   [&](const Recording& block) {
                     EXPECT_EQ(block.channels[0].timeline.rate, 1000.0);
                     EXPECT_EQ(block.channels[0].values.front(), static_cast<double>(samples));
                     EXPECT_EQ(block.meta.at("clock_start"), whole.meta.at("clock_start"));
                     samples += block.channels[0].values.size();
                   },
                   {});
  EXPECT_EQ(samples, 5000u);
}

TEST_F(CsvTexts, CutAnywhereItIsReadOrRefused) {
  const std::string whole = utf16(
      "Device;7\r\nStamp;a [g];part\r\n2026-11-20 09:00:00.0;1,5;up\r\n2026-11-20 09:00:00.1;2,5;up\r\n2026-11-20 "
      "09:00:00.2;2;down\r\n",
      true, true);
  EXPECT_EQ(read(whole).channels.at(0).values.size(), 3u);
  for (std::size_t size = 1; size < whole.size(); ++size) {
    const Refused refused = refusal(whole.substr(0, size));
    EXPECT_TRUE(refused.empty() || tumble::refuses(Error::Kind::bad_file, Asked{}, refused)) << size;
  }
}

}  // namespace
}  // namespace tumble
