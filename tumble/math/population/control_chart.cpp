#include "tumble/math/population/control_chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "tumble/math/population/run_length.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/square.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr double beyond_control = 3.0;  ///< [sd] a point farther away is not counted for the limits of later ones

constexpr double three_sigma = 0.99865;  ///< probability below 3 of a normal number

UnitSpread baseline_of(std::span<const ChartPoint> points, std::size_t count) {
  if (count < 3 || count >= points.size())
    throw Error(Error::Kind::bad_data,
                say("a chart of {} points cannot have a baseline of {}: at least 3, and points after it", points.size(),
                    count));
  std::vector<UnitValue> first;
  for (const auto& point : points.first(count)) first.push_back({point.value, point.sd});
  return spread_of_units(first);
}

/// Western Electric rules that the newest of these distances [sigma] completes: 2 of 3 beyond 2, 4 of 5 beyond 1, 8 on
/// one side.
std::vector<int> rules_of(std::span<const double> away) {
  std::vector<int> out;
  const auto beyond = [&](std::size_t window, std::size_t least, double limit) {
    if (away.size() < window) return false;
    const auto last = away.last(window);
    const auto above = static_cast<std::size_t>(std::ranges::count_if(last, [&](double z) { return z > limit; }));
    const auto below = static_cast<std::size_t>(std::ranges::count_if(last, [&](double z) { return z < -limit; }));
    return (above >= least && away.back() > limit) || (below >= least && away.back() < -limit);
  };
  if (beyond(3, 2, 2.0)) out.push_back(2);
  if (beyond(5, 4, 1.0)) out.push_back(3);
  if (beyond(8, 8, 0.0)) out.push_back(4);
  return out;
}

/// The running sums of a chart after its baseline.
struct Running {
  double ewma = 0.0, variance = 0.0, share = 0.0, up = 0.0, down = 0.0;

  /// `unknown` [u^2] of the expected value: shifts of up to twice its sd are none of the CUSUM.
  void take(double away, double sigma, double unknown, const ChartSettings& settings) {
    const double lambda = settings.lambda;
    const double reference = std::hypot(settings.reference, 2.0 * std::sqrt(unknown) / sigma);
    ewma = (1.0 - lambda) * ewma + lambda * away;
    variance = square(1.0 - lambda) * variance + square(lambda * sigma);
    share = (1.0 - lambda) * share + lambda;
    up = std::max(0.0, up + away / sigma - reference);
    down = std::max(0.0, down - away / sigma - reference);
  }
};

}  // namespace

ChartLimits chart_limits(const ChartSettings& settings) {
  return {limit_of_ewma(settings.lambda, settings.run_length), limit_of_cusum(settings.reference, settings.run_length)};
}

ControlChart control_chart(std::span<const ChartPoint> points, const ChartSettings& settings,
                           const ChartLimits& limits) {
  ControlChart chart{baseline_of(points, settings.baseline), limits, {}};
  const double freedom = static_cast<double>(settings.baseline) - 1.0;
  const double factor = student_quantile(three_sigma, freedom);
  std::vector<double> distances;
  Running running;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& point = points[i];
    ChartState state;
    const double away = point.value - chart.baseline.mean;
    const double unknown = square(chart.baseline.mean_sd) + square(point.shared);  // of the expected value
    state.sigma = std::hypot(chart.baseline.sd, point.sd);
    if (!(state.sigma > 0.0))
      throw Error(Error::Kind::bad_data, say("point {}: neither the baseline nor the point has an uncertainty", i + 1));
    state.away = away / state.sigma;
    state.limit = factor * std::sqrt(square(state.sigma) + unknown);
    state.beyond = std::abs(away) > state.limit;
    distances.push_back(state.away);
    state.notes = rules_of(distances);
    if (i >= settings.baseline) running.take(away, state.sigma, unknown, settings);
    state.ewma = running.ewma, state.up = running.up, state.down = running.down;
    state.ewma_limit = limits.ewma * std::sqrt(running.variance + square(running.share) * unknown);
    state.drifting = i >= settings.baseline && std::abs(state.ewma) > state.ewma_limit;
    state.shifted = std::max(state.up, state.down) > limits.cusum;
    chart.points.push_back(std::move(state));
  }
  return chart;
}

std::vector<double> self_starting(std::span<const double> values) {
  std::vector<double> out;
  double count = 0.0, mean = 0.0, squares = 0.0;
  for (const double value : values) {
    double q = std::nan("");
    if (count >= 2.0 && squares > 0.0) {
      const double sd = std::sqrt(squares / (count - 1.0));
      const double t = std::sqrt(count / (count + 1.0)) * (value - mean) / sd;
      const boost::math::students_t law(count - 1.0);
      // of the smaller tail, so that a point far away does not become infinite
      const double tail = std::max(cdf(complement(law, std::abs(t))), 1e-300);
      q = std::copysign(quantile(complement(boost::math::normal(), tail)), t);
    }
    out.push_back(q);
    if (std::abs(q) > beyond_control) continue;
    count += 1.0;
    const double before = value - mean;
    mean += before / count;
    squares += before * (value - mean);
  }
  return out;
}

}  // namespace tumble
