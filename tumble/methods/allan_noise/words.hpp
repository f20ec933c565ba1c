#pragma once

#include <string>

#include "tumble/core/channel.hpp"
#include "tumble/math/noise/noise_likelihood.hpp"

namespace tumble::allan_noise {

/// p-values below it are shown as this one: the assumptions of a test do not hold so far out.
constexpr double least_shown_p = 1e-6;

/// How a term is called, written and shown for one kind of channel.
struct TermWords {
  std::string name, symbol, unit, description;
};
TermWords words(NoiseTerm term, QuantityKind kind);
/// Unit of a rate or a specific force, and of its ramp, for people.
std::string rate_unit(QuantityKind kind);
std::string ramp_unit(QuantityKind kind);

/// A squared coefficient [u^2] as the coefficient itself in SI: Q = T sqrt(c), N = sqrt(c T), B = sqrt(c), K =
/// sqrt(c/T).
double coefficient(NoiseTerm term, double squared, double rate);

}  // namespace tumble::allan_noise
