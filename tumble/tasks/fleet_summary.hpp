#pragma once

#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble {

/// Common properties of the units of a fleet, parameter by parameter: mean and spread, why results differ, a chart in
/// order of production, units that do not belong, batches; with limits the capability, the risks of four decision
/// rules, and the guard band that follows from the fleet itself.
///
/// Given     folder      of tumble.fleet, or any folder with results of one method (.json)
///           parameters  names; empty: all
///           limits      "NAME.min", "NAME.max": with units
/// Returned  parameters, tables and curves of summary_of_model() and chart_of_archive() for each parameter; tables
///           `fleet` and `risk`; curves `distribution`
/// Throws    Error::bad_input for a folder without results, results of several methods, a parameter that none has;
///           Error::bad_data for fewer than three units
/// See       docs/fleet.md; docs/equations (8.26)-(8.28)
Estimate summarise_fleet(const std::string& folder, const std::vector<std::string>& parameters, const Sets& limits);

}  // namespace tumble
