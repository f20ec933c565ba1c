#pragma once

#include "tumble/core/plan.hpp"
#include "tumble/core/tables/section.hpp"

namespace tumble {
struct Rig;
}

namespace tumble::plan_file {

using tables::FileProblems;
using tables::Section;

/// Adds problems: motions of the plan's schedule that the rig cannot do, each with the line of its segment or option.
/// Where every segment has a recording of its own, they are looked at one by one: how the rig went from one to the next
/// does not matter. `root` is the whole plan.
void check_schedule(const Plan& plan, const Rig& rig, Section& root, FileProblems& problems);

}  // namespace tumble::plan_file
