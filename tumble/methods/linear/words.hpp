#pragma once

#include "tumble/methods/linear/linear.hpp"

namespace tumble::linear {

/// Findings for the columns left out, and what the others then stand for.
void describe_dropped(const Problem& problem, Solution& solution);

}  // namespace tumble::linear
