#pragma once

#include "tumble/reduce/linear/linear.hpp"

/// A mechanism that looks for terms that the model lacks (decision 121).
namespace tumble::linear {

struct Work;

/// One finding for the term of the catalogue that explains what the model leaves better than all others, if a sound test
/// shows as much once in 10 000 of such tests: an output that is larger on one side, not linear, late, drifts with time or
/// steps, repeats with the angle of an axis, or shows a known input with another size. Each is tried by its course within
/// the segments, compared with the noise there, and by the means of the segments, compared with their scatter; then the
/// test is fitted once more with it, which gives its size and how far the parameters would move. A warning where one moves
/// by half its uncertainty, else an info.
///
/// By how much the parameters would move is the solution's `doubt`, also where nothing is said: a term that a sound test shows
/// once in 20 is suspected. Of terms that explain the data nearly alike, each has the part of its likelihood.
void warn_of_missing_terms(const Problem& problem, Work& work);

}  // namespace tumble::linear
