#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/report/decimate.hpp"
#include "tumble/report/figure.hpp"

namespace tumble {
namespace {

struct CsvColumn {
  std::string name;
  const std::vector<double>* values;
};

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? "\"\"" : std::string(1, c);
  return result + "\"";
}

std::string heading_of(const std::string& name, const Unit& unit) {
  const std::string shown(unit.text());
  return quoted(shown == "1" ? name : name + "[" + shown + "]");
}

bool same_numbers(const std::vector<double>& a, const std::vector<double>& b) {
  return std::ranges::equal(a, b, [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); });
}

/// Middle and value of each cell of a map.
struct Cells {
  std::vector<double> x, y, z;
};

Cells cells_of(const Figure& figure) {
  Cells cells;
  if (!figure.map) return cells;
  const auto& [x, y, values] = *figure.map;
  for (std::size_t row = 0, at = 0; row + 1 < y.size(); ++row)
    for (std::size_t column = 0; column + 1 < x.size(); ++column, ++at) {
      if (std::isnan(values[at])) continue;
      cells.x.push_back(0.5 * (x[column] + x[column + 1]));
      cells.y.push_back(0.5 * (y[row] + y[row + 1]));
      cells.z.push_back(values[at]);
    }
  return cells;
}

std::vector<CsvColumn> columns_of(const Figure& figure, const Cells& cells) {
  std::vector<CsvColumn> columns;
  if (figure.map)
    columns = {{heading_of(figure.x.name, figure.x.unit), &cells.x},
               {heading_of(figure.y.name, figure.y.unit), &cells.y},
               {heading_of(figure.z->name, figure.z->unit), &cells.z}};
  const std::vector<double>* x = nullptr;
  for (const auto& series : figure.series) {
    if (x == nullptr || !same_numbers(*x, series.x))
      columns.push_back({heading_of(figure.x.name, figure.x.unit), &series.x});
    x = &series.x;
    const bool coloured = !series.z.empty();
    columns.push_back({heading_of(coloured ? figure.y.name : series.name, figure.y.unit), &series.y});
    if (coloured) columns.push_back({heading_of(series.name, figure.z->unit), &series.z});
    if (series.lower.empty()) continue;
    columns.push_back({heading_of(series.name + " lower", figure.y.unit), &series.lower});
    columns.push_back({heading_of(series.name + " upper", figure.y.unit), &series.upper});
  }
  return columns;
}

std::vector<double> of_indices(const std::vector<double>& values, const std::vector<std::size_t>& indices) {
  std::vector<double> result;
  if (values.empty()) return result;
  for (const auto i : indices) result.push_back(values[i]);
  return result;
}

}  // namespace

std::string to_csv(const Figure& figure) {
  const Cells cells = cells_of(figure);
  const auto columns = columns_of(figure, cells);
  std::size_t rows = 0;
  std::string text;
  for (const auto& column : columns) {
    text += (text.empty() ? "" : ",") + column.name;
    rows = std::max(rows, column.values->size());
  }
  text += '\n';
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (i > 0) text += ',';
      const auto& values = *columns[i].values;
      if (row < values.size() && !std::isnan(values[row])) text += fmt::format("{:.12g}", values[row]);
    }
    text += '\n';
  }
  return text;
}

Figure with_fewer_points(const Figure& figure, std::size_t most) {
  Figure result = figure;
  for (auto& series : result.series) {
    if (series.x.size() <= most) continue;
    const auto indices = points_to_draw(series.x, series.y, series.lower, series.upper, figure.x.logarithmic, most);
    for (auto* values : {&series.x, &series.y, &series.lower, &series.upper, &series.z})
      *values = of_indices(*values, indices);
  }
  return result;
}

}  // namespace tumble
