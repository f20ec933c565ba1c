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

/// Points over the time since the first day of all.
Curve curve_over_time(const std::string& name, const std::string& figure, std::int64_t first_day,
                      const std::string& quantity, const Unit& unit);
/// [s] since the beginning of a day. Given: time [s since 1970].
double since(std::int64_t first_day, double moment);

/// Which unit and which result a drawn point is, so that a page can lead from the one to the other.
struct Link {
  std::string curve;
  double time, value;       ///< [SI] of the point
  std::string unit;         ///< "model/serial"
  std::int64_t result = 0;  ///< number in the archive; 0: the point is the unit
};
/// The link of the last point of a curve.
Link link_of(const Curve& curve, const std::string& unit, std::int64_t result);
/// Table `links`, for programs. Given: unit of the values.
Table links_table(const std::vector<Link>& links, const Unit& unit);

}  // namespace tumble::statistics
