#pragma once

#include "tumble/core/estimate.hpp"
#include "tumble/reduce/compensate.hpp"

namespace tumble {

/// Report of a compensation, as a result without parameters that every front end shows and draws: each compensated
/// channel before and after, and what was subtracted with its uncertainty, as means over at most 2000 blocks.
///
/// Given     result  whose error model was subtracted
///           before  the recording; the compensated one has the same samples
/// Returned  curves [SI], findings and tables of the compensation; bands are two standard uncertainties
Estimate compensation_report(const Estimate& result, const Recording& before, const Compensation& done);

}  // namespace tumble
