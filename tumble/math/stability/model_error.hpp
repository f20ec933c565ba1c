#pragma once

#include <cmath>

#include "tumble/math/bisection.hpp"
#include "tumble/math/stability/allan_fit.hpp"

namespace tumble {

/// Whether chi-square of a fit is larger than its noise makes it once in a thousand fits: the model has an error.
/// Given: chi-square [1] and its degrees of freedom [1]; with less than one there is no evidence.
inline bool has_model_error(double chi_square, double degrees_of_freedom) {
  constexpr double least_p = 1e-3;
  return !(degrees_of_freedom < 1.0 || chi_square_tail(chi_square / degrees_of_freedom, degrees_of_freedom) > least_p);
}

/// Relative error of each variance [1] at which chi-square equals its degrees of freedom.
/// Given: exceeds, called with an error [1], returns whether chi-square is above its degrees of freedom then.
template <class Exceeds>
double model_error_where(const Exceeds& exceeds) {
  constexpr double least = 1e-5, greatest = 3.0;  // of no effect; of a model that says nothing
  constexpr int halvings = 12;                    // the interval is then exp(ln(3e5)/4096), 0.3 % of the error
  return std::exp(bisected(std::log(least), std::log(greatest), halvings, [&](double logarithm) {
                    return exceeds(std::exp(logarithm));
                  }).high);
}

}  // namespace tumble
