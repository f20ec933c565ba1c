#pragma once

#include <string>
#include <vector>

#include "tumble/serve/routes/routes.hpp"

/// Numbers and units as pages show them.
namespace tumble::routes {

/// `value_si` [SI] in the unit, as JSON; null where it is not finite.
Json number(double value_si, const Unit& unit);
/// A value [u] with digits down to 1e-4 of `scale` [u].
std::string number_text(double value, double scale);
/// Units that people use for this dimension; the first is that of the file.
std::vector<std::string> units_like(const Unit& unit);

}  // namespace tumble::routes
