#pragma once

#include <cstddef>
#include <string>

#include "tumble/archive/archive.hpp"
#include "tumble/core/estimate.hpp"

/// Populations of a model from the results of an archive. Results that were replaced, and those that were made with a
/// prior, do not count.
namespace tumble {

struct PopulationQuery {
  std::string model;
  std::string method;        ///< of the results; empty: the only one that there is
  std::string without = {};  ///< serial number of a unit that is not to be part of it
  std::size_t most = 300;    ///< units: those whose last result is the newest
};

/// The population of a model (exchange/populations.hpp). Each unit has one result in it: of those with the most
/// parameters the earliest, since a further unit is tested for the first time.
///
/// Throws    Error::bad_input where no unit of the model has a result, or several methods have; Error::bad_data as
///           population_of_units(); Error::bad_file
Estimate population_of(const Archive& archive, const PopulationQuery& query);

/// Components of variance of a parameter over all results of a model, at most the 2000 newest.
/// Throws    as population_of() and components_of_results()
Estimate components_of(const Archive& archive, const PopulationQuery& query, const std::string& parameter);

}  // namespace tumble
