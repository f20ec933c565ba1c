#pragma once

#include <string>

#include "tumble/archive/archive.hpp"
#include "tumble/core/estimate.hpp"
#include "tumble/core/plan.hpp"

namespace tumble {

/// Reads what the plan's prior names: the population in a file that `tumble population` wrote, that of a result with a
/// prior, or, where it says "archive", that of the archive without the unit that the plan tests. Nothing is done where
/// the plan asks for none, or it was read before.
///
/// Given     archive  null: none is known
/// Throws    Error::bad_input without an archive, or for a population of another model or method; Error::bad_data where
///           it has too few units; Error::bad_file
void read_prior(Plan& plan, const Archive* archive = nullptr);

/// Gives an estimate what it would be with the plan's prior, a table and findings about it. `certain`: the values are
/// those of the plan's truth.
void add_prior(const Plan& plan, Estimate& estimate, bool certain = false);

}  // namespace tumble
