#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "tumble/math/least_squares.hpp"

namespace tumble {

double student_quantile(double probability, double degrees_of_freedom) {
  // Boost takes an infinite number of degrees of freedom as the normal distribution.
  return boost::math::quantile(boost::math::students_t_distribution<double>(degrees_of_freedom), probability);
}

double chi_square_quantile(double probability, double degrees_of_freedom) {
  return boost::math::quantile(boost::math::chi_squared_distribution<double>(degrees_of_freedom), probability);
}

}  // namespace tumble
