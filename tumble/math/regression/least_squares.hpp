#pragma once

#include <string>
#include <vector>

#include "tumble/math/matrix.hpp"

namespace tumble {

/// Condition of columns of unit length, beyond which their weakest combination is not estimated: a relative error of
/// 1e-6 in the inputs moves it by its size.
constexpr double weakest_combination = 1e6;

/// A parameter combination the data do not show: a unit null vector of the scaled design.
struct Unobservable {
  std::vector<double> direction;  ///< one entry a parameter, of the columns scaled to unit norm
  std::string in_words;           ///< "bias - 0.71 K_pp": parameter names with their weights, in scaled columns
};

struct LeastSquaresOptions {
  std::vector<std::string> names;  ///< of the parameters, for messages
  std::vector<double> prior_mean;  ///< empty, or one a parameter
  std::vector<double> prior_sd;    ///< empty, or one a parameter; +inf: no prior. Random effects are columns with one
  bool known_sigma = false;        ///< true: the observations are whitened to unit variance; false: s^2 estimated
  bool robust = false;             ///< Huber, k = 1.345, scale by MAD, leverage-corrected
  double condition_limit = weakest_combination;  ///< above: the weakest combination is unobservable and not estimated
};

struct LeastSquaresFit {
  std::vector<double> parameters;
  Matrix covariance;
  double chi_square = 0.0;  ///< weighted residual sum of squares, priors included
  double degrees_of_freedom = 0.0;
  double sigma = 1.0;      ///< sd of unit weight used in the covariance
  double condition = 0.0;  ///< of the design with unit columns
  double aicc = 0.0;
  std::vector<double> residuals;  ///< y - X b, unweighted
  std::vector<double> leverage;   ///< diagonal of the hat matrix
  std::vector<double> weights;    ///< robust weights, 1 without
  std::vector<Unobservable> unobservable;
};

/// Weighted least squares y = X b + e by Householder QR with column scaling.
///
///   b = (X' W X)^-1 X' W y,   Cov b = s^2 (X' W X)^-1,   s^2 = r' W r/(N - p)  unless known
///
/// Given     design  X, N x p; observations y [u], N; weights  1/variance [u^-2] (empty: 1)
/// Throws    Error::bad_data for fewer observations than parameters, or values that are not finite
/// See       AICc = N ln(RSS/N) + 2k + 2k(k+1)/(N-k-1), k = p + 1
LeastSquaresFit least_squares(const Matrix& design, const std::vector<double>& observations,
                              const std::vector<double>& weights, const LeastSquaresOptions& options);

/// Least squares of correlated observations: whitens by the Cholesky factor of the covariance.
///
/// Given     design        X [N x p]; observations y [u], N
///           covariance    of the observations [u^2, N x N]
/// Returned  as weighted least squares of the whitened rows
LeastSquaresFit generalised_least_squares(const Matrix& design, const std::vector<double>& observations,
                                          const Matrix& covariance, const LeastSquaresOptions& options);

/// Quantile [1] of Student's t and of chi-square; degrees_of_freedom [1] may be infinite. probability in (0, 1).
double student_quantile(double probability, double degrees_of_freedom);
double chi_square_quantile(double probability, double degrees_of_freedom);
/// Probabilities [1] below what sound data exceed once in 100, in 1000 and in 10 000 tests.
constexpr double exceeded_in_100 = 0.99, exceeded_in_1000 = 0.999, exceeded_in_10000 = 0.9999;

/// Standard uncertainty to state with a standard deviation `sd` [u] estimated with few degrees of freedom nu: such that
/// sd +- t_0.975(nu) times it holds the true value 95 % of the time although sd is skewed (chi). Close to
/// sd/sqrt(2 nu) for many degrees of freedom, larger for few.
double uncertainty_of_sd(double sd, double degrees_of_freedom);

/// Ends of an interval that holds a standard deviation: never below zero.
struct SdInterval {
  double lower = 0.0, upper = 0.0;  ///< [u]
};

/// Two-sided interval of a standard deviation that is estimated with nu degrees of freedom:
///
///   sd sqrt(nu/chi2_(1+c)/2(nu)) to sd sqrt(nu/chi2_(1-c)/2(nu))
///
/// Given     sd [u]; degrees_of_freedom [1], may be infinite; confidence c in (0, 1)
SdInterval interval_of_sd(double sd, double degrees_of_freedom, double confidence = 0.95);

/// Interval of sqrt(V_1 - V_2), V the expectations of two independent variances that are distributed like chi-square:
/// the modified large-sample limits, exact where one of the two is zero. An end whose square is negative is zero.
///
/// Given     total, part  [u^2] estimates of V_1 and V_2, with their degrees of freedom [1], which may be infinite
/// Accuracy  holds the true value in 94.5 to 97 % for a confidence of 0.95 and one degree of freedom or more
/// See       Ting, Burdick, Graybill, Jeyaratnam and Lu, J. Statist. Comput. Simul. 35 (1990) 135
SdInterval interval_of_excess_sd(double total, double total_freedom, double part, double part_freedom,
                                 double confidence = 0.95);

}  // namespace tumble
