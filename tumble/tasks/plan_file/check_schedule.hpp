#pragma once

#include "tumble/core/plan.hpp"
#include "tumble/core/tables/section.hpp"

namespace tumble {
struct Rig;
}

namespace tumble::plan_file {

using tables::FileProblems;
using tables::Section;

/// What the rig cannot do of the plan's schedule, each problem with the line of its segment or option. Where every
/// segment has a recording of its own, they are looked at one by one: nobody asks how the rig went from one to the
/// next. `root` is the whole plan.
void check_schedule(const Plan& plan, const Rig& rig, Section& root, FileProblems& problems);

}  // namespace tumble::plan_file
