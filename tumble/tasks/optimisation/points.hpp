#pragma once

#include <string>
#include <vector>

#include "tumble/math/regression/optimal_design.hpp"
#include "tumble/tasks/prediction/candidates.hpp"
#include "tumble/tasks/prediction/problem.hpp"

namespace tumble::optimisation {

/// Candidates as points of a design: effort is time [s], parameters are the terms of all outputs and then the rig's
/// errors that are common to all segments, each in units of its standard deviation.
struct DesignSpace {
  std::vector<std::string> terms;
  std::vector<std::string> errors;
  std::vector<DesignPoint> points;  ///< one a candidate
};

/// The information that each candidate gives is calculated for two durations, `dwell` and twice that [s]; from these
/// follow what grows with time and what does not (see DesignPoint). Errors that shift no output noticeably beside the
/// white noise of `time` [s] are not used.
DesignSpace design_space(const Plan& plan, const std::vector<prediction::Candidate>& all,
                         const std::vector<prediction::OutputProblem>& outputs, double time, double dwell);

/// The point with I(dwell) = at_once and I(2 dwell) = at_twice, both [p x p]; dwell [s].
DesignPoint point_of(const Matrix& at_once, const Matrix& at_twice, double dwell);

}  // namespace tumble::optimisation
