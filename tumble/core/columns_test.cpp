#include "tumble/core/columns.hpp"

#include <gtest/gtest.h>

namespace tumble {
namespace {

struct Stay {
  std::string label;
  int run;
  double rate;  ///< [rad/s]
};

const std::vector<Stay> segments{{"north", 1, 2.0}, {"south", 2, -1.0}};

TEST(Columns, HeadingUnitAndCellStandTogether) {
  const Table table = tabulate("segments", "what was done", segments,
                               {{"label", &Stay::label},
                                {"run", &Stay::run},
                                {"rate", "deg/s", &Stay::rate},
                                {"sense", [](const Stay& s) { return s.rate < 0.0 ? "back" : "forth"; }}});
  EXPECT_EQ(table.name, "segments");
  EXPECT_EQ(table.caption, "what was done");
  EXPECT_FALSE(table.for_programs);
  ASSERT_EQ(table.columns.size(), 4u);
  EXPECT_EQ(table.columns[0].unit, Unit());
  EXPECT_EQ(table.columns[2].name, "rate");
  EXPECT_EQ(table.columns[2].unit, Unit::parse("deg/s"));
  const std::vector<std::vector<Table::Cell>> expected{{"north", 1.0, 2.0, "forth"}, {"south", 2.0, -1.0, "back"}};
  EXPECT_EQ(table.rows, expected);
}

TEST(Columns, TableWithoutRowsKeepsItsHeadings) {
  const Table table = tabulate("segments", "", std::vector<Stay>(), {{"label", &Stay::label}});
  ASSERT_EQ(table.columns.size(), 1u);
  EXPECT_EQ(table.columns[0].name, "label");
  EXPECT_TRUE(table.rows.empty());
}

TEST(Columns, RowsMayBePointersOrNumbers) {
  const std::vector<const Stay*> last{&segments[1]};
  const Table table = for_programs(tabulate("", "", last, {{"label", &Stay::label}}));
  EXPECT_EQ(table.rows.at(0).at(0), Table::Cell("south"));
  EXPECT_TRUE(table.for_programs);
  const Table counted = tabulate("", "", 3, {{"number", [](std::size_t i) { return i + 1; }}});
  ASSERT_EQ(counted.rows.size(), 3u);
  EXPECT_EQ(counted.rows[2].at(0), Table::Cell(3.0));
}

TEST(Columns, CellMayBeANumberInOneRowAndATextInAnother) {
  const auto rate = [](const Stay& s) { return s.rate > 0.0 ? Table::Cell(s.rate) : Table::Cell("-"); };
  const Table table = tabulate("", "", segments, {{"rate", rate}});
  EXPECT_EQ(table.rows.at(0).at(0), Table::Cell(2.0));
  EXPECT_EQ(table.rows.at(1).at(0), Table::Cell("-"));
}

TEST(Columns, PointOfACurveHasItsBandWithIt) {
  Curve curve;
  add_point(curve, 1.0, 2.0, 0.5);
  add_point(curve, 2.0, 3.0, 1.0, 7.0);
  EXPECT_EQ(curve.x.values, (std::vector{1.0, 2.0}));
  EXPECT_EQ(curve.y.values, (std::vector{2.0, 3.0}));
  EXPECT_EQ(curve.lower, (std::vector{1.5, 1.0}));
  EXPECT_EQ(curve.upper, (std::vector{2.5, 7.0}));
}

}  // namespace
}  // namespace tumble
