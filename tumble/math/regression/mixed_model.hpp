#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tumble/math/matrix.hpp"
#include "tumble/math/regression/least_squares.hpp"

namespace tumble {

/// A disturbance of known size: the observations shift by `column` times a standard normal number, one for all
/// segments or one drawn anew for each.
struct KnownEffect {
  std::string source;          ///< as budgets name it
  std::vector<double> column;  ///< [u] N: change of the observation by one standard deviation
  bool each_segment = false;
  /// Names of the numbers drawn, one, or one a segment: outputs observed together share those of the same name. Empty:
  /// the output's own. See joint_model.hpp.
  std::vector<std::string> draws = {};
  std::string key = {};  ///< see SourceCovariance
};

/// Slow noise: one shift per segment, with covariance variance x kernel between the segments.
struct SlowNoise {
  std::string source;
  Matrix kernel;          ///< G x G, positive semi-definite
  double variance = 0.0;  ///< [u^2 / unit of the kernel]: found by fit_mixed_model, given to predict_mixed_model
  bool known = false;     ///< fit_mixed_model takes the variance as given as well
};

/// Observations in segments, with fixed effects (the parameters), known disturbances and noise of two kinds:
///
///   y = X b + sum_k D_k a_k + S u + e,   a_k ~ N(0, 1),   u ~ N(0, sum_c t_c^2 K_c),   e ~ N(0, s^2/w)
struct MixedData {
  Matrix design;                       ///< X, N x p
  std::vector<double> observations;    ///< y [u]; empty for predict_mixed_model
  std::vector<double> weights;         ///< w: seconds averaged, so that s^2 is a density [u^2 s]
  std::vector<std::size_t> segment;    ///< which segment each observation belongs to: ascending, from 0 to G - 1
  std::vector<KnownEffect> effects;    ///< D
  std::vector<SlowNoise> slow;         ///< K, may be empty
  std::string white = "output noise";  ///< name of the source e
};

/// One source of uncertainty and the covariance it gives the parameters.
struct SourceCovariance {
  std::string source;
  Matrix covariance;  ///< p x p
  /// p x 1, of a known effect with one draw: shift of the parameters by one standard deviation, signed; empty: several
  /// draws, of which the covariance says all there is.
  Matrix shifts = {};
  std::string key = {};  ///< as KnownEffect gives it: what makes the effect the same in another test; empty: nothing
};

/// Where the variance of a slow noise is from.
enum class SlowOrigin {
  contrasts,      ///< of the observations between segments
  known,          ///< as given
  within,         ///< the parameters explain every contrast between segments: means of parts of the segments
  beside_known,   ///< they explain every contrast: the given value is used
  nothing_shows,  ///< they explain every contrast, and nothing else shows it: it is zero
};

struct MixedFit {
  std::vector<double> parameters;         ///< b; zeros from predict_mixed_model
  Matrix covariance;                      ///< of b: the sum of all sources
  std::vector<SourceCovariance> sources;  ///< white noise first, then slow noise, then known effects, as given
  double white_variance = 0.0;            ///< s^2 [u^2 s]
  std::vector<double> slow_variance;      ///< t_c^2
  std::vector<SlowOrigin> slow_origin;    ///< where each is from; empty from predict_mixed_model
  /// Covariance of (s^2, t_c^2) relative to the estimates that `sources` begin with, zero for those known; empty where
  /// all are.
  Matrix component_covariance;
  std::vector<Matrix> component_sensitivity;  ///< d covariance / d (s^2, t_c^2)
  std::vector<double> fitted;                 ///< X b [u], N
  double chi_square = 0.0;                    ///< r' V^-1 r
  double degrees_of_freedom = 0.0;            ///< N - p
  double condition = 0.0;                     ///< of the whitened design with unit columns
};

/// Generalised least squares with variances estimated by restricted maximum likelihood.
///
///   b = G y,  G = (X' V^-1 X)^-1 X' V^-1,   Cov b = sum over sources of G V_source G'
///
/// Slow noise that the contrasts do not show (as many segments as parameters) is not estimated from them: it is taken
/// to be what is known, else what the means of up to eight parts of each segment show, if it is no smaller between the
/// segments, else zero; see SlowOrigin.
///
/// Every segment is first compressed to its sufficient statistics (Householder QR of [X | D | 1]), so that a segment at
/// rest becomes one row and a sum of squares, for any number of observations. The estimate is found as a correction to
/// ordinary least squares, so that observations without noise give b back to rounding.
///
/// Throws    Error::bad_data where X has not full rank, or no degree of freedom is left for the noise
/// See       Patterson and Thompson, Biometrika 58 (1971) 545: restricted likelihood
MixedFit fit_mixed_model(const MixedData& data);

/// The covariance that the same estimator will have, with all variances known (`SlowNoise::variance`) and no data.
/// Given: white_variance s^2 [u^2 s]. Returned: covariance [p x p].
MixedFit predict_mixed_model(const MixedData& data, double white_variance);

/// Degrees of freedom of the variance c' Cov c of a linear function of the parameters: nu = 2 v^2/Var(v), with the
/// variance of v from that of the estimated components (Satterthwaite, Biometrics Bull. 2 (1946) 110).
/// Given: function c, p coefficients [1/u of each]. Returned: degrees of freedom [1].
double degrees_of_freedom(const MixedFit& fit, const std::vector<double>& function);

/// A column that the design cannot separate from others: column `dropped` = sum_k weight_k column_k.
struct Dropped {
  std::size_t column = 0;
  std::vector<double> weights;  ///< one a column of the design, 0 at the dropped ones; all 0: the column is empty
};

/// Columns that must be removed so that the design can distinguish the others: the empty ones, then those that take
/// part in a null vector, in the order of preference given, until none is left.
///
/// Given     design      X [N x p]
///           weights     [s] N, as in MixedData
///           natural     size of each column's entries if the test showed it well (p, or empty): a column whose rms
///                       is smaller by more than `limit` is empty
///           preference  columns, the one to remove first in front; those not named follow, the last first
///           limit       greatest condition of the design with unit columns
std::vector<Dropped> unobservable_columns(const Matrix& design, const std::vector<double>& weights,
                                          const std::vector<double>& natural,
                                          const std::vector<std::size_t>& preference,
                                          double limit = weakest_combination);

}  // namespace tumble
