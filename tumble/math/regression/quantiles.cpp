#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "tumble/math/regression/least_squares.hpp"

namespace tumble {

double student_quantile(double probability, double degrees_of_freedom) {
  // Boost takes an infinite number of degrees of freedom as the normal distribution.
  return boost::math::quantile(boost::math::students_t_distribution<double>(degrees_of_freedom), probability);
}

double chi_square_quantile(double probability, double degrees_of_freedom) {
  return boost::math::quantile(boost::math::chi_squared_distribution<double>(degrees_of_freedom), probability);
}

double uncertainty_of_sd(double sd, double degrees_of_freedom) {
  const boost::math::chi_squared_distribution<double> chi_square(degrees_of_freedom);
  // sd (1 +- h) misses sigma when sd^2 < sigma^2/(1+h)^2, or for h < 1 when sd^2 > sigma^2/(1-h)^2.
  const auto missed = [&](double h) {
    const double low = cdf(chi_square, degrees_of_freedom / ((1.0 + h) * (1.0 + h)));
    return h < 1.0 ? low + cdf(complement(chi_square, degrees_of_freedom / ((1.0 - h) * (1.0 - h)))) : low;
  };
  double low = 0.0, high = 1.0;
  while (missed(high) > 0.05) high *= 2.0;
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (low + high);
    (missed(middle) > 0.05 ? low : high) = middle;
  }
  return sd * high / student_quantile(0.975, degrees_of_freedom);
}

}  // namespace tumble
