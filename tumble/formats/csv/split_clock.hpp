#pragma once

#include <optional>

#include "tumble/formats/csv/clock.hpp"

namespace tumble::csv {

/// A clock whose numbers have columns of their own: hour, minute and second (or the second of the day), with fractions
/// (ms, us, ns), after year, month and day, year and day of the year, the day of the year alone, a column of dates, or
/// no date. None where these are not all there, or where their first numbers lie outside of a clock.
/// Given  names, samples  of all columns
std::optional<Clock> split_clock(const std::vector<ColumnName>& names, const std::vector<ColumnSample>& samples);

/// Fractions of whole seconds that have columns of their own ("ms", and "us" of these) are added to the clock.
void add_fractions(const std::vector<ColumnName>& names, const std::vector<ColumnSample>& samples, Clock& clock);

/// [ns] since 1970-01-01, of midnight; none for a date that the calendar does not have.
/// Given  year, month and day, or year and day of the year, as DateColumns says
std::optional<std::int64_t> midnight_of(DateColumns columns, std::int64_t year, std::int64_t month_or_day,
                                        std::int64_t day);

}  // namespace tumble::csv
