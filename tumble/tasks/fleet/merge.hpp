#pragma once

#include <string>

#include "tumble/core/estimate.hpp"

namespace tumble::fleet {

/// Adds the answer about one parameter to that about all: its tables and figures get the parameter's name.
/// Numbers of different parameters have no covariance: nothing is known of it.
void append(const Estimate& one, const std::string& parameter, Estimate& all);

}  // namespace tumble::fleet
