#include "tumble/core/columns.hpp"

#include <numeric>

namespace tumble {

Table tabulate(std::string name, std::string caption, std::size_t rows, const NumberedColumns& columns) {
  std::vector<std::size_t> numbers(rows);
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  return tabulate(std::move(name), std::move(caption), numbers, columns);
}

Table for_programs(Table table) {
  table.for_programs = true;
  return table;
}

void add_unless_empty(std::vector<Table>& tables, Table table) {
  if (!table.rows.empty()) tables.push_back(std::move(table));
}

void add_point(Curve& curve, double x, double y) {
  curve.x.values.push_back(x);
  curve.y.values.push_back(y);
}

void add_point(Curve& curve, double x, double y, double half) { add_point(curve, x, y, y - half, y + half); }

void add_point(Curve& curve, double x, double y, double lower, double upper) {
  add_point(curve, x, y);
  curve.lower.push_back(lower);
  curve.upper.push_back(upper);
}

}  // namespace tumble
