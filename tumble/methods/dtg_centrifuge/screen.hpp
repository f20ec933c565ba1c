#pragma once

#include <vector>

#include "tumble/methods/dtg_centrifuge/lines.hpp"

namespace tumble::dtg_centrifuge {

/// The levels that can be used, with findings for what is wrong with the others and weak in these.
/// Throws Error::bad_data with all reasons where no level remains.
std::vector<Measured> screened(std::vector<Measured> measured, const Test& test, bool fourier, Findings& findings);

/// Whether the reference gyro shows the Earth's rate at the heading as large as the site says.
void check_earth(const std::vector<Measured>& measured, const Test& test, Findings& findings);

}  // namespace tumble::dtg_centrifuge
