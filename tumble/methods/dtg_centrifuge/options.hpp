#pragma once

#include <vector>

#include "tumble/core/settings.hpp"

namespace tumble::dtg_centrifuge {

std::vector<Option> options();

/// Throws Error::bad_input with every setting that is out of bounds.
void refuse_impossible(const Settings& settings);

}  // namespace tumble::dtg_centrifuge
