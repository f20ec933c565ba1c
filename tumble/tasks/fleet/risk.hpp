#pragma once

#include <string>
#include <vector>

#include "tumble/archive/statistics.hpp"
#include "tumble/core/estimate.hpp"
#include "tumble/tasks/noticed.hpp"

namespace tumble::fleet {

/// A parameter of which a summary is wanted.
struct WantedParameter {
  std::string name, model;
  ParameterLimits limits;  ///< [SI]
};

/// Results that concern all parameters together.
struct Overview {
  Table table;                     ///< one line a parameter
  std::vector<NoticedIn> noticed;  ///< findings of each parameter: those of one kind become one
};

/// The summary of one parameter, its chart in order of production, its distribution, and with limits the risks.
/// Throws as summary_of_model().
void add_parameter(const Archive& archive, const WantedParameter& wanted, Overview& overview, Estimate& all);

/// The overview becomes the first table, and the findings.
void finish(Overview& overview, Estimate& all);

}  // namespace tumble::fleet
