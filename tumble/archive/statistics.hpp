#pragma once

#include <limits>
#include <string>

#include "tumble/archive/deposit.hpp"
#include "tumble/core/estimate.hpp"
#include "tumble/math/population/control_chart.hpp"

/// Statistics over the results of an archive. Each answer is an Estimate, so that every front end shows, draws and
/// writes it as it does results. The mathematics stands in math/population; docs/archive.md says what the tables hold.
namespace tumble {

/// Selection of results: of one parameter, of one unit or of all units of a model.
struct ArchivedSelection {
  std::string parameter;
  std::string model = {};  ///< empty: of all models, or of the model of the unit
  UnitName unit = {};      ///< empty: of all units
};

/// A chart of control. Points are days: results of one unit on one day are one point.
struct ChartRequest {
  ArchivedSelection what;
  bool every_day = false;                    ///< of all units: a point for each day of each unit, not one for each unit
  ChartSettings settings = {.baseline = 0};  ///< baseline 0: 30 points, or half of fewer than 60
};

/// Individuals, EWMA and CUSUM of a parameter over the results of one unit, or over the units of a model in order of
/// time: each point with the private part of its stated uncertainty, the limits with the spread from day to day (or
/// from unit to unit) of the baseline, and with what changed of the errors that all share since then.
///
/// Returned  parameters `NAME_expected`, `NAME_scatter`; tables `chart`, `alarms`; curves; findings
/// Throws    Error::bad_input where no result has the parameter; Error::bad_data for fewer than four points
/// See       docs/equations (8.20), (8.21)
Estimate chart_of_archive(const Archive& archive, const ChartRequest& request);

/// Limits of a parameter [SI]; infinite: no limit.
struct ParameterLimits {
  double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();
};

struct DriftRequest {
  ArchivedSelection what;                  ///< of one unit
  ParameterLimits limits = {};             ///< for the recalibration interval; without limits there is no interval
  double risk = 0.05;                      ///< [1] of being outside the limits at its end
  double longest = 10.0 * 365.25 * 86400;  ///< [s] interval of interest
};

/// How one unit has changed since it was last adjusted: E_n of each result with the one before and with the first,
/// shared errors subtracted; the drift, and when the parameter may leave its limits. The random walk of the model comes
/// from the histories of all its units.
///
/// Returned  parameters `NAME_drift_rate`, `NAME_random_walk`; tables `history`, `recalibration`; curves; findings
/// Throws    Error::bad_input where no result of the unit has the parameter
/// See       docs/equations (8.23)-(8.25); docs/compare.md
Estimate drift_of_unit(const Archive& archive, const DriftRequest& request);

struct SummaryRequest {
  ArchivedSelection what;       ///< of a model
  ParameterLimits limits = {};  ///< for the capability; without limits there is no capability
};

/// The units of a model: mean and spread, why results differ (unit, day, rig, repeat) with intervals, units that do not
/// belong to the others, a change in order of production, capability.
///
/// Returned  parameters `NAME_mean`, `NAME_unit_sd`, `NAME_day_sd`, `NAME_rig_sd`, `NAME_repeat_sd`, `NAME_capability`,
///           `NAME_capability_measured`; tables `components`, `outliers`, `batches`; curves; findings
/// Throws    Error::bad_input where no result has the parameter; Error::bad_data for fewer than three units
/// See       docs/equations (8.3)-(8.9), (8.26)-(8.30)
Estimate summary_of_model(const Archive& archive, const SummaryRequest& request);

}  // namespace tumble
