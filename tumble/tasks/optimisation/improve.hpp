#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/plan.hpp"
#include "tumble/math/random.hpp"
#include "tumble/math/regression/optimal_design.hpp"
#include "tumble/tasks/optimisation/report.hpp"
#include "tumble/tasks/prediction/candidates.hpp"

namespace tumble::optimisation {

/// Measure by which schedules are compared: it goes by their predictions, and not by the search that found them.
struct Goal {
  std::vector<std::string> names;  ///< parameters
  std::vector<double> reference;   ///< [SI] sd that each is relative to
  std::vector<double> most;        ///< [SI] sd that each may have; +inf: any
  DesignCriterion criterion = DesignCriterion::A;
};

/// How good a schedule is: the smaller the better, first by `excess`.
struct Standing {
  double excess = 0.0;  ///< [1] largest sd beside what it may be; 1: none is larger
  double value = 0.0;   ///< [1] the criterion
  bool operator<(const Standing& other) const {
    return excess != other.excess ? excess < other.excess : value < other.value;
  }
};
/// +inf where the row has no estimate or lacks a parameter.
Standing standing_of(const ScheduleRow& row, const Goal& goal);
/// Whether no parameter is worse than it may be.
bool is_allowed(const Standing& standing);

/// A search by predictions.
struct Improving {
  const Plan& plan;
  Goal goal;
  std::size_t candidates = 0;                ///< of which visits may be made
  int steps = 0;                             ///< schedules that are predicted
  std::function<ScheduleRow(Schedule)> row;  ///< predicts
  std::function<std::optional<Schedule>(std::vector<prediction::CandidateVisit>)>
      fitted;  ///< of visits; none: too long
};

/// Moves time between the segments of a schedule, by whole turns and periods, as long as that makes it better.
ScheduleRow with_better_times(const Improving& search, ScheduleRow start, const RandomStream& random);

/// Exchanges, adds, drops and moves visits, and time between them, as long as that makes the schedule better.
ScheduleRow with_better_visits(const Improving& search, ScheduleRow start,
                               std::vector<prediction::CandidateVisit> visits, const RandomStream& random);

}  // namespace tumble::optimisation
