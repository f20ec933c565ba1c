#pragma once

#include <string>
#include <vector>

#include "tumble/archive/statistics.hpp"

/// The parts of an answer that is put together from many results.
namespace tumble::statistics {

/// A number with its interval. [SI]
struct Stated {
  std::string name, description;
  Unit unit;
  double value = 0.0, sd = 0.0;     ///< an sd of NaN: by the interval
  double lower = 0.0, upper = 0.0;  ///< 95 %; NaN: by the sd
};

/// An answer of this name without parameters: title, selection and settings.
Estimate answer_of(const std::string& name, const std::string& title, const ArchivedSelection& what);
/// Adds the numbers as parameters. Their errors are not independent of each other, but nothing is known of how: the
/// covariance is diagonal, and the budget has one line.
void state(Estimate& estimate, const std::vector<Stated>& numbers);

Table::Column column(const std::string& name, const Unit& unit = {});
/// Points over the time since the first day of all.
Curve curve_over_time(const std::string& name, const std::string& figure, std::int64_t first_day,
                      const std::string& quantity, const Unit& unit);
/// Given: time [s since 1970], value [SI].
void add_point(Curve& curve, std::int64_t first_day, double moment, double value);
/// Given: limits [SI] of the last point.
void add_band(Curve& curve, double lower, double upper);

/// Table `links`, for programs: which unit and which result (by its number in the archive) each drawn point is, so that
/// a page can lead from the one to the other.
Table links_table(const Unit& unit);
/// The last point of a curve. Given: "model/serial", and the number of the result; 0: the point is the unit.
void add_link(const Curve& curve, const std::string& unit, std::int64_t result, Table& links);

}  // namespace tumble::statistics
