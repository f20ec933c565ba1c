#pragma once

#include <string>
#include <vector>

#include "tumble/reduce/linear/linear.hpp"

namespace tumble::gyro_scale_factor {

/// Segments at one rate, and how far their means lie from the straight line of all segments.
struct Departure {
  double rate = 0.0;   ///< mean of what was felt [rad/s]
  double value = 0.0;  ///< mean measured minus line, over slope times range [1]
  double sd = 0.0;     ///< of it, from the scatter of segment means
  std::size_t segments = 0;
};

/// A size of which the part that noise adds is subtracted.
struct Size {
  bool significant = false;  ///< beyond the scatter (99 %)
  double value = 0.0;
  double sd = 0.0;
  double limit = 0.0;  ///< 95 %, where it is not significant
};

struct Line {
  double offset = 0.0, slope = 0.0;  ///< least squares of all segment means [SI of the output, per rad/s]
  double range = 0.0;                ///< greatest rate [rad/s]
  double scatter = 0.0;              ///< sd of a segment mean [SI of the output]
  double rounding = 0.0;             ///< of it, by the steps of a coarse output: alike in all segments of one rate
  double degrees_of_freedom = 0.0;   ///< of the scatter
  std::string scatter_from;          ///< "repeated rates" or "misfit of the model"
  std::vector<Departure> departures;
  Size greatest, rms;         ///< of the departures
  Size hysteresis;            ///< greatest difference of means reached from below and from above
  std::size_t both_ways = 0;  ///< rates with both
};

/// `parameters`: how many the model has, for the degrees of freedom of its misfit.
Line line_of(const linear::Solution& solution, std::size_t parameters);

/// The smallest input (or change of input) that gives at least half of the output due.
struct Bracket {
  bool tried = false;    ///< three small inputs or more, each with little enough scatter
  bool bounded = false;  ///< some give less than half
  double
      value = 0.0,
      sd = 0.0;  ///< [rad/s] middle and half width over sqrt(3) of the smallest that does and the largest that does not
  double smallest = 0.0;  ///< [rad/s] tried
};
Bracket threshold_of(const linear::Solution& solution, const Line& line);
Bracket resolution_of(const linear::Solution& solution, const Line& line);

/// Scatter of offset and slope from power-up to power-up.
struct Repeatability {
  std::size_t runs = 0;
  Size bias;   ///< [rad/s]
  Size slope;  ///< relative
};
Repeatability repeatability_of(const linear::Solution& solution, const Line& line);

/// A warning where the segments at one rate change with the time between them: the bias, which is a change that all
/// rates share, or the scale factor, a change that is proportional to the rate. F tests of both against what remains of
/// the differences between segments at one rate, at a chance of 1e-9: at 1e-5, 2 of 60 sound tests that flicker noise
/// rules are accused. Without enough repeats of a rate nothing is said. A hysteresis in a single sweep up and down
/// looks alike.
Findings about_drift(const linear::Solution& solution, const Line& line);

/// An error for each segment that agrees with the rate of another one, and not with its own: with a line that a few wrong
/// segments do not move, it is 10 times the usual scatter off its rate, and within a tenth of that of another, which is 2 %
/// of the range and more away. Six segments at least.
Findings about_order(const linear::Solution& solution, const Line& line);

}  // namespace tumble::gyro_scale_factor
