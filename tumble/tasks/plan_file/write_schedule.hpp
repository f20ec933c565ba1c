#pragma once

#include <string>
#include <vector>

#include "tumble/core/schedule.hpp"
#include "tumble/rigs/rig.hpp"

namespace tumble::plan_file {

/// The [[schedule]] tables of a plan as text, quantities in the units of the axes. Read again they are the same
/// schedule, bit for bit. Segments that several power-ups share, in the same order, are written once.
std::string schedule_text(const Schedule& schedule, const std::vector<Axis>& axes);

/// The text of a plan with its [[schedule]] tables replaced, where the first of them stood; everything else, comments
/// included, stays as it is. `file` for messages.
/// Throws Error::bad_input where the text is not TOML or holds its schedule in another form.
std::string with_schedule(const std::string& plan, const std::string& file, const std::string& schedule);

}  // namespace tumble::plan_file
