#pragma once

#include <cstddef>
#include <vector>

#include "tumble/math/matrix.hpp"

namespace tumble {

/// Whether observations need more columns than a model has.
struct LackOfFit {
  double ratio = 0.0;          ///< F [1]
  double freedom = 0.0;        ///< columns that the model does not contain already [1]
  double error_freedom = 0.0;  ///< of the error with which they are compared [1]; may be infinite
  double probability = 1.0;    ///< p-value [1] of F; 1 where nothing can be compared
  double coefficient = 0.0;    ///< of a single column more [u over that of the column]
  double sd = 0.0;             ///< its standard uncertainty by the covariance as given
};

/// F test of lack of fit. S is the residual square of generalised least squares, S_0 of the columns of the model, S_1
/// of these and `more`, n - r_1 degrees of freedom:
///
///   F = ((S_0 - S_1)/q)/(S_1/(n - r_1))      covariance known up to a factor
///   F = (S_0 - S_1)/q                        covariance estimated with `error_freedom`
///
/// With one column for each group of repeats as `more` it is the classical test against the pure error of the repeats;
/// with a single column, whether what it describes is there.
///
/// Given     design      X [n x p]; more [n x m]; observations y [u], n
///           covariance  of y [u^2, n x n]
///           error_freedom  of the covariance [1], may be infinite; 0: known up to a factor
/// Valid     where X contains `more`, or no degree of freedom remains, the probability is 1
/// See       Draper and Smith, Applied Regression Analysis, 3rd ed. (1998), section 2.1; Searle, Linear Models (1971)
LackOfFit lack_of_fit(const Matrix& design, const Matrix& more, const std::vector<double>& observations,
                      const Matrix& covariance, double error_freedom = 0.0);

/// [1] that an F of so many degrees of freedom, the second of which may be infinite, is `ratio` or more.
double chance_of_ratio(double ratio, double freedom, double error_freedom);

/// One column for each different entry of `group` [n], 1 where it stands: [n x groups].
Matrix indicators(const std::vector<std::size_t>& group);

}  // namespace tumble
