#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/evidence.hpp"
#include "tumble/core/progress.hpp"
#include "tumble/core/role.hpp"

namespace tumble {

/// One recording that is larger than memory, handed out block after block.
struct StreamedEvidence {
  Plan plan;
  /// Calls the sink with the next samples of the same channels, until all have been.
  std::function<void(const std::function<void(const Recording& block)>& sink)> play;
};

/// A catalogue entry of methods/: reduces recordings to an estimate.
struct Method {
  const char* name;
  const char* summary;
  const char* source;  ///< citation with equation numbers
  bool needs_plan;     ///< false: `tumble identify METHOD data.csv` works
  std::vector<Role> (*roles)();
  std::vector<Option> (*options)();
  /// Who calls it, and `predict` and `stream`, gives the answer its method, title, instrument and provenance.
  Estimate (*identify)(const Evidence& evidence, const Progress& progress);
  /// The results of the method have error models, which can be subtracted from a recording and exported.
  bool compensates = false;
  /// The uncertainties before the test is run, from the plan's schedule, rig and truth; null: the method cannot
  /// predict.
  Estimate (*predict)(const Plan& plan) = nullptr;
  /// The plans of recordings may be of other instruments than the plan that names them: parts tested on their own.
  bool several_instruments = false;
  /// The method builds on Plan::calibration where there is one; elsewhere a plan that names one is refused.
  bool takes_calibration = false;
  /// The parameters of the method belong to the instrument and have a normal uncertainty, so that the units tested
  /// before can be a prior; elsewhere a plan that asks for one is refused.
  bool takes_prior = false;
  /// Identifies as `identify` does, in bounded memory; null where the method needs all samples at once.
  Estimate (*stream)(const StreamedEvidence& evidence, const Progress& progress) = nullptr;
};

/// All entries, in the order of their names.
const std::vector<const Method*>& method_catalogue();

/// The entry of that name, or Error::unsupported with the nearest known name.
const Method& find_method(std::string_view name);

}  // namespace tumble
