#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/plan.hpp"

namespace tumble::optimisation {

/// A schedule and what it is predicted to reach.
struct ScheduleRow {
  std::string name;
  Schedule schedule;
  std::optional<Estimate> estimate;
  std::string refused;  ///< why it has no estimate
};

/// The estimate of the schedule chosen, with tables: `schedules` (criteria of every row), `schedule_sd` (sd of every
/// term), `schedule` (the segments chosen). Given: reference sd of each term [SI].
Estimate described(const Plan& plan, const ScheduleRow& chosen, const std::vector<ScheduleRow>& rows,
                   const std::vector<std::string>& terms, const std::vector<double>& reference);

}  // namespace tumble::optimisation
