#pragma once

#include <functional>

#include "tumble/core/evidence.hpp"
#include "tumble/reduce/accelerometer/output.hpp"
#include "tumble/reduce/linear/linear.hpp"

/// The scale factor as a parameter of a linear problem:
///
///   E = K_1 (a_i + K_0 + K_2 a_i^2 + K_3 a_i^3 + ...)                                                     (4.19)
///
/// A problem has the input a_i and a column `scale_factor_error`. It is solved once for K_1, then with the output in
/// units of this K_1; the coefficients are divided by the remaining 1 + dK_1, and the covariance follows them.
namespace tumble::accelerometer {

/// A solution in which the column `scale_factor_error` has become `scale_factor`, and the other coefficients are those
/// of E/K_1.
struct Normalised {
  linear::Problem problem;
  linear::Solution solution;
  Output output;
  double scale_factor = 1.0;  ///< [SI]
};

/// Changes the problem after the first solution, which shows what the evidence holds; null: nothing to change.
using Refine = std::function<void(const linear::Solution& first, linear::Problem& problem)>;

/// Identifies `problem`, whose role, scale and pulse need not be set. Throws Error::bad_data where no position shows
/// the scale factor.
Normalised identify(const Evidence& evidence, linear::Problem problem, const Refine& refine);
/// The normalised coefficients and their uncertainties from the plan's [truth].
Normalised predict(const Plan& plan, linear::Problem problem, const Refine& refine);

/// A problem without the column `scale_factor_error`: the settings give scale_factor and scale_factor_sd, which is an
/// error of the reading. Throws Error::bad_input where they do not.
Normalised identify_with_known_scale_factor(const Evidence& evidence, linear::Problem problem, const Refine& refine);
Normalised predict_with_known_scale_factor(const Plan& plan, linear::Problem problem, const Refine& refine);

/// Puts K_1 = nominal (1 + dK_1) and the coefficients over 1 + dK_1 into the solution, with their covariance:
///
///   d b_j/(1 + d) = d b_j/(1 + d) - b_j d d/(1 + d)^2
///
/// Given     nominal [output per m/s^2]
void normalise(linear::Solution& solution, double nominal, const Output& output);

/// The evidence with all counts as of windows of one length: recordings of one fit may have other counting rates.
Evidence at_one_rate(const Evidence& evidence);

/// Table `local_g`: the coefficients where the unit g is the gravity of the place. With r = gravity/9.80665 m/s^2, K_1
/// is multiplied by r, K_0 by 1/r, K_2 and the like by r, K_3 by r^2; angles stay (r = 0.9988 at 9.795 m/s^2).
/// Given: gravity [m/s^2].
Table in_local_g(const Estimate& estimate, double gravity);

}  // namespace tumble::accelerometer
