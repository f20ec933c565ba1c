#pragma once

#include "tumble/core/estimate.hpp"

namespace tumble {

/// Sum of factor x factor' over a budget, the covariance [SI] (p x p) of its p parameters.
/// Throws Error::internal where a factor has another number of rows.
Matrix covariance_of(const std::vector<Contribution>& budget, std::size_t parameters);

/// A line of which only the variances [SI^2] (p) are known: one error a parameter, independent of the others.
Contribution independent_errors(std::string source, const std::vector<double>& variance);

/// Factor [SI] (p x q) with no more columns than rows, p x min(p, q), and the same factor x factor'. A factor that is
/// narrow enough stays as it is.
Matrix narrowed(Matrix factor);

/// Lines without a key that give no parameter a thousandth of its variance become one, `all other errors`; those that
/// give nothing go. A line with a key stays: other results are compared by it.
void gather_small(Estimate& estimate);

}  // namespace tumble
