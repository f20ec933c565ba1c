#include "tumble/report/figure.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tumble/report/figure/ticks.hpp"
#include "tumble/report/names.hpp"
#include "tumble/report/testing/example_estimate.hpp"
#include "tumble/report/testing/text_parts.hpp"

namespace tumble {
namespace {

using figure::linear_ticks, figure::logarithmic_ticks;

/// Two curves of one figure in different units, and one of another dimension.
Estimate two_units() {
  Estimate e;
  Curve a;
  a.name = "a", a.figure = "f";
  a.x = {"t", Unit::parse("min"), {60.0, 120.0}};
  a.y = {"y", Unit::parse("deg/h"), {si(1.0, "deg/h"), si(2.0, "deg/h")}};
  Curve b = a, other = a;
  b.name = "b", b.y.unit = Unit::parse("deg/s");
  other.y = {"temperature", Unit::parse("degC"), {293.15, 303.15}};
  e.curves = {a, b, other};
  return e;
}

Figure plain_figure() {
  Figure figure;
  figure.name = "f";
  figure.x = {"time", Unit::parse("s"), false};
  figure.y = {"rate", Unit::parse("deg/h"), false};
  figure.series.push_back({"gyro", false, {0, 1, 2, 3, 4}, {1, 2, NAN, 3, 4}, {}, {}, ""});
  return figure;
}

TEST(Figures, CurvesOfAFigureStandTogetherInTheUnitOfTheFirst) {
  const auto figures = figures_of(two_units());
  ASSERT_EQ(figures.size(), 2u);  // another dimension needs axes of its own
  EXPECT_EQ(title_of(figures[0].x), "t [min]");
  EXPECT_EQ(title_of(figures[0].y), "y [deg/h]");
  EXPECT_EQ(figures[0].series[0].x, (std::vector{1.0, 2.0}));
  EXPECT_NEAR(figures[0].series[1].y[1], 2.0, 1e-15);
  EXPECT_EQ(figures[1].series[0].y, (std::vector{20.0, 30.0}));
}

TEST(Figures, LogarithmicAxesSayWhatTheyCannotShow) {
  Estimate e;
  e.curves = {{"a",
               "f",
               {"x", {}, {0.0, 1.0, 2.0, 3.0}},
               {"y", {}, {1.0, -1.0, 4.0, NAN}},
               {0.5, 0.5, -3.0, 1.0},
               {2.0, 2.0, 5.0, 2.0},
               "95 %",
               true,
               false}};
  const auto figure = figures_of(e).at(0);
  EXPECT_TRUE(std::isnan(figure.series[0].y[0]) && std::isnan(figure.series[0].y[1]));
  EXPECT_EQ(figure.series[0].y[2], 4.0);
  EXPECT_EQ(figure.series[0].lower, (std::vector{0.5, 0.5, 0.5, 1.0}));
  ASSERT_EQ(figure.notes.size(), 1u);
  EXPECT_TRUE(has(figure.notes[0], "“a” 2 values"));
}

TEST(Figures, ALogarithmicXAxisAloneHasNoPlaceForZeroEither) {
  Estimate e;
  e.curves.push_back(
      {"a", "f", {"x", {}, {0.0, 1.0, 2.0}}, {"y", {}, {1.0, -1.0, 4.0}}, {0, -2, 3}, {2, 0, 5}, "95 %"});
  e.curves[0].logarithmic_x = true;
  const auto figure = figures_of(e).at(0);
  EXPECT_TRUE(std::isnan(figure.series[0].x[0]));
  EXPECT_EQ(figure.series[0].y[1], -1.0);
  EXPECT_EQ(figure.series[0].lower[1], -2.0);
  EXPECT_FALSE(has(to_svg(figure), "inf"));
}

TEST(Figures, TheDescriptionForProgramsHasEveryPoint) {
  const auto json = nlohmann::json::parse(to_json(figures_of(two_units())));
  ASSERT_EQ(json.size(), 2u);
  EXPECT_EQ(json[0]["x"]["unit"], "min");
  EXPECT_EQ(json[0]["y"]["logarithmic"], false);
  EXPECT_EQ(json[0]["series"][0]["x"], nlohmann::json({1.0, 2.0}));
  EXPECT_EQ(json[0]["series"][1]["y"], nlohmann::json({1.0, 2.0}));
  EXPECT_EQ(json[0]["series"][1]["dashes"], "7 3");
  EXPECT_EQ(json[1]["y"]["name"], "temperature");
}

Table table_of_residuals() {
  Table table{
      "positions", "", {{"label", {}}, {"noise_sd", Unit::parse("ug")}, {"residual_gyro_x", Unit::parse("ug")}}, {}};
  table.rows = {{std::string("up"), si(2.0, "ug"), si(10.0, "ug")},
                {std::string("down"), si(3.0, "ug"), si(-20.0, "ug")}};
  return table;
}

TEST(Figures, AResultWithoutCurvesShowsTheResidualsOfItsTables) {
  Estimate e;
  e.tables = {table_of_residuals()};
  const auto figure = figures_of(e).at(0);
  EXPECT_EQ(figure.name, "residuals of the positions");
  EXPECT_EQ(title_of(figure.y), "residual [ug]");
  const auto& series = figure.series.at(0);
  EXPECT_EQ(series.x, (std::vector{1.0, 2.0}));
  EXPECT_NEAR(series.y[1], -20.0, 1e-12);
  EXPECT_NEAR(series.lower[1], -26.0, 1e-12);
  EXPECT_NEAR(series.upper[0], 14.0, 1e-12);
}

/// A grid of 3 x 2 cells of which one is missing, and two points beside it.
Estimate with_map() {
  const Table::Column temperature{"temperature", Unit::parse("degC")}, speed{"temperature_rate", Unit::parse("K/min")},
      drift{"drift", Unit::parse("deg/h")}, residual{"residual", Unit::parse("deg/h")};
  Table cells{"thermal_map", "by the coefficients", {temperature, speed, drift}, {}, true};
  for (const double r : {-1.0, 1.0})
    for (const double t : {0.0, 20.0, 40.0})
      if (t < 30.0 || r < 0.0) cells.rows.push_back({si(t, "degC"), si(r, "K/min"), si(t + 10.0 * r, "deg/h")});
  Table points{"thermal_points", "means", {temperature, speed, drift, residual}, {}, true};
  points.rows = {{si(5.0, "degC"), si(1.0, "K/min"), si(16.0, "deg/h"), si(1.0, "deg/h")},
                 {si(30.0, "degC"), si(-1.0, "K/min"), std::string("lost"), si(-2.0, "deg/h")}};
  Estimate e;
  e.tables = {cells, points};
  return e;
}

TEST(FigureMaps, CellsAndPointsOfOneQuantityAreOneFigure) {
  const auto figures = figures_of(with_map());
  ASSERT_EQ(figures.size(), 2u);
  const Figure& drift = figures[0];
  EXPECT_EQ(drift.name, "drift over temperature and temperature rate");
  EXPECT_EQ(title_of(*drift.z), "drift [deg/h]");
  ASSERT_TRUE(drift.map);
  const double edges[] = {-10.0, 10.0, 30.0, 50.0}, of_rows[] = {-2.0, 0.0, 2.0},
               values[] = {-10.0, 10.0, 30.0, 10.0, 30.0};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(drift.map->x[i], edges[i], 1e-9);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(drift.map->y[i], of_rows[i], 1e-12);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(drift.map->values[i], values[i], 1e-9);
  EXPECT_TRUE(std::isnan(drift.map->values[5])) << "hot and rising: not in the table";
  ASSERT_EQ(drift.series.size(), 1u);
  EXPECT_NEAR(drift.series[0].z[0], 16.0, 1e-12);
  EXPECT_TRUE(std::isnan(drift.series[0].z[1]));
  EXPECT_EQ(figures[1].name, "residual over temperature and temperature rate");
  EXPECT_FALSE(figures[1].map);
}

TEST(FigureMaps, OneRowOfCellsIsNotDrawn) {
  Estimate e = with_map();
  std::erase_if(e.tables[0].rows, [](const auto& row) { return std::get<double>(row[1]) > 0.0; });
  e.tables.pop_back();
  EXPECT_TRUE(figures_of(e).empty());
}

TEST(FigureMaps, TheDescriptionHasScaleCellsAndColouredPoints) {
  const auto json = nlohmann::json::parse(to_json(figures_of(with_map())));
  EXPECT_EQ(json[0]["map"]["values"].size(), 6u);
  EXPECT_EQ(json[0]["map"]["values"][5], nullptr);
  EXPECT_EQ(json[0]["series"][0]["z"], nlohmann::json({16.0, nullptr}));
  EXPECT_LE(json[0]["z"]["low"], -10.0);
  EXPECT_GE(json[0]["z"]["high"], 30.0);
  EXPECT_EQ(json[0]["z"]["colours"].size(), 32u);
  for (const auto& tick : json[0]["z"]["ticks"]) EXPECT_TRUE(tick["at"] >= 0.0 && tick["at"] <= 1.0);
  EXPECT_FALSE(json[1].contains("map"));
  EXPECT_FALSE(nlohmann::json::parse(to_json(figures_of(two_units())))[0].contains("z"));
}

TEST(FigureMaps, TheDrawingHasACellForEachNumberAndItsScale) {
  const auto figures = figures_of(with_map());
  for (const auto drawing : {Drawing::page, Drawing::phone}) {
    const auto svg = to_svg(figures[0], drawing);
    EXPECT_EQ(count_of(svg, "Z\" fill="), 3u + 32u);  // three colours of five cells, and the scale
    EXPECT_TRUE(has(svg, "drift [deg/h]") && has(svg, "drift as colours"));
    EXPECT_FALSE(has(svg, "nan") || has(svg, "inf"));
  }
  EXPECT_EQ(count_of(to_svg(figures[1]), "stroke-width=\"6\""), 2u);  // two points of two colours
}

TEST(FigureMaps, CsvHasARowForEachCellAndEachPoint) {
  EXPECT_EQ(to_csv(figures_of(with_map())[0]),
            "temperature[degC],temperature rate[K/min],drift[deg/h],temperature[degC],temperature "
            "rate[K/min],measured[deg/h]\n0,-1,-10,5,1,16\n20,-1,10,30,-1,\n40,-1,30,,,\n0,1,10,,,\n20,1,30,,,\n");
}

TEST(Figures, CurvesWithoutResidualsAreFollowedByThoseOfTheTables) {
  Estimate e = two_units();
  e.tables = {table_of_residuals()};
  EXPECT_EQ(figures_of(e).back().name, "residuals of the positions");
  e.curves[0].figure = "residuals of the averages";
  for (const auto& figure : figures_of(e)) EXPECT_NE(figure.name, "residuals of the positions") << "it has its own";
}

TEST(Figures, OfSeveralOutputsStandTogetherFirst) {
  Estimate e = two_units();
  e.curves.pop_back();
  e.curves[0].figure = "deviation x", e.curves[1].figure = "deviation y";
  const auto figures = figures_of(e);
  ASSERT_EQ(figures.size(), 3u);
  EXPECT_EQ(figures[0].name, "y, all together");
  ASSERT_EQ(figures[0].series.size(), 2u);
  EXPECT_EQ(title_of(figures[0].y), "y [deg/h]");
  EXPECT_NEAR(figures[0].series[1].y[1], 2.0, 1e-12);  // deg/s in its own figure, deg/h here
  EXPECT_EQ(title_of(figures[2].y), "y [deg/s]");
}

TEST(Figures, NamesAreWords) {
  EXPECT_EQ(readable_name("angle_random_walk"), "angle random walk");
  EXPECT_EQ(readable_name("gyro.x allan_deviation"), "gyro.x allan deviation");
  EXPECT_EQ(readable_name("gyro.x.angle_random_walk"), "gyro.x angle random walk");
  EXPECT_EQ(readable_name("gyro.x.bias"), "gyro.x bias");
  for (const char* symbol : {"gyro.x", "t.top", "K_1", "A1_0", "D_OO", "output less L_0", "", "_", "T_0"})
    EXPECT_EQ(readable_name(symbol), symbol);
}

TEST(Figures, CsvHasEveryNumberOnce) {
  Figure figure = plain_figure();
  figure.series.push_back(figure.series[0]);
  figure.series[1].name = "a, \"b\"";
  figure.series[1].lower = figure.series[1].upper = {0, 0.5, 1, 1, 1e-7};
  EXPECT_EQ(to_csv(figure),
            "time[s],gyro[deg/h],\"a, \"\"b\"\"[deg/h]\",\"a, \"\"b\"\" lower[deg/h]\",\"a, \"\"b\"\" upper[deg/h]\"\n"
            "0,1,1,0,0\n1,2,2,0.5,0.5\n2,,,1,1\n3,3,3,1,1\n4,4,4,1e-07,1e-07\n");
}

TEST(Figures, WithFewerPointsKeepTheirExtremes) {
  Figure figure = plain_figure();
  auto& series = figure.series[0];
  series.x.clear(), series.y.clear();
  for (int i = 0; i < 10000; ++i) series.x.push_back(i), series.y.push_back(i == 7777 ? 50.0 : i % 2);
  const auto fewer = with_fewer_points(figure, 500).series[0];
  EXPECT_LE(fewer.x.size(), 510u);
  EXPECT_EQ(std::ranges::max(fewer.y), 50.0);
  EXPECT_EQ(with_fewer_points(figure, 10000).series[0].x.size(), 10000u);
}

TEST(FigureSvg, ForAPhoneIsNarrow) {
  EXPECT_TRUE(has(to_svg(plain_figure(), Drawing::phone), "viewBox=\"0 0 390 "));
  EXPECT_TRUE(has(to_svg(plain_figure()), "viewBox=\"0 0 760 "));
}

TEST(FigureSvg, HasOneStrokeForEachPartBetweenGaps) {
  const auto svg = to_svg(plain_figure());
  const auto begin = svg.find("<svg width");  // the plot itself
  const auto plot = svg.substr(begin, svg.find("</svg>", begin) - begin);
  EXPECT_EQ(count_of(plot, "M"), 2u);
  EXPECT_EQ(count_of(plot, "L"), 2u);
  EXPECT_TRUE(has(svg, "rate [deg/h]") && has(svg, "time [s]") && has(svg, ">gyro<"));
}

TEST(FigureSvg, PointsHaveBarsAndLinesHaveBands) {
  Figure figure = plain_figure();
  auto& series = figure.series[0];
  series.lower = {0, 1, 1, 2, 3}, series.upper = {2, 3, 3, 4, 5};
  EXPECT_TRUE(has(to_svg(figure), "fill-opacity"));
  series.points = true;
  const auto svg = to_svg(figure);
  EXPECT_FALSE(has(svg, "fill-opacity"));
  EXPECT_EQ(count_of(svg, "h0"), 4u + 1u);  // points, and that of the legend
  EXPECT_TRUE(has(svg, "stroke-linecap=\"round\""));
}

TEST(FigureSvg, NamesStayText) {
  Figure figure = plain_figure();
  figure.name = figure.x.name = figure.y.name = figure.series[0].name = "</svg><script>\"'&";
  const auto svg = to_svg(figure);
  EXPECT_FALSE(has(svg, "<script"));
  EXPECT_EQ(count_of(svg, "</svg>"), 2u);
}

TEST(FigureSvg, WhatHasNoNumbersIsADrawingToo) {
  Figure figure = plain_figure();
  figure.series[0].y.assign(5, NAN);
  for (const bool logarithmic : {false, true}) {
    figure.x.logarithmic = figure.y.logarithmic = logarithmic;
    const auto svg = to_svg(figure);
    EXPECT_FALSE(has(svg, "nan") || has(svg, "inf"));
    EXPECT_TRUE(svg.ends_with("</svg>\n"));
  }
  figure.series.clear();
  EXPECT_TRUE(to_svg(figure).ends_with("</svg>\n"));
}

TEST(FigureSvg, NumbersBeyondWhatAnAxisHoldsHaveAPlace) {
  Figure figure = plain_figure();
  figure.series[0].y = {1.0, 1.7e308, -1.7e308, 5e-324, 2.0};
  figure.series[0].lower.assign(5, -1.7e308), figure.series[0].upper.assign(5, 1.7e308);
  for (const bool logarithmic : {false, true}) {
    figure.y.logarithmic = logarithmic;
    if (logarithmic) figure.series[0].y[2] = figure.series[0].lower[0] = 1e-310;
    const auto svg = to_svg(figure);
    EXPECT_FALSE(has(svg, "nan") || has(svg, "inf")) << svg;
    EXPECT_LT(svg.size(), 10'000u);  // no coordinate of 300 digits
  }
}

TEST(FigureSvg, LongNamesStayWithinTheDrawing) {
  Figure figure = plain_figure();
  figure.x = {std::string(300, 'x'), Unit::parse("s"), false};
  figure.y = {"departure from the line, over full range", Unit::parse("ppm"), false};
  figure.series[0].name = "A " + std::string(10'000, '-') + " Z";
  const auto svg = to_svg(figure, Drawing::phone);
  EXPECT_TRUE(has(svg, ">departure from the line, over full range [ppm]<"));  // in smaller letters
  EXPECT_TRUE(has(svg, "…xxx") && has(svg, "xxx [s]<") && has(svg, ">A --") && has(svg, "-- Z<"));
  EXPECT_LT(svg.size(), 10'000u + 10'100u);  // the whole name stands once, in the words of the plot
}

// Every axis that numbers can ask for has at least two ticks, all inside of it, and the values inside of it too.
TEST(Ticks, AreInsideAndEnough) {
  for (const double low : {-1e200, -3.7, -1e-9, 0.0, 2e-7, 0.99999, 9.79541, 4e5, 1e200})
    for (const double span : {0.0, 1e-6, 1e-3, 1.0, 7.3, 1e4}) {
      const double high = low + span * std::max(1e-300, std::abs(low));
      const auto ticks = linear_ticks(low, high, 8);
      EXPECT_GE(ticks.at.size(), 2u) << low << " " << high;
      EXPECT_LE(ticks.at.size(), 9u);
      EXPECT_EQ(ticks.at.size(), ticks.labels.size());
      EXPECT_LE(ticks.lower, low);
      EXPECT_GE(ticks.upper, high);
      for (const double at : ticks.at) EXPECT_TRUE(ticks.place(at) >= -1e-9 && ticks.place(at) <= 1 + 1e-9);
      for (std::size_t i = 1; i < ticks.labels.size(); ++i) EXPECT_NE(ticks.labels[i], ticks.labels[i - 1]) << low;
    }
}

TEST(Ticks, OfLogarithmicAxes) {
  for (const double low : {1e-200, 1e-9, 3e-3, 1.0, 47.0})
    for (const double ratio : {1.0, 1.5, 30.0, 1e4, 1e12, 1e60}) {
      const auto ticks = logarithmic_ticks(low, low * ratio, 7);
      EXPECT_GE(ticks.at.size(), 1u) << low << " " << ratio;
      EXPECT_LE(ticks.at.size(), 10u) << low << " " << ratio;
      EXPECT_EQ(ticks.at.size(), ticks.labels.size());
      EXPECT_GT(ticks.place(low), 0.0);
      EXPECT_LT(ticks.place(low * ratio), 1.0);
    }
  EXPECT_EQ(logarithmic_ticks(0.02, 50.0, 7).labels, (std::vector<std::string>{"0.1", "1", "10"}));
  EXPECT_EQ(logarithmic_ticks(1e-6, 1e-4, 4).labels, (std::vector<std::string>{"10⁻⁶", "10⁻⁵", "10⁻⁴"}));
}

TEST(Ticks, LabelsSayWhatTheyMean) {
  EXPECT_EQ(linear_ticks(0.0, 1.0, 6).labels, (std::vector<std::string>{"0", "0.2", "0.4", "0.6", "0.8", "1.0"}));
  EXPECT_EQ(linear_ticks(-2.0, 2.0, 6).labels, (std::vector<std::string>{"−2", "−1", "0", "1", "2"}));
  const auto small = linear_ticks(0.0, 3e-6, 4);
  EXPECT_EQ(small.exponent, -6);
  EXPECT_EQ(small.labels, (std::vector<std::string>{"0", "1", "2", "3"}));
}

}  // namespace
}  // namespace tumble
