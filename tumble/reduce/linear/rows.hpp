#pragma once

#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "tumble/reduce/linear/linear.hpp"
#include "tumble/reduce/linear/moves.hpp"
#include "tumble/reduce/stretches.hpp"
#include "tumble/rigs/rig.hpp"

/// From plans and recordings to the rows of a mixed model.
namespace tumble::linear {

/// How the samples of a stretch are averaged.
struct Blocking {
  bool even = false;  ///< the rig turns, but what is felt hardly changes: blocks as if it were steady
  std::size_t per_block = 1;
  Instants instants = {};  ///< of a move that is used as one total; else empty
};

/// The test as carried out, and the blocks of each stretch.
struct Evidences {
  ConductedTest test;
  std::vector<Blocking> blocking;  ///< one a stretch

  /// At rest, or in blocks as if it were: all rows have one mean.
  bool uniform(std::size_t stretch) const { return test.stretches[stretch].steady || blocking[stretch].even; }
};

Evidences evidence_of(const Evidence& evidence, const Problem& problem);
Evidences evidence_of(const Plan& plan, const Problem& problem);

/// Averages over blocks: the same samples in output, input and columns.
struct Rows {
  Matrix design;
  std::vector<double> input, output;  ///< [SI]; output empty where predicted
  std::vector<double> weights;        ///< [s] of samples present
  std::vector<double> time;           ///< [s] since power-on, mean of the samples
  std::vector<std::size_t> segment;   ///< index of the stretch
  std::vector<std::size_t> block;     ///< counted in the stretch
  std::vector<SegmentSummary> segments;
  std::vector<double> natural;  ///< size of each column were all that is felt along all axes at its greatest
};

/// Greatest frequency [Hz] at which what is felt repeats: oscillations, and turns of the axes in gravity.
double quickest(const Segment& segment);

/// Whether a sample counts in the mean of its block; where nothing is measured all do.
bool present(const Stretch& stretch, std::size_t sample);

/// One output and its evidence.
struct Read {
  const Evidences& evidence;
  const Problem& problem;
};

/// Whether two outputs were read at the same samples of the same test, missing ones apart.
bool read_together(const Read& a, const Read& b);

/// The outputs that were read together: lists of their numbers, each in order, by their first ones.
/// Given: together, whether the outputs with these two numbers were.
std::vector<std::vector<std::size_t>> groups_of(std::size_t outputs,
                                                const std::function<bool(std::size_t, std::size_t)>& together);

/// The rows [SI] of each output. The rig is asked once for outputs that were read together.
std::vector<Rows> rows_of(std::span<const Read> outputs);

Rows rows_of(const Evidences& evidence, const Problem& problem);

/// One output of an instrument that has these coefficients [SI], one a column of the problem.
struct Shown {
  const Evidences& evidence;
  const Problem& problem;
  const Rows& rows;
  const std::vector<double>& coefficients;
};

/// Shift of every row of each output by one standard deviation of each error of the rigs and of its reading. The rig is
/// asked once for outputs whose rows are at the same samples. Columns [SI].
std::vector<std::vector<KnownEffect>> effects_of(std::span<const Shown> outputs);

/// The effects [SI] of a single output.
std::vector<KnownEffect> effects_of(const Evidences& evidence, const Problem& problem, const Rows& rows,
                                    const std::vector<double>& coefficients);

/// Effect of rounding to whole pulses on the means of steady stretches. Its share in the scatter of their blocks, whose
/// errors cancel in the mean, is removed from `rows`; elsewhere it remains in the white noise.
///
/// Each reading of the counter is off by a part of a pulse with variance 1/12; the total of a stretch by two of them.
KnownEffect take_out_counting(const Evidences& evidence, const Problem& problem, Rows& rows);

}  // namespace tumble::linear
