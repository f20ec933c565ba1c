#pragma once

#include <toml++/toml.h>

#include "tumble/tasks/plan_file/reading.hpp"

namespace tumble::plan_file {

/// The further instruments of [beside], in the order of the file, and the --set values that speak of them.
///
/// Given     truth   [truth] of the plan, which further instruments of the plan's own model have too
void read_beside(Reading& reading, const toml::table& tables, const toml::table& truth);

}  // namespace tumble::plan_file
