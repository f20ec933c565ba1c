#pragma once

#include <cstddef>
#include <vector>

namespace tumble {

/// Points of a long curve to draw so that no peak is lost: all when there are at most `most`, else in each of
/// `most`/5 stretches of x (of log x, or of the index where x runs back and forth) those where y or the band are
/// smallest and largest; the first and the last of the curve always. Of points that are not finite one in each stretch
/// is kept, so that gaps stay gaps.
///
/// Given     x, y           [any unit] of equal length
///           lower, upper   of the same length, or empty
/// Returned  indices, ascending, about `most` at most
std::vector<std::size_t> points_to_draw(const std::vector<double>& x, const std::vector<double>& y,
                                        const std::vector<double>& lower, const std::vector<double>& upper,
                                        bool logarithmic, std::size_t most = 5000);

}  // namespace tumble
