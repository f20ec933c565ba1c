#pragma once

#include <string>
#include <vector>

#include "tumble/exchange/comparison.hpp"
#include "tumble/serve/routes/routes.hpp"

namespace tumble::routes {

/// Shows parameters in other units: "bias~deg/s". Throws Error::bad_input for an unknown parameter and a unit of
/// another dimension.
void show_in_units(const std::vector<std::string>& units, Estimate& estimate);

/// The lower triangle of the correlations, three digits after the point; null for one parameter and for more than 60.
Json correlation_json(const Estimate& estimate);
/// The lower triangle of the covariances as texts, in the units that are shown, row times column; null as before.
Json covariance_json(const Estimate& estimate);
/// The whole matrix for a spreadsheet, 12 digits; a cell is empty where there is no number.
std::string matrix_csv(const Estimate& estimate, bool correlation);

/// A result as a page shows it: texts of values, shares of the budget, correlation, provenance.
Json json_of_result(const Estimate& estimate, Language language);

/// Results as a page compares them: differences with E_n of results of one instrument, and each parameter over the
/// results.
Json json_of_comparison(std::vector<NamedResult> results, Language language);

}  // namespace tumble::routes
