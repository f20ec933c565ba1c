#pragma once

#include "tumble/core/schedule.hpp"
#include "tumble/core/tables/section.hpp"

namespace tumble {
struct Rig;
}

namespace tumble::plan_file {

using tables::Problems;
using tables::Section;

/// The [[schedule]] tables: every segment once for each of its runs, in order of run, durations filled in where the
/// speed of a ramp or slew gives them. `rig` is null where the plan names none.
Schedule read_schedule(const toml::array& tables, const Rig* rig, Problems& problems);

}  // namespace tumble::plan_file
