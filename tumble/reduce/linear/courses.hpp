#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tumble/reduce/linear/rows.hpp"

/// How an output and the axes of its rig go through the samples of one row.
namespace tumble::linear {

/// The samples of a row, by a few instants within them.
struct Course {
  std::vector<double> output = {};  ///< [SI] as the model has it, at each instant
  std::vector<double> share = {};   ///< of the row that each instant represents: their sum is 1
  double slope = 0.0;               ///< [SI/s] of the output, mean over the row; 0 where what is felt stays
  double bend = 0.0;                ///< [SI/s^2] of its slope, mean over the row
  double time = 0.0;                ///< [s] since power-on, middle
  std::size_t segment = 0;          ///< index of the stretch
  std::vector<std::vector<double>> angles = {};  ///< [rad] of each turning axis, at each instant
};

/// The axes of the rigs of a test that turn, without those of the fixture.
std::vector<std::string> turning_axes(const ConductedTest& test);

/// The mean over the row of a function of values at its instants. Returned: [unit of the function].
template <class Function>
double mean_over_course(const Course& course, const std::vector<double>& at_instants, const Function& function) {
  double sum = 0.0;
  for (std::size_t k = 0; k < at_instants.size(); ++k) sum += course.share[k] * function(at_instants[k]);
  return sum;
}

/// The courses of all rows.
///
/// Given     coefficients   [SI] of all columns of the problem
///           axes           whose angles are wanted
std::vector<Course> output_courses(const Evidences& evidence, const Problem& problem, const Rows& rows,
                                   const std::vector<double>& coefficients, const std::vector<std::string>& axes);

}  // namespace tumble::linear
