#pragma once

#include "tumble/methods/imu_multi_position/fit.hpp"

/// How far the observations scatter, and what that does to the parameters.
namespace tumble::imu_multi_position {

/// Normal equations of the groups in use, with their present variances.
Chain normal_equations(const Fit& fit);

/// The residual of a group in standard deviations [1].
double distance_of(const Group& group, const Fit& fit);

/// Fit::scatter by restricted maximum likelihood at the present linearisation, one part after the other, `rounds`
/// times.
void find_scatter(int rounds, Fit& fit);

/// Variance of an observation [unit of the residual squared]: noise, Earth and scatter.
double variance_of(const Row& row, Part part, const Scatter& scatter);

/// Covariance with its shares and degrees of freedom (Satterthwaite). `noise_degrees` [1]: of the noise at rest.
void add_uncertainty(double noise_degrees, Fit& fit);

/// Error::bad_data: the rests do not show all parameters.
[[noreturn]] void throw_singular();

}  // namespace tumble::imu_multi_position
