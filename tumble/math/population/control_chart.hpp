#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tumble/math/population/spread.hpp"

namespace tumble {

/// How a chart is drawn and when it alarms.
struct ChartSettings {
  std::size_t baseline = 30;  ///< number of first points that say what is expected
  double lambda = 0.2;        ///< weight [1] of the newest point in the EWMA
  double reference = 0.5;     ///< k of the CUSUM [sd]
  double run_length = 370.4;  ///< average number of points to a false alarm, of EWMA and CUSUM
};

/// A result on a chart.
struct ChartPoint {
  double value = 0.0;   ///< [u]
  double sd = 0.0;      ///< [u], private part of its uncertainty
  double shared = 0.0;  ///< [u]: sd of the errors that changed for all since the baseline, such as a recalibrated rig
};

struct ChartState {
  double sigma = 0.0;           ///< [u], of the point about the expected value: day to day, and its own uncertainty
  double away = 0.0;            ///< [sigma], from the expected value
  double limit = 0.0;           ///< [u], 3 sigma with what is not known of the expected value and of sigma
  double ewma = 0.0;            ///< [u], about the expected value
  double ewma_limit = 0.0;      ///< [u]
  double up = 0.0, down = 0.0;  ///< CUSUM [sigma]
  bool beyond = false, drifting = false, shifted = false;  ///< alarms: of the point, of the EWMA, of the CUSUM
  std::vector<int> notes;  ///< Western Electric rules 2 to 4 that the point completes: notes, never alarms
};

/// Limits that follow from the settings alone; worked out once for many charts.
struct ChartLimits {
  double ewma = 0.0;   ///< L [1]
  double cusum = 0.0;  ///< h [sigma]
};

struct ControlChart {
  UnitSpread baseline;  ///< mean expected and day-to-day spread, of the baseline
  ChartLimits limits;
  std::vector<ChartState> points;
};

/// Control charts of repeated results of one unit, whose limits hold the day-to-day spread of the baseline and the
/// stated uncertainty of each point. EWMA and CUSUM begin after the baseline.
///
/// Given:    points [n] in order of time; settings with baseline >= 3 and below n.
/// Throws:   Error::bad_data for fewer points, and as spread_of_units(); Error::bad_input for settings out of range.
/// Accuracy: false alarms 0.0027 a point on average for any baseline of 10 points and more.
/// See:      docs/equations (8.20).
ControlChart control_chart(std::span<const ChartPoint> points, const ChartSettings& settings,
                           const ChartLimits& limits);

/// EWMA and CUSUM limits [1] for the run length of the settings. Throws Error::bad_input for settings out of range.
ChartLimits chart_limits(const ChartSettings& settings);

/// Points as independent standard normal numbers [1], whatever mean and sd are, from the third on; the first two are
/// NaN. For the EWMA and the CUSUM of a unit without a baseline, whose results are equally uncertain. A point beyond 3
/// does not enter mean and sd of the later ones.
///
/// See: docs/equations (8.21).
std::vector<double> self_starting(std::span<const double> values);

}  // namespace tumble
