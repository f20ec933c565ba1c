#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tumble/methods/method.hpp"

/// Simulated tests of the methods whose answers are known. They are compiled into the test programs alone: CMake lists
/// the files methods/<method>/testing/trials.cpp.
namespace tumble {

/// A simulated test whose answer is known.
struct Trial {
  Evidence evidence;                                  ///< plan with resolved settings, and the recordings
  std::vector<std::pair<std::string, double>> truth;  ///< parameter name, true value [SI]
};

/// Tests of a method by simulation, `<method>::trials`. Evidence is drawn with the seed, from a truth that every seed
/// shares.
struct Trials {
  Trial (*first)(std::uint64_t seed);
  /// A trial that differs from the first in what that one holds at zero or ideal: offsets, filters, gaps, outliers, the
  /// sign of every parameter. Null where none is written yet.
  Trial (*second)(std::uint64_t seed) = nullptr;
};

/// The trials of all methods, by the name of the method.
const std::vector<std::pair<std::string_view, const Trials*>>& trials_catalogue();

/// Throws    Error::internal where the method has none
const Trials& trials_of(const Method& method);
Trial trial_of(const Method& method, std::uint64_t seed);
Trial second_trial_of(const Method& method, std::uint64_t seed);

}  // namespace tumble
