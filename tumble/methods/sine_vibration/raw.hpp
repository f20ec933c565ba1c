#pragma once

#include <limits>
#include <string>
#include <vector>

#include "tumble/core/evidence.hpp"
#include "tumble/methods/sine_vibration/measure.hpp"
#include "tumble/methods/sine_vibration/rectification.hpp"

/// The measured quantities of a vibration test, and their independent errors.
namespace tumble::sine_vibration {

inline constexpr double forever = std::numeric_limits<double>::infinity();

/// One independent error: the shift of the raw quantities by one standard deviation of it. Components of one group
/// share the degrees of freedom of their variance.
struct Component {
  std::string source;
  std::vector<double> shift;
  std::size_t group = 0;
  double degrees_of_freedom = forever;
};

/// The measured quantities before they are combined: the coefficients of every rectification, then ln gain of every
/// point.
struct Raw {
  std::vector<double> value;
  std::vector<std::vector<std::size_t>> coefficient;  ///< of each rectification: its ways, then the quartic one
  std::size_t first_gain = 0;
  std::vector<Component> components;
  std::size_t groups = 0;

  /// A component of a group of its own, without shifts [as `value`].
  Component& add(const std::string& source, double degrees_of_freedom = forever) {
    components.push_back({source, std::vector<double>(value.size(), 0.0), groups++, degrees_of_freedom});
    return components.back();
  }
};

/// A vector [1] of zeros with a one at index `at`.
std::vector<double> unit_vector(std::size_t size, std::size_t at);

/// The measured quantities with all their errors: noise, the shake of the shaker, scales, motion across the input axis.
Raw raw_of(const Evidence& evidence, const vibration::Data& data, const Measured& measured,
           const std::vector<Rectification>& rectified);

}  // namespace tumble::sine_vibration
