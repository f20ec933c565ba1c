#pragma once

#include "tumble/core/estimate.hpp"

namespace tumble {

/// Sources that give no parameter a thousandth of its variance become one line, `all other errors`; those that give
/// nothing go.
void gather_small(Estimate& estimate);

}  // namespace tumble
