#include "tumble/report/figure/maps.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/report/names.hpp"

namespace tumble::figure {
namespace {

/// A table of cells, and that of points which belong to them.
struct MapTables {
  const char *cells, *points;
};
constexpr MapTables of_maps[] = {{"thermal_map", "thermal_points"}};
constexpr std::size_t places = 2;  ///< columns of a table that are no quantity

/// A column in its unit; NaN where a row has no number.
std::vector<double> shown_numbers(const Table& table, std::size_t column) {
  std::vector<double> values;
  for (const auto& row : table.rows) {
    const auto* number = std::get_if<double>(&row[column]);
    values.push_back(number ? table.columns[column].unit.from_si(*number) : NAN);
  }
  return values;
}

bool has_numbers(const Table& table, std::size_t column) {
  return std::ranges::any_of(shown_numbers(table, column), [](double value) { return std::isfinite(value); });
}

bool is_drawable(const Table& table) { return table.columns.size() > places && !table.rows.empty(); }

/// The values that stand in a column, rising, each once.
std::vector<double> grid_of(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  std::ranges::sort(values);
  values.erase(std::ranges::unique(values).begin(), values.end());
  return values;
}

/// Half way between the middles, and as far beyond the first and the last.
std::vector<double> edges_of(const std::vector<double>& middles) {
  std::vector<double> edges{1.5 * middles[0] - 0.5 * middles[1]};
  for (std::size_t i = 1; i < middles.size(); ++i) edges.push_back(0.5 * (middles[i - 1] + middles[i]));
  edges.push_back(1.5 * middles.back() - 0.5 * middles[middles.size() - 2]);
  return edges;
}

std::optional<Figure::Map> map_of(const Table& table, std::size_t column) {
  const auto x = shown_numbers(table, 0), y = shown_numbers(table, 1), values = shown_numbers(table, column);
  const auto columns = grid_of(x), rows = grid_of(y);
  if (columns.size() < 2 || rows.size() < 2) return {};
  Figure::Map map{edges_of(columns), edges_of(rows), std::vector<double>(columns.size() * rows.size(), NAN)};
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(x[i]) || !std::isfinite(y[i])) continue;
    const auto at_x = std::ranges::lower_bound(columns, x[i]) - columns.begin();
    const auto at_y = std::ranges::lower_bound(rows, y[i]) - rows.begin();
    map.values[static_cast<std::size_t>(at_y) * columns.size() + static_cast<std::size_t>(at_x)] = values[i];
  }
  return map;
}

Figure::Axis axis_of(const Table::Column& column) { return {readable_name(column.name), column.unit, false}; }

Figure over_places(const Table& table, std::size_t column) {
  Figure figure;
  figure.x = axis_of(table.columns[0]), figure.y = axis_of(table.columns[1]), figure.z = axis_of(table.columns[column]);
  figure.name = figure.z->name + " over " + figure.x.name + " and " + figure.y.name;
  if (!table.caption.empty()) figure.notes.push_back(table.caption);
  return figure;
}

/// Points of a column of their table, in the units of the figure.
void add_points(const Table& table, std::size_t column, Figure& figure) {
  const auto to = [&](std::size_t of, const Unit& unit) {
    auto values = shown_numbers(table, of);
    const Unit& from = table.columns[of].unit;
    if (from.text() != unit.text())
      for (double& value : values) value = unit.from_si(from.to_si(value));
    return values;
  };
  Figure::Series points{"measured", true, to(0, figure.x.unit), to(1, figure.y.unit), {}, {}, ""};
  points.z = to(column, figure.z->unit);
  figure.series.push_back(std::move(points));
}

/// The column of a table with this name and dimension, among the quantities; the number of columns where there is none.
std::size_t column_like(const Table& table, const Table::Column& wanted) {
  std::size_t at = places;
  while (at < table.columns.size() &&
         (table.columns[at].name != wanted.name || table.columns[at].unit.dimension() != wanted.unit.dimension()))
    ++at;
  return at;
}

bool same_places(const Table& a, const Table& b) {
  for (std::size_t i = 0; i < places; ++i)
    if (a.columns[i].unit.dimension() != b.columns[i].unit.dimension()) return false;
  return true;
}

/// The table of that name, where it has the same places.
const Table* beside(const Estimate& estimate, const Table& table, const char* other) {
  const Table* found = find_table(estimate, other);
  return found && is_drawable(*found) && same_places(table, *found) ? found : nullptr;
}

void add_maps(const Table& table, const Table* points, std::vector<Figure>& figures) {
  for (std::size_t i = places; i < table.columns.size(); ++i) {
    if (!has_numbers(table, i)) continue;
    Figure figure = over_places(table, i);
    figure.map = map_of(table, i);
    if (!figure.map) continue;
    if (points)
      if (const auto at = column_like(*points, table.columns[i]); at < points->columns.size())
        add_points(*points, at, figure);
    figures.push_back(std::move(figure));
  }
}

void add_points_alone(const Table& table, const Table* map, std::vector<Figure>& figures) {
  for (std::size_t i = places; i < table.columns.size(); ++i) {
    if (!has_numbers(table, i)) continue;
    if (map && column_like(*map, table.columns[i]) < map->columns.size()) continue;
    Figure figure = over_places(table, i);
    add_points(table, i, figure);
    figures.push_back(std::move(figure));
  }
}

}  // namespace

bool is_of_map(const Table& table) {
  return std::ranges::any_of(of_maps,
                             [&](const MapTables& of) { return table.name == of.cells || table.name == of.points; });
}

std::vector<Figure> maps_of(const Estimate& estimate) {
  std::vector<Figure> figures;
  for (const auto& table : estimate.tables) {
    if (!is_drawable(table)) continue;
    for (const auto& [cells, points] : of_maps) {
      if (table.name == cells) add_maps(table, beside(estimate, table, points), figures);
      if (table.name == points) add_points_alone(table, beside(estimate, table, cells), figures);
    }
  }
  return figures;
}

}  // namespace tumble::figure
