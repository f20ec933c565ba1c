#pragma once

#include <vector>

#include "tumble/core/plan.hpp"
#include "tumble/core/recording.hpp"

namespace tumble {

/// A catalogue entry of checks/: looks at a recording and reports its faults. Never throws for faulty data.
struct Check {
  const char* name;
  const char* summary;
  /// `plan` may be null.
  Findings (*run)(const Recording& recording, const Plan* plan);
};

/// All checks, the findings in the order of the catalogue.
Findings run_checks(const Recording& recording, const Plan* plan);

/// Finding about a stated rate [Hz] that the clocks of a recording contradict; the nearest clock is compared with it.
/// It is a note, and a warning where the difference is more than 3 %, or more than 100 ppm beside counts, which are a
/// rate by the clock alone. Empty where the stamps do not exclude the stated rate.
Findings against_stated_rate(const Recording& recording, double stated);

/// All entries, in the order of their names.
const std::vector<const Check*>& check_catalogue();

}  // namespace tumble
