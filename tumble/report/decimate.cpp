#include "tumble/report/decimate.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tumble {
namespace {

/// The stretch that each point belongs to, never decreasing.
std::vector<std::size_t> stretches(const std::vector<double>& x, bool logarithmic, std::size_t count) {
  std::vector<double> position(x.size());
  const auto place = [&](double value) { return logarithmic ? std::log(value) : value; };
  std::transform(x.begin(), x.end(), position.begin(), place);
  const bool finite = std::all_of(position.begin(), position.end(), [](double p) { return std::isfinite(p); });
  if (!finite || !std::is_sorted(position.begin(), position.end()) || position.front() == position.back()) {
    std::iota(position.begin(), position.end(), 0.0);
  }
  const double first = position.front(), range = position.back() - first;
  std::vector<std::size_t> result(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double share = (position[i] - first) / range;
    result[i] = std::min(count - 1, static_cast<std::size_t>(share * static_cast<double>(count)));
  }
  return result;
}

/// Marks in [first, last) the smallest or largest of the finite values, and the first that is not finite.
void mark_extreme(const std::vector<double>& values, std::size_t first, std::size_t last, bool largest,
                  std::vector<bool>& marked) {
  std::size_t best = last, gap = last;
  for (std::size_t i = first; i < last; ++i) {
    if (!std::isfinite(values[i])) {
      gap = std::min(gap, i);
    } else if (best == last || (largest ? values[i] > values[best] : values[i] < values[best])) {
      best = i;
    }
  }
  if (best < last) marked[best] = true;
  if (gap < last) marked[gap] = true;
}

}  // namespace

std::vector<std::size_t> points_to_draw(const std::vector<double>& x, const std::vector<double>& y,
                                        const std::vector<double>& lower, const std::vector<double>& upper,
                                        bool logarithmic, std::size_t most) {
  std::vector<std::size_t> indices;
  if (x.size() <= most) {
    indices.resize(x.size());
    std::iota(indices.begin(), indices.end(), std::size_t{0});
    return indices;
  }
  // Two extremes of y, one gap, two of the band: at most five points a stretch (gaps of y and its band coincide).
  const auto stretch = stretches(x, logarithmic, most / 5);
  std::vector<bool> marked(x.size());
  marked.front() = marked.back() = true;
  for (std::size_t first = 0; first < x.size();) {
    const auto last = static_cast<std::size_t>(
        std::upper_bound(stretch.begin() + static_cast<std::ptrdiff_t>(first), stretch.end(), stretch[first]) -
        stretch.begin());
    mark_extreme(y, first, last, false, marked);
    mark_extreme(y, first, last, true, marked);
    if (!lower.empty()) mark_extreme(lower, first, last, false, marked);
    if (!upper.empty()) mark_extreme(upper, first, last, true, marked);
    first = last;
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (marked[i]) indices.push_back(i);
  }
  return indices;
}

}  // namespace tumble
