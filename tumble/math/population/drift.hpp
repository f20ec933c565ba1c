#pragma once

#include <span>
#include <vector>

#include "tumble/math/matrix.hpp"

namespace tumble {

/// One result in the history of a unit since its last adjustment.
struct Visit {
  double time = 0.0;   ///< [s] since the adjustment, >= 0, in order
  double value = 0.0;  ///< [u]
  double sd = 0.0;     ///< [u], > 0: private uncertainty and day-to-day spread
};

/// The visits of one unit, and what its model says of the trend.
struct UnitHistory {
  std::vector<Visit> visits;
  double rate = 0.0;     ///< [u/s], mean of the model's population
  double rate_sd = 0.0;  ///< [u/s], its spread; infinite: nothing is known of the trend
  Matrix shared = {};    ///< [visits x k] [u]: signed factor of each error that visits share by key (8.2); empty: none
};

/// Possible random walks of a model, q [u/sqrt(s)], with their probabilities [1].
struct WalkDensity {
  std::vector<double> walk, weight;
};

/// Density of the random walk [u/sqrt(s)] of a model from the histories of all its units: the product of their
/// restricted likelihoods with a flat prior in q. Few visits of one unit alone say almost nothing; `histories` of many
/// units do.
///
/// Throws: Error::bad_data where no unit has two visits, for visits out of order or without an uncertainty.
/// See:    docs/equations (8.23), (8.25).
WalkDensity walk_of_units(std::span<const UnitHistory> histories);

/// The true value [u] of a unit at a time.
struct Forecast {
  double value = 0.0, variance = 0.0;  ///< [u], [u^2]
};

/// theta(t) = a + b t + q W(t) given the visits and q, by generalised least squares. Given: time [s] at or after the
/// last visit. See: docs/equations (8.23), (8.24).
Forecast forecast(const UnitHistory& history, double walk, double time);

/// The trend of a unit [u/s].
struct DriftRate {
  double value = 0.0, sd = 0.0;  ///< [u/s]
};
/// b of (8.23) given the visits, what the model says of it, and q [u/sqrt(s)]. See: docs/equations (8.23).
DriftRate drift_rate(const UnitHistory& history, double walk);

struct RecalibrationInterval {
  double interval = 0.0;                 ///< [s] after the last visit; 0: the probability is above the risk today
  double shortest = 0.0, longest = 0.0;  ///< [s] for the 95 % and the 5 % point of the random walk
};

/// First time after the last visit at which the true value is outside the limits with a probability above `risk` [1].
///
/// Given:    limits [u], one of them may be infinite; risk between 0 and 1; the longest interval of interest [s].
/// Accuracy: true risk 0.045 to 0.055 for 0.05 where q comes from 30 units of three visits and more.
/// See:      docs/equations (8.25).
RecalibrationInterval recalibration_interval(const UnitHistory& history, const WalkDensity& walks, double lower,
                                             double upper, double risk, double longest);

}  // namespace tumble
