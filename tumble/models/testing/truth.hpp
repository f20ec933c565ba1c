#pragma once

#include <string>
#include <vector>

#include "tumble/math/random.hpp"
#include "tumble/models/model.hpp"

/// For the tests of models.
namespace tumble::testing {

/// [truth] of the model as a plan would write it; throws Error::bad_input for what it does not accept.
Settings truth_of(const Model& model, const std::vector<std::pair<std::string, std::string>>& written);

/// Input and terms of output number `output` for one Felt, coefficients as coefficients_of gives them.
double indicated(const Model& model, const Settings& truth, const Felt& felt, std::size_t output = 0);

/// How many problems the model's physics refuses this [truth] for, as bad input; 0: it accepts it.
std::size_t problems_of(const Model& model, const Settings& truth);

/// Vector number `number` of a stream, each component uniform in +-largest.
Vector3 any(const RandomStream& random, std::uint64_t number, double largest);

}  // namespace tumble::testing
