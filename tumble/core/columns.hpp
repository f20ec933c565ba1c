#pragma once

#include <concepts>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "tumble/core/estimate.hpp"

namespace tumble {

/// A cell of a table: a number, or the text of anything else.
template <class Value>
Table::Cell table_cell(Value&& value) {
  using Plain = std::remove_cvref_t<Value>;
  static_assert(!std::same_as<Plain, bool>, "say it in a word");
  if constexpr (std::is_arithmetic_v<Plain>)
    return static_cast<double>(value);
  else if constexpr (std::same_as<Plain, Table::Cell>)
    return std::forward<Value>(value);
  else
    return std::string(std::forward<Value>(value));
}

/// A column of a table: its heading, the unit in which it is shown, and its cell [SI] of a row. The cell is a member of
/// the row, or a function of it. A column without unit is of unit "1".
template <class Row>
struct ColumnOf {
  std::string heading;
  Unit unit;
  std::function<Table::Cell(const Row&)> cell;

  template <class Of>
  ColumnOf(std::string name, Of of) : ColumnOf(std::move(name), Unit(), std::move(of)) {}
  template <class Of>
  ColumnOf(std::string name, const char* shown_in, Of of)
      : ColumnOf(std::move(name), Unit::parse(shown_in), std::move(of)) {}
  template <class Of>
  ColumnOf(std::string name, Unit shown_in, Of of)
      : heading(std::move(name)),
        unit(std::move(shown_in)),
        cell([of = std::move(of)](const Row& row) { return table_cell(std::invoke(of, row)); }) {}
};

/// Columns whose cells depend on the number of the row alone.
using NumberedColumns = std::vector<ColumnOf<std::size_t>>;

/// A table with a row for each of `rows` and these columns:
///
///   tabulate("units", "the units side by side", units, {{"unit", &Measured::name},
///                                                        {"sd", "ug", [](const Measured& m) { return m.sd; }}})
template <class Rows, class Row = typename Rows::value_type>
Table tabulate(std::string name, std::string caption, const Rows& rows,
               const std::vector<ColumnOf<std::type_identity_t<Row>>>& columns) {
  Table table{std::move(name), std::move(caption), {}, {}};
  for (const auto& column : columns) table.columns.push_back({column.heading, column.unit});
  table.rows.reserve(rows.size());
  for (const Row& row : rows) {
    auto& cells = table.rows.emplace_back();
    cells.reserve(columns.size());
    for (const auto& column : columns) cells.push_back(column.cell(row));
  }
  return table;
}

/// A table with so many rows; cells are functions of the number of the row, from 0.
Table tabulate(std::string name, std::string caption, std::size_t rows, const NumberedColumns& columns);

/// The table, marked as one that programs read and people are not shown.
Table for_programs(Table table);
/// Adds a table to others where it has a row.
void add_unless_empty(std::vector<Table>& tables, Table table);

/// Adds a point [SI] to a curve.
void add_point(Curve& curve, double x, double y);
/// Adds a point [SI] with a band of `half` to both sides of it.
void add_point(Curve& curve, double x, double y, double half);
/// Adds a point [SI] with the ends of its band.
void add_point(Curve& curve, double x, double y, double lower, double upper);

}  // namespace tumble
