#pragma once

#include "tumble/core/plan.hpp"

namespace tumble::linear {

/// A schedule on a two-axis table that shows every term over angular motion: six faces, rates of both signs and two
/// sizes about one and two axes, oscillations about each axis.
void add_table_motions(Plan& plan);

}  // namespace tumble::linear
