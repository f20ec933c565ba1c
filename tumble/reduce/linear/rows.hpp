#pragma once

#include <map>
#include <string>
#include <vector>

#include "tumble/reduce/linear/linear.hpp"
#include "tumble/reduce/linear/moves.hpp"
#include "tumble/rigs/rig.hpp"

/// From plans and recordings to the rows of a mixed model.
namespace tumble::linear {

/// One power-up of one plan and what its rig does then, without errors.
struct PowerUp {
  const Plan* plan = nullptr;
  std::size_t plan_number = 0;  ///< counts the different plans
  RigRun rig;
  Reference reference;
  double step = 0.0;           ///< [s] between points at which the rig is asked
  double offset = 0.0;         ///< [s] of its first segment in the schedule of the power-up it is part of
  std::vector<double> begins;  ///< [s] of each segment, and the end of the last
};

/// The samples of one segment that are used: evenly spaced, times [s] since power-on.
struct Stretch {
  std::size_t power_up = 0;
  std::size_t segment = 0;  ///< in the power-up
  std::string label;
  int run = 1;
  std::size_t recording = 0;   ///< index in Evidence::recordings; 0 where predicted
  double power_on = 0.0;       ///< [s] on the recording's clock
  double first = 0.0;          ///< stamp of the first sample
  double step = 0.0;           ///< between samples
  std::size_t samples = 0;     ///< present or missing
  std::vector<double> values;  ///< [SI of the output], NaN: missing; empty: predicted
  bool steady = false;
  bool even = false;  ///< the rig turns, but what is felt hardly changes: blocks as if it were steady
  std::size_t per_block = 1;
  Instants whole = {};  ///< a move that is used whole, as one block: the instants that stand for it; else empty
};

struct Evidences {
  std::vector<PowerUp> power_ups;
  std::vector<Stretch> stretches;
  std::size_t plans = 0;  ///< how many different ones there are
  Findings findings;
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

Rows rows_of(const Evidences& evidence, const Problem& problem);

/// Shift of every row by one standard deviation of each error of the rigs and of the reading, where the instrument has
/// these coefficients (one a column).
std::vector<KnownEffect> effects_of(const Evidences& evidence, const Problem& problem, const Rows& rows,
                                    const std::vector<double>& coefficients);

/// What rounding to whole pulses does to the means of steady stretches. Its share in the scatter of their blocks, whose
/// errors cancel in the mean, is taken out of `rows`; elsewhere it is left in the white noise.
///
/// Each reading of the counter is off by a part of a pulse with variance 1/12; the total of a stretch by two of them.
KnownEffect take_out_counting(const Evidences& evidence, const Problem& problem, Rows& rows);

}  // namespace tumble::linear
