#pragma once

#include <string>

#include "tumble/core/plan.hpp"

namespace tumble {

/// A plan from its text, which need not be in the file yet. `path` is where it will be: names of files are relative to
/// its folder. Throws as load_plan() does.
Plan plan_of_text(const std::string& text, const std::string& path);

}  // namespace tumble
