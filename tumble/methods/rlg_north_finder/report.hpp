#pragma once

#include "tumble/methods/rlg_north_finder/closed_form.hpp"
#include "tumble/methods/rlg_north_finder/outputs.hpp"

namespace tumble::rlg_north_finder {

/// Table `positions`: angles, counts measured and predicted of each output, residuals. Without recordings the
/// predicted counts alone.
Table positions_table(const Plan& plan, const Summaries& segments);

/// Table `estimators`: values of both estimators, in the order of wanted() [SI].
Table estimators_table(const std::vector<double>& least_squares, const std::vector<double>& closed_form,
                       const Estimate& estimate);

/// Table `table_errors`: tilts and non-orthogonality by (2.19), beside what the rig states.
Table tilts_table(const Tilts& tilts, const Settings& rig);

/// A tilt far beyond what the rig states: its uncertainty is then no guide.
Findings tilt_faults(const Tilts& tilts, const Settings& rig);

/// Misalignments whose cosine takes more from a scale factor than its uncertainty: the body is not along the table.
Findings mounting_faults(const Estimate& estimate);

}  // namespace tumble::rlg_north_finder
