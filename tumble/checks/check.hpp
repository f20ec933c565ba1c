#pragma once

#include <vector>

#include "tumble/core/plan.hpp"
#include "tumble/core/recording.hpp"

namespace tumble {

/// A catalogue entry of checks/: looks at a recording and says what is odd. Never throws for odd data.
struct Check {
  const char* name;
  const char* summary;
  /// `plan` is null when there is none.
  Findings (*run)(const Recording& recording, const Plan* plan);
};

/// All checks, the findings in the order of the catalogue.
Findings run_checks(const Recording& recording, const Plan* plan);

/// All entries, in the order of their names.
const std::vector<const Check*>& check_catalogue();

}  // namespace tumble
