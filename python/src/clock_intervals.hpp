#pragma once

#include <cstddef>
#include <span>
#include <utility>

/// Limits of a deviation and equivalent degrees of freedom as the package allantools gives them, for those who switch
/// from it. Those of Tumble: tumble/math/stability/allan_edf.hpp, allan_edf_extended.hpp.
namespace tumble::python {

/// Limits [u] of a deviation [u] by chi-square with edf [1]: those of the probabilities a and 1 - a, where
/// a = min(|ci|, |ci - 1|)/2. NaN where a is above 1 or edf below 0.
std::pair<double, double> chi_square_limits(double deviation, double edf, double ci);

/// Equivalent degrees of freedom [1] of the overlapping Allan variance, of N phase points at factor m, in noise
/// alpha = -2 ... 2; N - 1 for another alpha.
/// See       S. Stein, Frequency and time - their measurement and characterization (1985)
double simple_edf(double points, double factor, int alpha);

}  // namespace tumble::python
