#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "tumble/math/bisection.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/regression/least_squares.hpp"

namespace tumble {

double student_quantile(double probability, double degrees_of_freedom) {
  // Boost takes an infinite number of degrees of freedom as the normal distribution. Of almost none, the quantile is
  // beyond all doubles: infinite, where Boost would throw.
  namespace policies = boost::math::policies;
  using Infinite = policies::policy<policies::overflow_error<policies::ignore_error>>;
  return boost::math::quantile(boost::math::students_t_distribution<double, Infinite>(degrees_of_freedom), probability);
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
  double high = 1.0;
  while (missed(high) > missed_by_95) high *= 2.0;
  constexpr int halvings = 60;  // to rounding
  high = bisected(0.0, high, halvings, [&](double h) { return missed(h) > missed_by_95; }).high;
  return sd * high / student_quantile(two_sided_95, degrees_of_freedom);
}

namespace {

constexpr double no_scatter = 1e9;  ///< degrees of freedom from which a variance counts as known

/// chi2/nu at a probability; 1 where the variance is known.
double mean_square_quantile(double probability, double nu) {
  return nu < no_scatter ? chi_square_quantile(probability, nu) / nu : 1.0;
}

double ratio_quantile(double probability, double nu_1, double nu_2) {
  if (nu_2 >= no_scatter) return mean_square_quantile(probability, nu_1);
  if (nu_1 >= no_scatter) return 1.0 / mean_square_quantile(1.0 - probability, nu_2);
  return boost::math::quantile(boost::math::fisher_f_distribution<double>(nu_1, nu_2), probability);
}

/// Square of the distance from the estimate to one end: of a V_1 whose chi2/nu is `first`, a V_2 whose is `second`, and
/// F at the same probability, at which the limit of the difference is zero.
double squared_distance(double total, double part, double first, double second, double f) {
  const double of_total = 1.0 / first - 1.0, of_part = 1.0 / second - 1.0;
  const double cross = (std::pow(f - 1.0, 2) - std::pow(of_total * f, 2) - of_part * of_part) / f;
  return std::max(0.0, std::pow(of_total * total, 2) + std::pow(of_part * part, 2) + cross * total * part);
}

}  // namespace

SdInterval interval_of_sd(double sd, double degrees_of_freedom, double confidence) {
  return interval_of_excess_sd(sd * sd, degrees_of_freedom, 0.0, 1.0, confidence);
}

SdInterval interval_of_excess_sd(double total, double total_freedom, double part, double part_freedom,
                                 double confidence) {
  const double high = 0.5 * (1.0 + confidence), low = 1.0 - high;
  const auto end = [&](double probability, double sign) {
    const double away = squared_distance(total, part, mean_square_quantile(probability, total_freedom),
                                         mean_square_quantile(1.0 - probability, part_freedom),
                                         ratio_quantile(probability, total_freedom, part_freedom));
    return std::sqrt(std::max(0.0, total - part + sign * std::sqrt(away)));
  };
  return {end(high, -1.0), end(low, 1.0)};
}

}  // namespace tumble
