#pragma once

#include <string>

#include "tumble/archive/deposit.hpp"

namespace tumble {

/// Parts of a run that an archive keeps: plan, station, units, equipment with its certificates, what happened, and the
/// sealed recordings. The run has to be sealed; one that was carried on afterwards is another entry.
///
/// Given     run  its folder
/// Throws    Error::bad_file: no live store, a recording that was not sealed or has changed since; as load_plan()
Deposit deposit_of_run(const std::string& run);

/// Whether a folder is that of a run.
bool is_run_folder(const std::string& folder);

}  // namespace tumble
