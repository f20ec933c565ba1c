#include <algorithm>
#include <array>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <cstdint>
#include <utility>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/methods/fog_thermal_bias/fit.hpp"

namespace tumble::fog_thermal_bias {
namespace {

using Point = Likelihood::Point;

/// Logarithms of N, B and K over their natural scale. At its lower end a term is almost absent: 1e-3 of the white level
/// of one average.
constexpr std::array<double, 3> least_level{-7.0, -7.0, -7.0}, greatest_level{2.0, 5.0, 5.0};
constexpr std::array<double, 3> first_level{-0.3, -1.5, -2.5};

constexpr double reach = 2.0;     ///< of one search along a line: a factor exp(2) = 7 of a level either way
constexpr double enough = 0.002;  ///< in -2 log L: a fall of one unit is a standard error, so this is 1/20 of one
constexpr int most_cycles = 12;

// Near its minimum -2 log L is flat: steps below 2^-8 of the line change it by less than `enough`.
constexpr int bits_of_a_step = 8;
constexpr std::uintmax_t most_tries = 12;  ///< of a line: by golden section alone they leave 0.3 % of its length

/// The steps along `direction` that stay between the least and the greatest levels, and within `reach`.
std::pair<double, double> steps_from(const Point& x, const Point& direction) {
  double low = -reach, high = reach;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (direction[i] == 0.0) continue;
    const double a = (least_level[i] - x[i]) / direction[i], b = (greatest_level[i] - x[i]) / direction[i];
    low = std::max(low, std::min(a, b));
    high = std::min(high, std::max(a, b));
  }
  return {low, high};
}

struct Best {
  Point x;
  double value;  ///< -2 log L [1]
};

/// Moves to the lowest value on a line, where it is lower than here.
void search(const Likelihood& likelihood, const Point& direction, Best& best) {
  const auto at = [&](double step) {
    Point y = best.x;
    for (std::size_t i = 0; i < y.size(); ++i) y[i] += step * direction[i];
    return y;
  };
  const auto [low, high] = steps_from(best.x, direction);
  if (!(low < high)) return;
  std::uintmax_t most = most_tries;
  const auto [step, value] = boost::math::tools::brent_find_minima([&](double s) { return likelihood(at(s)); }, low,
                                                                   high, bits_of_a_step, most);
  if (value < best.value) best = {at(step), value};
}

}  // namespace

// Each cycle searches along the three levels one by one, then along the way that the cycle went (Hooke and Jeeves,
// 1961): along it lies the minimum where the levels depend on each other.
Point Likelihood::most_likely() const {
  Best best{{first_level.begin(), first_level.end()}, 0.0};
  best.value = (*this)(best.x);
  for (int cycle = 0; cycle < most_cycles; ++cycle) {
    const Best before = best;
    for (std::size_t i = 0; i < best.x.size(); ++i) {
      Point axis(best.x.size());
      axis[i] = 1.0;
      search(*this, axis, best);
    }
    if (before.value - best.value < enough) break;
    search(*this, difference(best.x, before.x), best);
  }
  return best.x;
}

}  // namespace tumble::fog_thermal_bias
