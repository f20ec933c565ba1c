#include "tumble/station/executive.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/station/testing/executive_bench.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {
namespace {

using testing::bench_segment;
using testing::bench_station;
using testing::BenchFault;
using testing::ExecutiveBench;
using Fault = BenchFault::Kind;

Motion hold(double degrees) { return {.kind = Motion::Kind::hold, .value = si(degrees, "deg")}; }
Motion turn(double degrees_per_second) {
  return {.kind = Motion::Kind::rate, .value = si(degrees_per_second, "deg/s")};
}
Motion warm(double celsius) { return {.kind = Motion::Kind::dwell, .value = si(celsius, "degC")}; }

/// Rest, two rates, rest; 10 s each.
Schedule table_schedule() {
  return {bench_segment("rest", 10.0, {{"table", hold(0.0)}}), bench_segment("forwards", 10.0, {{"table", turn(20.0)}}),
          bench_segment("backwards", 10.0, {{"table", turn(-20.0)}}),
          bench_segment("90 deg", 10.0, {{"table", hold(90.0)}})};
}

std::shared_ptr<const Course> course_of(Schedule schedule, Station station = bench_station()) {
  return std::make_shared<const Course>(Course{.station = std::move(station), .schedule = std::move(schedule)});
}

std::vector<RunRow> rows_of(const ExecutiveBench& bench, RunRow::Kind kind) {
  std::vector<RunRow> rows;
  for (const auto& row : bench.rows)
    if (row.kind == kind) rows.push_back(row);
  return rows;
}

std::size_t asks_of(const ExecutiveBench& bench, const std::string& verb) {
  return static_cast<std::size_t>(std::count_if(bench.asked.begin(), bench.asked.end(),
                                                [&](const auto& one) { return one.ask.request.verb == verb; }));
}

TEST(Executive, CarriesOutASchedule) {
  ExecutiveBench bench(course_of(table_schedule()));
  ASSERT_EQ(bench.run(1000.0), RunEnding::complete);
  EXPECT_TRUE(bench.faults_of_order.empty());
  ASSERT_EQ(bench.recorded.size(), 4u);
  for (const auto& one : bench.recorded) EXPECT_NEAR(one.end - one.begin, 10.0, 1e-9) << one.what.label;
  const auto ends = rows_of(bench, RunRow::Kind::segment_ends);
  ASSERT_EQ(ends.size(), 4u);
  EXPECT_EQ(ends[1].ending, "complete");
  EXPECT_NEAR(ends[1].achieved.at("table.rate"), si(20.0, "deg/s"), 1e-12);
  EXPECT_NEAR(bench.true_position("table"), si(90.0, "deg"), 1e-9);
  EXPECT_EQ(counted_attempts(bench.rows).size(), 4u);
}

}  // namespace
}  // namespace tumble
