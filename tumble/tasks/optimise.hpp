#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/plan.hpp"
#include "tumble/core/progress.hpp"
#include "tumble/math/regression/optimal_design.hpp"

namespace tumble {

struct OptimiseOptions {
  DesignCriterion criterion = DesignCriterion::A;  ///< which of the two designs becomes the schedule
  std::optional<double> total_time;                ///< [s] of all power-ups together; absent: the plan's own
  std::vector<std::string> terms;                  ///< limits the parameters to these; empty: all that can be shown
  double step = 0.2617993877991494;                ///< [rad] of the grid of positions: 15 deg
  int steps = 300;  ///< of the search by predictions after the exchange; where these are of simulated tests, fewer
};

struct Optimised {
  Estimate estimate;  ///< predicted for the schedule found, with the tables `schedules`, `schedule_sd` and `schedule`
  Schedule schedule;
};

/// The positions, rates and dwell times with the smallest uncertainties that the plan's rig allows in a given time,
/// beside the plan as it is and the usual schedules in the same time.
///
/// Candidates are what the plan's own schedule does, on a grid: holds of the axes that it moves, rates where it has
/// rates, oscillations where it has oscillations, mountings where it mounts. An exchange (see exchange()) chooses among
/// them and shares out the time; moves and settling count. All schedules are then predicted as `predict` does, in the
/// order in which they would be run.
///
/// D: the determinant of the covariance. A: the mean of (sd/reference)^2, the reference of a parameter being half the
/// width of its limits (one bound: its distance from the truth), else the sd that the plan as it is reaches, else the
/// sd of the D-optimal schedule.
///
/// Throws    Error::bad_input with all that plan and options lack, or where the time is too short for any schedule
Optimised optimise(const Plan& plan, const OptimiseOptions& options, const Progress& progress);

/// The text of the plan with its schedule replaced by `schedule`. Throws Error::bad_input, bad_file.
std::string plan_with_schedule(const Plan& plan, const Schedule& schedule);

}  // namespace tumble
