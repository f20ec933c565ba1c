#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tumble/core/plan.hpp"
#include "tumble/tasks/optimisation/report.hpp"
#include "tumble/tasks/optimisation/standard.hpp"
#include "tumble/tasks/prediction/candidates.hpp"

namespace tumble::optimisation {

using Visits = std::vector<prediction::CandidateVisit>;

constexpr double shortest_dwell = 1.0;  ///< [s]

/// A plan being optimised.
struct Work {
  Plan plan;
  bool from_terms = false;        ///< schedules are compared by the table of terms: no method, or terms were asked for
  std::vector<std::string> only;  ///< terms asked for
  std::vector<int> runs;          ///< power-ups, each of which carries the same schedule out
  double time = 0.0;              ///< [s] of one power-up
  bool closing = false;           ///< the first position is repeated at the end
  double settling = 0.0;
  std::vector<prediction::Candidate> all;
  std::vector<std::string> terms;  ///< that can be distinguished: the exchange goes by their information
  std::vector<std::string> names;  ///< of the parameters by which schedules are compared
};

/// The plan with another schedule.
Plan with_schedule(const Plan& plan, Schedule schedule);

/// [s] of all segments.
double total_of(const Schedule& schedule);

/// Whether the plan's method predicts by a formula, not from simulated tests.
bool is_quick(const Work& work);

/// Visits as a schedule of exactly the time there is: what moves leave is shared out in proportion to the dwells.
Schedule fitted(const Work& work, Visits visits);

/// Half a sample for each segment may be over.
bool too_long(const Work& work, const Schedule& schedule);

/// A schedule with its prediction; where the rig or the method refuses it, the reason.
ScheduleRow predicted_row(const Work& work, const std::string& name, Schedule schedule);

/// Its prediction by the table of terms, which the exchange goes by.
std::optional<Estimate> by_terms(const Work& work, const ScheduleRow& one);

/// The plan's own schedule in the time there is.
Schedule own_in_time(const Work& work);

/// Candidates spread over all there are, one schedule: what this does not show nothing shows.
Plan everything(const Work& work);

/// The usual schedules that fit into the time.
std::vector<ScheduleRow> usual_rows(const Work& work, const std::vector<StandardSet>& standard);

}  // namespace tumble::optimisation
