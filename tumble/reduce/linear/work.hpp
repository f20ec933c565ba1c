#pragma once

#include <span>
#include <vector>

#include "tumble/reduce/linear/rows.hpp"

/// One output on its way from evidence or plan to a solution.
namespace tumble::linear {

struct Work {
  Evidences evidence;
  Rows rows;
  std::vector<std::size_t> used;  ///< columns of the problem that the evidence shows
  MixedData data;
  Solution solution;         ///< of this output alone
  double rounding_sd = 0.0;  ///< [SI] of the mean of a segment at rest, by the steps of a coarse output
};

Work worked_out(const Evidence& evidence, const Problem& problem);
Work worked_out(const Plan& plan, const Problem& problem, const Truth& truth);

/// Puts the model's value X b of every row [SI] into the solution's segments.
void set_fitted(Work& work, std::span<const double> fitted);

}  // namespace tumble::linear
