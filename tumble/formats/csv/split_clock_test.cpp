// Clocks whose numbers stand in columns of their own.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tumble/formats/testing/text_table.hpp"

namespace tumble {
namespace {

struct CsvSplitClock : TextTable {
  /// Rows at 10 Hz from 23:59:59.5 on: the second starts again, the minute, the hour, and what `date` writes of the
  /// day.
  std::string table(const std::string& header, const std::vector<std::string>& dates,
                    const char* second = "{},{},{}.{}") {
    std::string text = header + "\n";
    for (int k = 0; k < 10; ++k) {
      const int tenths = 23 * 36000 + 59 * 600 + 595 + k, of_day = tenths % 864000;
      text += dates.empty() ? "" : dates[tenths / 864000] + ",";
      text += fmt::format(fmt::runtime(second), of_day / 36000, of_day / 600 % 60, of_day / 10 % 60, of_day % 10);
      text += fmt::format(",{}\n", k);
    }
    return text;
  }
  void expect_even(const std::string& text, const std::string& begin) {
    const Recording recording = read(text);
    ASSERT_EQ(recording.channels.size(), 1u) << text;
    EXPECT_EQ(recording.channels[0].values.back(), 9.0);
    EXPECT_EQ(recording.channels[0].timeline.rate, 10.0) << text;
    EXPECT_EQ(recording.channels[0].timeline.start, 0.0) << text;
    const auto start = recording.meta.find("clock_start");
    EXPECT_EQ(start == recording.meta.end() ? "" : start->second, begin) << text;
  }
};

std::string message_of(const Refused& refused) {
  std::string all;
  for (const Problem& problem : refused.problems) all += problem.text() + "\n";
  return all;
}

TEST_F(CsvSplitClock, HourMinuteAndSecondPassMidnight) {
  for (const char* header : {"hour,minute,second,a[1]", "hh,mm,ss,a[1]", "HH,MM,SS,a[1]", "h,m,s,a[1]",
                             "Stunde,Minute,Sekunde,a[1]", "时,分,秒,a[1]", "utc_hour,utc_min,utc_sec,a[1]",
                             "hour[h],minute[min],second[s],a[1]", "time.hour,time.minute,time.second,a[1]"})
    expect_even(table(header, {}), "");
  const Recording recording = read(table("hour,minute,second,a[1]", {}));
  expect_holds(said(recording.findings, "clock_recognised"), {"'hour', 'minute' and 'second'"});
  EXPECT_NE(said(recording.findings, "clock_past_midnight"), "");
  std::string longer = "hour,minute,second,a[1]\n";
  for (int k = 0; k < 5000; ++k) {
    const int second = (23 * 3600 + 3000 + k) % 86400;
    longer += fmt::format("{},{},{},{}\n", second / 3600, second / 60 % 60, second % 60, k);
  }
  expect_streams_the_same(file(longer), options, 1000);
}

TEST_F(CsvSplitClock, FractionsMayHaveColumnsOfTheirOwn) {
  expect_even(table("hour,min,sec,ms,a[1]", {}, "{},{},{},{}00"), "");
  expect_even(table("hour,min,sec,ms,us,a[1]", {}, "{},{},{},{}00,0"), "");
  expect_even(table("hour,min,sec,usec,a[1]", {}, "{},{},{},{}00000"), "");
  expect_even(table("hour,min,sec,nanosec,a[1]", {}, "{},{},{},{}00000000"), "");
}

TEST_F(CsvSplitClock, TheDateMayStandInColumnsToo) {
  const std::string begin = "2024-02-29T23:59:59.5";
  expect_even(table("year,month,day,hour,minute,second,a[1]", {"2024,2,29", "2024,3,1"}), begin);
  expect_even(table("yyyy,mm,dd,hh,mm,ss,a[1]", {"2024,02,29", "2024,03,01"}), begin);
  expect_even(table("YY,MM,DD,HH,MM,SS,a[1]", {"24,02,29", "24,03,01"}), begin);
  expect_even(table("date,hour,minute,second,a[1]", {"2024-02-29", "2024-03-01"}), begin);
  expect_even(table("year,month,day,time,a[1]", {"2024,2,29", "2024,3,1"}, "{:02}:{:02}:{:02}.{}"), begin);
  expect_even(table("Datum,Uhrzeit,a[1]", {"29.02.2024", "01.03.2024"}, "{:02}:{:02}:{:02}.{}"), begin);
}

TEST_F(CsvSplitClock, TheDayOfTheYearIsCounted) {
  expect_even(table("year,doy,hour,minute,second,a[1]", {"2024,60", "2024,61"}), "2024-02-29T23:59:59.5");
  expect_even(table("year,doy,hour,minute,second,a[1]", {"2024,366", "2025,1"}), "2024-12-31T23:59:59.5");
  expect_even(table("day_of_year,hh,mm,ss,a[1]", {"60", "61"}), "");
  for (const char* last : {"365", "366"}) expect_even(table("doy,hh,mm,ss,a[1]", {last, "1"}), "");
  EXPECT_EQ(read("year,doy,sod,a[1]\n2026,1,0.25,1\n2026,1,0.50,2\n2026,1,0.75,3\n").channels.at(0).timeline.rate, 4.0);
}

TEST_F(CsvSplitClock, HoursSinceTheStartMayBeMany) {
  const Recording recording = read("hour,min,sec,a[1]\n99,59,59,1\n100,0,0,2\n100,0,1,3\n");
  EXPECT_EQ(recording.channels.at(0).timeline.rate, 1.0);
}

TEST_F(CsvSplitClock, TheUserMayNameIt) {
  options.time = "minute";
  EXPECT_EQ(
      read("time[s],hour,minute,second,a[1]\n0,9,59,59.5,1\n1,10,0,0,2\n2,10,0,0.5,3\n").channels.at(0).timeline.rate,
      2.0);
  options = {};
  options.columns = {"hour", "minute", "second", "a[1]"};
  EXPECT_EQ(read("9,59,59.5,1\n10,0,0,2\n10,0,0.5,3\n").channels.at(0).timeline.rate, 2.0);
}

TEST_F(CsvSplitClock, WhatIsNoClockIsNotTakenForOne) {
  // time[s] is as it is written; the others are another clock.
  const Recording named = read("time[s],hour,minute,second,a[1]\n0,9,59,59.5,1\n1,10,0,0,2\n2,10,0,0.5,3\n");
  EXPECT_EQ(named.channels.at(0).timeline.rate, 1.0);
  expect_holds(said(named.findings, "columns_not_read"), {"'hour' (another clock)"});
  // A second of 75 and an hour of 9.5 belong to no clock.
  expect_holds(message_of(refusal("hour,minute,second,a[1]\n9,0,70,1\n9,0,75,2\n")), {"'hour', 'minute', 'second'"});
  expect_holds(message_of(refusal("hour,minute,second,a[1]\n9.5,0,0,1\n9.5,0,1,2\n")), {"'hour', 'minute', 'second'"});
}

TEST_F(CsvSplitClock, ADateThatDoesNotExistIsNamed) {
  expect_holds(message_of(refusal("year,month,day,hour,minute,second,a[1]\n2026,2,28,9,0,0,1\n2026,2,30,9,0,0,2\n")),
               {"2026-2-30", "the calendar does not have"});
  std::string rows = "hour,minute,second,a[1]\n";
  for (int k = 0; k < 400; ++k) rows += "9," + std::to_string(k / 60) + "," + std::to_string(k % 60) + ",1\n";
  expect_holds(message_of(refusal(rows + "9,61,0,1\n")), {"line 402, column 2 'minute': '61' is not a time"});
}

}  // namespace
}  // namespace tumble
