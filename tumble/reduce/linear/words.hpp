#pragma once

#include "tumble/reduce/linear/linear.hpp"

namespace tumble::linear {

/// Findings for the columns that are not used, with the meaning that the others then have.
void describe_dropped(const Problem& problem, Solution& solution);

/// Where the segments differ from the model by 30 times what the noise within them explains: see answer_of.
void warn_of_misfit(const Solution& solution, const std::string& channel_unit, Findings& findings);

/// Where the segments differ by more than the bias instability that was stated.
///
/// Given     stated   rms of what it does to a segment [SI of the output]
void warn_of_excess(const Problem& problem, double stated, Solution& solution);

}  // namespace tumble::linear
