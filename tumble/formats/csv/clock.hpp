#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "tumble/core/channel.hpp"
#include "tumble/formats/csv/names.hpp"
#include "tumble/formats/csv/stamp.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::csv {

inline constexpr std::size_t no_column = static_cast<std::size_t>(-1);

/// Content of the first cells of a column.
struct ColumnSample {
  StampKind kind = StampKind::none;  ///< all cells that are not blank are such stamps
  bool text = false;                 ///< most cells are neither numbers nor stamps
  bool empty = true;
  bool numbers = false;            ///< any
  std::string other = {};          ///< the first cell that is neither number nor stamp
  double first = 0.0, last = 0.0;  ///< numbers [as written]
  double greatest = 0.0;           ///< magnitude of the numbers
  double step = 0.0;               ///< from number to number: the median of the magnitudes that are not zero
  std::vector<std::string> cells;
  std::string grouped = {};     ///< the first cell such as 1,234, where a comma may separate thousands
  bool decimal_commas = false;  ///< a comma in another cell cannot
};

std::vector<ColumnSample> sampled(const std::vector<std::vector<std::string>>& rows, std::size_t columns);

/// Part of a clock: a date, a time of day, a number.
struct ClockColumn {
  std::size_t index = no_column;
  StampFormat format = {};
};

/// The first columns of a clock that say the date by whole numbers.
enum class DateColumns { none, year_month_day, year_day };

/// Period after which the stamps of a clock begin again, where they do not say the date.
enum class Turn { none, day, year };

/// The columns that say the time; their stamps are added. Without a format, the only one is a number of the unit of its
/// column.
struct Clock {
  std::vector<ClockColumn> columns;
  std::string how;                  ///< for people; empty: a column time[unit], which needs no words
  std::vector<std::size_t> others;  ///< clocks too, which are not used
  DateColumns date = DateColumns::none;
  Turn turn = Turn::none;
  std::string unit;    ///< that the name of the first column says; empty: see the column
  bool zoned = false;  ///< the stamps say their time zone, or are Unix time: they are UTC
  std::size_t first() const { return columns.empty() ? no_column : columns.front().index; }
  bool uses(std::size_t index) const { return std::ranges::find(columns, index, &ClockColumn::index) != columns.end(); }
  StampKind kind() const { return columns.empty() ? StampKind::none : columns.front().format.kind; }
  bool stamped() const { return kind() != StampKind::none; }
};

/// The clock of a table: the column that options.time names, time[unit], a pair of seconds and nanoseconds, the names
/// that programs give their stamps, a date and a time of day, with milliseconds in a column of their own, or all their
/// numbers in columns (split_clock.hpp). Unix time is recognised by its size. What must be said by the user is a
/// problem, with what to say in `proposals` (key=value).
Clock clock_of(const std::vector<ColumnName>& names, const std::vector<ColumnSample>& samples,
               const ReadOptions& options, Problems& problems, std::vector<std::string>& proposals);

/// "time" in any case, or "t" in a unit of time ("T" is a temperature).
bool is_time(const std::string& name, const std::string& unit);

}  // namespace tumble::csv
