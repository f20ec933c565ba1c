#pragma once

#include <string>

#include "tumble/core/plan.hpp"
#include "tumble/core/tables/section.hpp"
#include "tumble/methods/method.hpp"

namespace tumble::plan_file {

/// `prior = "archive"`, `prior = "population.json"` (relative to the plan's folder), or a table with `from` and
/// `verdicts`, "without" (default) or "with". `method` may be null.
PriorChoice read_prior(tables::Section& root, const std::string& folder, const Method* method,
                       tables::FileProblems& problems);

/// Why a method refuses a prior; empty: it takes one.
Sentence refusal_of_prior(const Method& method);

}  // namespace tumble::plan_file
