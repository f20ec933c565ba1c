#pragma once

#include <utility>
#include <vector>

#include "tumble/reduce/linear/linear.hpp"

/// Means of segments at rates, as straight lines and repeats use them.
namespace tumble::gyro_scale_factor {

using Segments = std::vector<const linear::SegmentSummary*>;

/// Offset [SI of the output] and slope [per rad/s] by least squares of segment means.
std::pair<double, double> straight(const Segments& segments);

/// The segments that were measured, in time.
Segments all_of(const linear::Solution& solution);

/// Segments at one rate, to a ten-thousandth of the range. Given: range [rad/s].
std::vector<Segments> groups_of(Segments segments, double range);

/// Mean of what was measured [SI of the output].
double mean_of(const Segments& group);

}  // namespace tumble::gyro_scale_factor
