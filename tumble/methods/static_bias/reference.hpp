#pragma once

#include <string>

#include "tumble/core/evidence.hpp"

namespace tumble::static_bias {

/// The input along the axis at rest, with what moves it by one standard deviation.
struct Reference {
  double along = 0.0;  ///< [u]
  std::string source;  ///< empty: nothing was subtracted
  double shift = 0.0;  ///< of the bias [u]
  std::string key;     ///< see Contribution
};

/// The Earth's rate [rad/s] or gravity [m/s^2] along the axis; with findings on the errors that the bias includes.
Reference reference_of(const Evidence& evidence, QuantityKind kind, Findings& findings);

}  // namespace tumble::static_bias
