#pragma once

#include "tumble/core/plan.hpp"
#include "tumble/core/tables/document.hpp"
#include "tumble/core/tables/section.hpp"

namespace tumble::plan_file {

/// The section [site]. What is wrong is added to `problems`.
Site read_site(const toml::table& table, tables::FileProblems& problems);

}  // namespace tumble::plan_file
