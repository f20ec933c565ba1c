#pragma once

#include <string>
#include <vector>

#include "tumble/exchange/comparison.hpp"
#include "tumble/serve/routes/routes.hpp"

namespace tumble::routes {

/// Shows parameters in other units: "bias~deg/s". Throws Error::bad_input for an unknown parameter and a unit of
/// another dimension.
void show_in_units(const std::vector<std::string>& units, Estimate& estimate);

/// A result as a page shows it: texts of values, shares of the budget, correlation, provenance.
Json json_of_result(const Estimate& estimate, Language language);

/// Results as a page compares them: differences with E_n of results of one instrument, and each parameter over the
/// results.
Json json_of_comparison(std::vector<NamedResult> results, Language language);

}  // namespace tumble::routes
