#pragma once

#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/evidence.hpp"
#include "tumble/models/model.hpp"

/// The engine of linear identification for callers that have a table of terms and no method.
namespace tumble {

/// Terms of one output of a plan's instrument that a test is to show.
struct TermProblem {
  std::string channel;  ///< the output
  Regressor input;      ///< known part of it [SI]; empty: none
  std::vector<Term> columns;
  std::vector<std::string> leave_out_first;  ///< names, in this order, where the schedule cannot show all
  int oversampling = 1;                      ///< instants in each sample at which a moving rig is asked
  double settling = 0.0;                     ///< [s] dropped after the rig has settled in each segment
  double averaging = 1.0;                    ///< [s] of a block
};

/// The uncertainties at the plan's truth and noise, before a sample is taken; values are the truth. One estimate for
/// each problem, each as if it were alone: the rig is asked once for all.
std::vector<Estimate> predict_terms(const Plan& plan, const std::vector<TermProblem>& problems);

/// The terms from recordings.
Estimate identify_terms(const Evidence& evidence, const TermProblem& problem);

/// Fisher information of each segment of the plan's schedule on its own: of the columns, then of the errors common to
/// all segments in units of their standard deviation.
struct TermInformation {
  std::vector<std::string> errors;  ///< common errors: the rows after those of the columns
  std::vector<Matrix> of_segment;   ///< [SI]; zero where a segment gives no samples
};
TermInformation information_of_terms(const Plan& plan, const TermProblem& problem);

}  // namespace tumble
