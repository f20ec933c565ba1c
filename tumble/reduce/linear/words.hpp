#pragma once

#include "tumble/reduce/linear/linear.hpp"

namespace tumble::linear {

/// Findings for the columns that are not used, with the meaning that the others then have.
void describe_dropped(const Problem& problem, Solution& solution);

/// Where the segments differ from the model by 30 times what the noise within them explains: see answer_of.
void warn_of_misfit(const Solution& solution, const std::string& channel_unit, Findings& findings);

struct Work;

/// F tests of lack of fit over the segments at rest, each of which accuses one sound test in 1e5: whether the positions
/// differ from the model by more than their repeats from each other, and the repeats by more than the positions;
/// whether the output drifts with the time since power-on, or within the segments; whether what the model leaves
/// changes within them, also within those that move, in proportion to the step that led to them; whether an error of
/// the rig is far larger than stated. Slow noise, which is found from the segments, takes in what the model does not
/// hold: only its shape counts, not its size. Findings go into the work's solution.
void warn_of_lack_of_fit(const Problem& problem, Work& work);

/// Where the segments differ from the model by more than the bias instability as stated, white noise and the errors of the
/// rig let expect: generalised least squares of the segment means with this covariance alone, whose squares have a
/// chi-square distribution (F, as far as the white noise decides) in sound tests. The variances that the fit finds are
/// no part of it: few segments may show any, and flicker that all segments share is not seen in what they differ by.
void warn_of_excess(const Problem& problem, Work& work);

}  // namespace tumble::linear
