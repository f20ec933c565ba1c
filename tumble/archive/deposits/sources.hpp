#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"

/// Errors of a result that other results share (docs/equations (8.2)).
namespace tumble::deposits {

/// An error that another result has too, where it has one of the same name: source and key of the line of the budget,
/// and which of its errors.
struct KeyedError {
  std::string name;
  double factor = 0.0;  ///< [SI], signed: shift of the parameter by one standard deviation of the error
};

/// The keyed errors of a parameter, in order of name. A simulation shares none with any other result: its seed draws
/// all errors anew. Errors that give less than a ten-thousandth of the variance are not listed.
std::vector<KeyedError> keyed_errors(const Estimate& estimate, std::size_t parameter);

/// Shared and private parts of the uncertainty of a parameter, in two numbers.
struct ErrorSources {
  double private_sd = 0.0;   ///< [SI], of the errors that no other result shares
  std::int64_t sources = 0;  ///< from names and signs of the keyed errors; 0: there is no such error
};
ErrorSources sources_of(const Estimate& estimate, std::size_t parameter);

}  // namespace tumble::deposits
