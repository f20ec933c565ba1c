// Controllers that read no rate: it follows from positions.
#include <gtest/gtest.h>

#include <cmath>

#include "tumble/station/testing/executive_bench.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

using testing::bench_segment;
using testing::bench_station;
using testing::ExecutiveBench;

/// A table at 120 deg/s that is asked for its position every 0.1 s, and for its state every fifth time.
std::shared_ptr<const Course> turning_course(double tolerance) {
  Course course{
      .station = bench_station(),
      .schedule = {bench_segment("turns", 20.0, {{"table", {.kind = Motion::Kind::rate, .value = 120.0 * degree}}}),
                   bench_segment("stands", 5.0, {{"table", {.value = 30.0 * degree}}})}};
  course.station.axes[0].settle.rate = tolerance;
  course.units = {{"1", "A"}};
  return std::make_shared<const Course>(std::move(course));
}

TEST(ExecutiveRates, FollowFromPositionsWhereTheControllerReadsNone) {
  ExecutiveBench bench(turning_course(1e-6 * degree));
  bench.reads_rate = false;
  ASSERT_EQ(bench.run(200.0), RunEnding::complete);
  ASSERT_EQ(bench.recorded.size(), 2u);
  // a second of acceleration, a second in which the line forgets it, the hold time of a second, and what polls take
  EXPECT_LT(bench.recorded[0].begin, 4.5) << "a reply to `state` is no reading of the position";
}

TEST(ExecutiveRates, WeighTheResolutionOfAReadingOverASecond) {
  // 0.001 deg in 0.1 s would be 0.01 deg/s. The line through n = 11 readings q/2 off at most departs by
  // q/2 sum|t|/sum t^2 = 0.0005 3.0/1.1 deg/s at most.
  ExecutiveBench bench(turning_course(0.0014 * degree));
  bench.reads_rate = false;
  bench.resolution = 1e-3 * degree;
  ASSERT_EQ(bench.run(200.0), RunEnding::complete);
  for (const auto& row : bench.rows) EXPECT_NE(row.ending, RunRow::Ending::failed) << row.reason.text();
}

}  // namespace
}  // namespace tumble
