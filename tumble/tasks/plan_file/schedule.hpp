#pragma once

#include "tumble/core/schedule.hpp"
#include "tumble/core/tables/section.hpp"
#include "tumble/tasks/stopping_rule.hpp"

namespace tumble {
struct Rig;
}

namespace tumble::plan_file {

using tables::FileProblems;
using tables::Section;

/// The [[schedule]] tables: every segment once for each of its runs, in order of run, durations filled in where the
/// speed of a ramp or slew gives them. `rig` is null where the plan names none.
Schedule read_schedule(const toml::array& tables, const Rig* rig, FileProblems& problems);

/// The keys `until` and `at_least` of a segment, whose duration [s] is stated or not.
std::optional<StoppingRule> read_stopping_rule(Section& section, std::optional<double> duration);

}  // namespace tumble::plan_file
