#include "tumble/report/figure/derived.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "tumble/methods/method.hpp"
#include "tumble/report/decimate.hpp"
#include "tumble/report/figure/maps.hpp"
#include "tumble/report/markup.hpp"

namespace tumble::figure {
namespace {

/// All roles of all methods: what a column of residuals is of.
const std::set<std::string>& known_roles() {
  static const std::set<std::string> roles = [] {
    std::set<std::string> all;
    for (const Method* method : method_catalogue())
      for (const Role& role : method->roles()) all.insert(role.name);
    return all;
  }();
  return roles;
}

double number_in(const Table& table, std::size_t row, std::size_t column) {
  const auto* number = std::get_if<double>(&table.rows[row][column]);
  return number ? *number : NAN;
}

/// The output whose residuals a column holds: gyro_x of "residual_gyro_x" and "gyro_x_residual"; absent: it holds none.
std::optional<std::string> output_of(const std::string& column) {
  if (column == "residual") return column;
  for (const std::string& role : known_roles())
    if (column == "residual_" + role || column == role + "_residual") return role;
  return std::nullopt;
}

Curve residuals_of(const Table& table, std::size_t column, const std::string& output, std::size_t noise) {
  Curve curve;
  curve.name = output;
  curve.figure = "residuals of the " + table.name;
  curve.x.name = "number in the table " + table.name;
  curve.y = {"residual", table.columns[column].unit, {}};
  curve.points = true;
  const bool bars = noise < table.columns.size();
  if (bars) curve.band = "2 sd of the output noise";
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const double value = number_in(table, row, column);
    curve.x.values.push_back(static_cast<double>(row + 1));
    curve.y.values.push_back(value);
    if (!bars) continue;
    const double half = 2.0 * number_in(table, row, noise);
    curve.lower.push_back(value - half);
    curve.upper.push_back(value + half);
  }
  return curve;
}

/// Whether a curve shows residuals, by the names that the methods give its quantity or its figure.
bool shows_residuals(const Curve& curve) {
  constexpr std::array<std::string_view, 4> quantities{"residual", "rms residual", "residual of the gain in dB",
                                                       "residual of the phase"};
  constexpr std::array<std::string_view, 3> figures{"residual", "residuals", "residuals of the averages"};
  return std::ranges::find(quantities, curve.y.name) != quantities.end() ||
         std::ranges::find(figures, curve.figure) != figures.end();
}

bool same_axis(const Figure::Axis& a, const Figure::Axis& b) {
  return a.name == b.name && a.unit.dimension() == b.unit.dimension() && a.logarithmic == b.logarithmic;
}

Figure::Series in_unit(Figure::Series series, const Unit& from, const Unit& to) {
  if (from.text() == to.text()) return series;
  for (auto* values : {&series.y, &series.lower, &series.upper})
    for (double& value : *values) value = to.from_si(from.to_si(value));
  return series;
}

}  // namespace

std::vector<Curve> curves_to_draw(const Estimate& estimate) {
  std::vector<Curve> curves = estimate.curves;
  if (std::ranges::any_of(curves, shows_residuals)) return curves;
  for (const auto& table : estimate.tables) {
    if (is_of_map(table)) continue;
    const auto noise = std::ranges::find(table.columns, "noise_sd", &Table::Column::name) - table.columns.begin();
    for (std::size_t i = 0; i < table.columns.size(); ++i)
      if (const auto output = output_of(table.columns[i].name); output && !table.rows.empty())
        curves.push_back(residuals_of(table, i, *output, static_cast<std::size_t>(noise)));
  }
  return curves;
}

void add_overviews(std::vector<Figure>& figures) {
  std::vector<Figure> overviews;
  std::vector<bool> taken(figures.size());
  for (std::size_t i = 0; i < figures.size(); ++i) {
    if (taken[i]) continue;
    Figure overview{figures[i].y.name + ", all together", figures[i].x, figures[i].y, {}, {}};
    for (std::size_t k = i; k < figures.size(); ++k) {
      if (taken[k] || !same_axis(figures[i].x, figures[k].x) || !same_axis(figures[i].y, figures[k].y)) continue;
      if (figures[k].x.unit.text() != figures[i].x.unit.text() || figures[k].series.empty()) continue;
      taken[k] = true;
      overview.series.push_back(in_unit(figures[k].series.front(), figures[k].y.unit, figures[i].y.unit));
    }
    // More series than colours would be a tangle.
    if (overview.series.size() > 1 && overview.series.size() <= palette().size())
      overviews.push_back(std::move(overview));
  }
  figures.insert(figures.begin(), overviews.begin(), overviews.end());
}

}  // namespace tumble::figure
