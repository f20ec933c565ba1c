#pragma once

#include <optional>
#include <string>

#include "tumble/tasks/validation/bench.hpp"

namespace tumble::validation {

/// A departure and what it happens to.
struct Cell {
  const Departure* departure = nullptr;
  std::string target;
};

/// Each departure that the options ask for with each thing that it can happen to, in the order of the catalogue.
/// Throws as validate().
std::vector<Cell> cells_of(const Bench& bench, const ValidateOptions& options);

/// Tests [1] that a cell takes about: see study().
inline constexpr std::size_t tests_of_a_cell = 20;

/// The sizes of a departure that move a parameter and that are named, by a search on a logarithmic scale.
///
/// One seed gives the same noise with and without the departure, so that one pair of tests shows a shift. What is named is asked of
/// ten tests, and of fewer where the first ones decide: two that say nothing are enough.
///
/// Given     only  the one size that is tried; absent: it is searched from what the budget covers
/// Throws    Error::bad_input for an `only` of another dimension than the departure has
/// Returned  the study; or why no test with the departure can be made
struct Studied {
  DepartureStudy study;
  std::optional<Sentence> why_not = {};
  std::size_t tests = 0;  ///< that it took
};
Studied study(const Bench& bench, const Cell& cell, const std::optional<Quantity>& only);

}  // namespace tumble::validation
