#pragma once

#include "tumble/reduce/linear/linear.hpp"

/// The noise of an output where its rig rests, and what is compared with it.
namespace tumble::linear {

struct Work;

/// A warning where what the model leaves within the segments that move is far more than the noise within those that rest: the
/// fit takes such misfit for noise, so that no comparison within the fit can show it. Where nothing rests, nothing is said.
///
/// See     warn_of_missing_terms, which names the term that explains it, where one does
void warn_of_motion(const Problem& problem, Work& work);

/// A warning for segments that begin while the output still changes: the first average of a segment at rest differs from those
/// of its second half by more than the noise of all second halves explains once in 10 000 tests. The rig was slower than
/// planned, the mark early, or the output slow.
void warn_of_begins(const Problem& problem, Work& work);

}  // namespace tumble::linear
