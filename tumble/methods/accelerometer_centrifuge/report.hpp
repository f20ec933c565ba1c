#pragma once

#include "tumble/reduce/accelerometer/scale_factor.hpp"

/// The test of an accelerometer at many g, with what it shows in gravity beside it.
namespace tumble::accelerometer_centrifuge {

std::vector<Option> options();

/// E/K_1 - a_i on (4.19), K_oq and the geometry of the arm:
///
///   a_i = -+ w^2 (R + s w^2) (outward, inward);   effective radius: -+ w^2 dR;   effective centre: -w^2 e in both
///   senses
///
/// With a scale factor that is known there is no column for its error.
linear::Problem problem_of(const Settings& settings);

/// Takes out the terms across the input axis where nothing across it changes: without a tumble.
void leave_out_what_is_constant(const linear::Solution& first, linear::Problem& problem);

/// Whether the settings give the scale factor with its uncertainty.
bool scale_factor_is_known(const Settings& settings);

/// The plan with a radius longer by so much [m], and no uncertainty of it or of the instrument's place along it: they
/// are what is estimated.
Plan with_radius_to_find(Plan plan, double longer);

/// Throws Error::bad_data where the evidence cannot carry the answer.
Estimate answer_of(const Evidence& evidence, accelerometer::Normalised found);

}  // namespace tumble::accelerometer_centrifuge
