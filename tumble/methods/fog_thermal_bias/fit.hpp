#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tumble/math/noise_model.hpp"
#include "tumble/methods/fog_thermal_bias/data.hpp"

namespace tumble::fog_thermal_bias {

/// One model of docs/equations (5.1): orders of T, gradient and rate, and the columns of the term table it uses.
struct Candidate {
  int temperature = 1, gradient = 0, rate = 0;
  std::vector<std::size_t> columns;  ///< indices into the terms of the regressors

  // filled by score()
  double sd = 0.0;                       ///< of the compensated averages about their run means, in sample [rad/s]
  double sd_held_out = 0.0;              ///< with every run predicted from the others [rad/s]; NaN: one run
  std::vector<double> held_out_squares;  ///< sum of squares of each fitted run, predicted from the others
  double aicc = 0.0;
  double condition = 0.0;
  std::string unobservable;  ///< combination of parameters that the data do not show; empty: they show all
};

/// The level of a run at power-on, a linear function of the coefficients a: output - regressors' a. Its noise is
/// independent of that of a fit of the triangles.
struct RunLevel {
  double output = 0.0;             ///< [rad/s]
  std::vector<double> regressors;  ///< q
  double variance = 0.0;           ///< by the noise [(rad/s)^2]; infinite: the run has no data
};

/// The whitened runs as small triangles: QR of [1 | columns | y] run by run (without the intercept's row, so that
/// every run has its own free level): sufficient for a linear fit of any subset of the columns.
struct Factors {
  std::vector<Matrix> triangles;  ///< one a fitted run, (q+1) x (q+1), last column y
  std::vector<RunLevel> levels;   ///< one a fitted run
  double rows = 0.0;              ///< averages with data
  double runs = 0.0;
  double log_determinant = 0.0;  ///< of the noise covariance, and of the eliminated intercepts
};

/// Restricted likelihood of the noise of the averages: white, bias instability, random walk.
///   -2 log L = log|V| + log|X' V^-1 X| + r' V^-1 r,   X with one intercept a run and all columns
class Likelihood {
 public:
  using Point = std::vector<double>;  ///< logarithms of N, B, K over their natural scale
  /// Given: interval between the averages [s]. Throws Error::bad_data for a constant output.
  Likelihood(const std::vector<RunData>& runs, std::vector<std::size_t> columns, double interval);
  double operator()(const Point& x) const;  ///< -2 log L [1]
  NoiseModel noise(const Point& x) const;
  Point most_likely() const;

 private:
  const std::vector<RunData>& runs_;
  std::vector<std::size_t> columns_;
  double interval_, white_;
};

/// Degrees of freedom of variances that depend on the estimated noise (Satterthwaite, 1946): nu = 2 v^2/var(v), with
/// var(v) = g' W g, g the gradient of v and W the inverse information of the noise parameters.
/// Returned: degrees of freedom [1], one a variance.
std::vector<double> degrees_of_freedom(const Likelihood& likelihood, const Likelihood::Point& x,
                                       const std::function<std::vector<double>(const NoiseModel&)>& variances);

/// Given: interval between the averages [s].
Factors factorise(const std::vector<RunData>& runs, const std::vector<std::size_t>& columns, const NoiseModel& noise,
                  double interval);

/// Fits a subset of the factorised columns. `columns` are positions in the factorised list.
struct LinearFit {
  std::vector<double> parameters;
  Matrix covariance;       ///< inflation included
  double inflation = 1.0;  ///< max(1, chi_square/degrees of freedom): what the model leaves beyond noise
  double chi_square = 0.0, degrees_of_freedom = 0.0, condition = 0.0;
  std::string unobservable;
};
LinearFit joint(const Factors& factors, const std::vector<std::size_t>& columns, const std::vector<std::string>& names);

/// The source's two stages, docs/equations (5.2) then (5.3): every run by itself in the columns of start-temperature
/// power 0, then each coefficient as a polynomial of the start temperature, weighted with its variance in each run.
/// Given: start_difference, start temperature of each run less the reference [K]. `unused` returns the runs whose
/// profile does not determine the coefficients by itself.
LinearFit two_stage(const Factors& factors, const std::vector<std::size_t>& columns, std::size_t powers,
                    const std::vector<double>& start_difference, std::vector<std::size_t>& unused);

/// Fills the scores of a candidate: in-sample sd, leave-one-run-out sd, AICc, condition.
void score(Candidate& candidate, const Factors& factors, const std::vector<std::size_t>& factorised,
           const std::vector<RunData>& runs, const std::vector<std::string>& names);

/// The candidate with the smallest AICc among those that the data determine.
/// Throws Error::bad_data when the data determine none.
std::size_t choose(const std::vector<Candidate>& candidates);

/// The candidate that holds the terms of all candidates within 10 of the chosen one in AICc, or the largest of these:
/// the covariance of the answer is that of its fit, so that the choice does not remove the uncertainty of what it sets
/// to zero.
std::size_t largest_supported(const std::vector<Candidate>& candidates, std::size_t chosen);

/// Sum of squares about the run's mean of what remains after `columns` times `parameters`, and number of averages.
struct Residual {
  double squares = 0.0, count = 0.0;  ///< [(rad/s)^2], [1]
};
/// Given: parameters [SI], one a column.
Residual residual_of(const RunData& run, const std::vector<std::size_t>& columns,
                     const std::vector<double>& parameters);

}  // namespace tumble::fog_thermal_bias
