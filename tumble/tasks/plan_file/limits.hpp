#pragma once

#include <vector>

#include "tumble/core/plan.hpp"
#include "tumble/core/tables/document.hpp"
#include "tumble/core/tables/section.hpp"

namespace tumble::plan_file {

/// The sections [[limit]]. What is wrong is added to `problems`.
std::vector<LimitEntry> read_limits(const toml::array& tables, tables::FileProblems& problems);

}  // namespace tumble::plan_file
