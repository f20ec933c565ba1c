#pragma once

#include "tumble/reduce/accelerometer/scale_factor.hpp"

/// The multi-position test of an accelerometer in gravity.
namespace tumble::accelerometer_tumble {

std::vector<Option> options();

/// All terms of the model that a result of this method may hold.
std::vector<Term> all_terms();

/// E/K_1 - a_i on the terms of (4.19) that the settings choose.
linear::Problem problem_of(const Settings& settings);

/// Adds K_pp where positions in two mounts show K_pp - K_oo, unless the settings say otherwise.
accelerometer::Refine refine_of(const Settings& settings);

/// Parameters, tables, curves and findings. Throws Error::bad_data where the evidence cannot carry them.
Estimate answer_of(const Evidence& evidence, accelerometer::Normalised fit);

}  // namespace tumble::accelerometer_tumble
