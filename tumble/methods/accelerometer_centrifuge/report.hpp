#pragma once

#include "tumble/reduce/accelerometer/scale_factor.hpp"

/// The test of an accelerometer at many g, together with its positions in gravity.
namespace tumble::accelerometer_centrifuge {

std::vector<Option> options();

/// E/K_1 - a_i on (4.19), K_oq and the geometry of the arm:
///
///   a_i = -+ w^2 (R + s w^2) (outward, inward);   effective radius: -+ w^2 dR;   effective centre: -w^2 e in both
///   senses
///
/// All of it is taken at the effective centre, which is so many metres out along the input axis from where the rig
/// places the instrument; the column of the centre is what it lies further out. A known scale factor has no column for
/// its error.
///
/// Given     centre  [m]
linear::Problem problem_of(const Settings& settings, double centre = 0.0);

/// Removes the terms across the input axis where the specific force across it is constant: without a tumble.
void remove_constant_terms(const linear::Solution& first, linear::Problem& problem);

/// Whether the settings give the scale factor with its uncertainty.
bool scale_factor_is_known(const Settings& settings);

/// The plan with a radius longer by so much [m], without the uncertainties of the radius and of the instrument's place
/// along it, because the method estimates both.
Plan with_radius_to_find(Plan plan, double longer);

/// Given     centre  [m] as of the problem
/// Throws    Error::bad_data where the evidence cannot carry the answer.
Estimate answer_of(const Evidence& evidence, accelerometer::Normalised fit, double centre = 0.0);

}  // namespace tumble::accelerometer_centrifuge
