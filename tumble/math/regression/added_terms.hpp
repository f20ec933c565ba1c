#pragma once

#include <vector>

#include "tumble/math/matrix.hpp"
#include "tumble/math/regression/mixed_model.hpp"

namespace tumble {

/// The gain of a fit by one column more.
struct AddedTerm {
  double ratio = 0.0;          ///< F [1] of the column, with one degree of freedom
  double error_freedom = 0.0;  ///< of the error with which it is compared [1]; 0: nothing can be compared
  double probability = 1.0;    ///< p-value [1] of F
  double coefficient = 0.0;    ///< of the column [u over that of the column]
  double gain = 0.0;           ///< logarithm of the likelihood ratio [1]
  double explained = 0.0;      ///< [1] of the residual square without it
};

/// F tests of candidates by their course within the segments: the mean of each segment is left free, so that nothing slow
/// counts, and known effects have their sizes. The error is what remains with the candidate, so that a candidate which
/// explains the misfit is compared with the noise and not with the misfit:
///
///   F = (S_0 - S_1)/(S_1/(n - G - r - 1))
///
/// with the residual squares S_0 of the model of rank r and S_1 of the model and the candidate.
///
/// Given     data        design, weights, segments and known effects, as fitted
///           residuals   [u] N, of the fit
///           candidates  [N x m]
///           white_variance  s^2 [u^2 s] of the fit: the scale of the known effects
std::vector<AddedTerm> added_within_segments(const MixedData& data, const std::vector<double>& residuals,
                                             const Matrix& candidates, double white_variance);

/// Means over segments, as a regression.
struct SegmentMeans {
  Matrix design;                     ///< X [G x p]
  std::vector<double> left = {};     ///< [u] G, what the fit leaves
  Matrix candidates;                 ///< [G x m]
  std::vector<double> white = {};    ///< [u^2] G, variances of the means by white noise
  Matrix known = {};                 ///< [u^2] G x G, covariance by known effects and by slow noise of known size
  std::vector<Matrix> kernels = {};  ///< of the other slow noise, G x G each
};

/// The means over the segments, weighted.
///
/// Given     data, residuals, candidates, white_variance   [u^2 s] as in added_within_segments
SegmentMeans segment_means(const MixedData& data, const std::vector<double>& residuals, const Matrix& candidates,
                           double white_variance);

/// F tests of candidates by the means of the segments. How large the slow noise is, restricted likelihood says for each
/// candidate anew, of a few sizes: a candidate that explains the misfit leaves no slow noise, while the slow noise that is
/// found without it explains the candidate.
///
/// See       Patterson and Thompson, Biometrika 58 (1971) 545: restricted likelihood
std::vector<AddedTerm> added_between_segments(const SegmentMeans& means);

}  // namespace tumble
