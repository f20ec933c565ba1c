#pragma once

#include <string>
#include <vector>

#include "tumble/models/model.hpp"

/// For the tests of models.
namespace tumble::testing {

/// [truth] of the model as a plan would write it; throws Error::bad_input for what it does not accept.
Settings truth_of(const Model& model, const std::vector<std::pair<std::string, std::string>>& written);

/// Input and terms of output number `output` for one Felt, coefficients as coefficients_of gives them.
double indicated(const Model& model, const Settings& truth, const Felt& felt, std::size_t output = 0);

}  // namespace tumble::testing
