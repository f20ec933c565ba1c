#pragma once

#include <span>
#include <vector>

#include "tumble/reduce/linear/rows.hpp"

/// One output on its way from evidence or plan to a solution.
namespace tumble::linear {

struct Work {
  Evidences evidence;
  Rows rows = {};
  std::vector<std::size_t> used = {};     ///< columns of the problem that the evidence shows
  std::vector<double> coefficients = {};  ///< [SI] of all columns, on which the effects of the rig's errors depend
  KnownEffect counting = {};              ///< of whole pulses
  MixedData data = {};
  Solution solution = {};          ///< of this output alone
  double rounding_sd = 0.0;        ///< [SI] of the mean of a segment, by the steps of a coarse output
  std::vector<bool> rounded = {};  ///< segments that are off by it
};

/// The columns and coefficients of one output from its rows, before the effects of the errors of the rig are known.
void prepare(const Evidence& evidence, const Problem& problem, Work& work);
void prepare(const Problem& problem, const Truth& truth, Work& work);

/// The solution of one output, with the effects that `data` has.
void finish(const Evidence& evidence, const Problem& problem, Work& work);
void finish(const Problem& problem, const Truth& truth, Work& work);

/// The work [SI] on every output of one instrument. The rig is asked once for outputs that were sampled together.
///
/// Throws    Error with all that any of them complains of
std::vector<Work> worked_out(const Evidence& evidence, std::span<const Problem> problems);
std::vector<Work> worked_out(const Plan& plan, std::span<const Problem> problems, std::span<const Truth> truths);

inline constexpr const char* rounding_source = "rounding of the output";

/// Adds the doubt of a solution as one source more to a fit in which its columns stand from `first` on.
void add_doubt(const Solution& solution, std::size_t first, MixedFit& fit);

/// Puts the model's value X b of every row [SI] into the solution's segments.
void set_fitted(Work& work, std::span<const double> fitted);

}  // namespace tumble::linear
