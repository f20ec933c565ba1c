#include "tumble/methods/random_vibration/screen.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <string>
#include <tuple>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/reduce/pulses/rounding.hpp"

namespace tumble::random_vibration {
namespace {

using vibration::Data;
using vibration::Outliers;
using vibration::Series;

constexpr int rounds = 5, lags_of_units = 2;

/// What a straight line leaves of a segment at rest.
std::vector<double> about_a_line(const Series& series) {
  double n = 0.0, t = 0.0, v = 0.0, tt = 0.0, tv = 0.0;
  for (std::size_t j = 0; j < series.force.size(); ++j)
    if (std::isfinite(series.force[j])) ++n, t += series.time[j], v += series.force[j];
  t /= n, v /= n;
  for (std::size_t j = 0; j < series.force.size(); ++j) {
    if (!std::isfinite(series.force[j])) continue;
    tt += (series.time[j] - t) * (series.time[j] - t);
    tv += (series.time[j] - t) * (series.force[j] - v);
  }
  const double slope = tt > 0.0 ? tv / tt : 0.0;
  std::vector<double> residual(series.force.size());
  for (std::size_t j = 0; j < residual.size(); ++j) residual[j] = series.force[j] - v - slope * (series.time[j] - t);
  return residual;
}

/// Skips in `series` what is far off `residual`, which is made anew as long as there is more.
template <class MakeResidual, class Skip>
Outliers skip_each(double least, std::size_t windows, MakeResidual residual, Skip skip) {
  Outliers all;
  for (int round = 0; round < rounds; ++round) {
    const Outliers more = vibration::outliers_of(residual(), least);
    if (more.index.empty() || vibration::windows_of_outlier * (all.index.size() + more.index.size()) > windows) break;
    for (const std::size_t j : more.index) skip(j);
    all.index.insert(all.index.end(), more.index.begin(), more.index.end());
    all.sum += more.sum;
  }
  std::ranges::sort(all.index);
  return all;
}

void screen(Series& series, const std::vector<double>& reference, int lags, Data& data) {
  const double least = vibration::rounding_sd(series, data.units[series.unit].pulse);
  const bool rest = series.at_rest();
  const Outliers skipped = skip_each(
      least, series.force.size(),
      [&] { return rest ? about_a_line(series) : explained(reference, series.force, lags).residual; },
      [&](std::size_t j) { series.force[j] = std::nan(""); });
  vibration::add_outliers(data, series, skipped, data.findings);
}

/// How many of the windows in which two units differ are at one extreme value of this unit.
struct AtExtremes {
  std::size_t highest = 0, lowest = 0;
  double most = -INFINITY, least = INFINITY;  ///< [m/s^2]
  std::size_t first = 0;                      ///< of those windows
};

AtExtremes at_extremes(const std::vector<double>& force, const std::vector<std::size_t>& windows) {
  AtExtremes at{.first = force.size()};
  for (const double v : force)
    if (std::isfinite(v)) at.most = std::max(at.most, v), at.least = std::min(at.least, v);
  for (const std::size_t j : windows) {
    if (force[j] == at.most || force[j] == at.least) at.first = std::min(at.first, j);
    at.highest += force[j] == at.most;
    at.lowest += force[j] == at.least;
  }
  return at;
}

/// Where a unit clips, another one beside it differs from it, and the unit is at one value each time.
void report_clipping(const Series& series, const std::vector<double>& force, const std::vector<std::size_t>& windows,
                     Data& data) {
  constexpr std::size_t fewest = 2, fewest_in_all = 3;  // a knock is the greatest value too, and there is one of it
  constexpr double most_windows = 0.8;                  // [1] of those in which the units differ
  const AtExtremes at = at_extremes(force, windows);
  const std::size_t all = at.highest + at.lowest;
  if (all < fewest_in_all || static_cast<double>(all) < most_windows * static_cast<double>(windows.size())) return;
  const auto n = static_cast<double>(force.size());
  for (const bool high : {true, false}) {
    const std::size_t count = high ? at.highest : at.lowest;
    if (count >= fewest)
      data.findings.push_back(
          {Finding::Severity::warning,
           high ? "saturated_highest" : "saturated_lowest",
           {{"part", static_cast<double>(count) / n, "%"}, {"value", high ? at.most : at.least, "g"}},
           place_of(data, series),
           {count, Place(series.time[at.first]), {}}});
  }
}

/// Two units in one vibration: the difference shows that one of them is off, and not which.
void screen(Series& first, Series& second, Data& data) {
  const auto of_first = first.force, of_second = second.force;
  const double least = std::hypot(vibration::rounding_sd(first, data.units[first.unit].pulse),
                                  vibration::rounding_sd(second, data.units[second.unit].pulse));
  const std::size_t n = std::min(first.force.size(), second.force.size());
  const Outliers skipped = skip_each(
      least, n, [&] { return explained(first.force, second.force, lags_of_units).residual; },
      [&](std::size_t j) { first.force[j] = second.force[j] = std::nan(""); });
  if (skipped.index.empty()) return;
  data.findings.push_back({Finding::Severity::warning,
                           "units_differ_in_windows",
                           {{"first_unit", data.units[first.unit].name}, {"second_unit", data.units[second.unit].name}},
                           second.label,
                           {skipped.index.size(), Place(second.time[skipped.index.front()])}});
  report_clipping(first, of_first, skipped.index, data);
  report_clipping(second, of_second, skipped.index, data);
}

}  // namespace

Explained explained(const std::vector<double>& reference, const std::vector<double>& values, int lags) {
  const auto side = static_cast<std::size_t>(lags);
  const std::size_t n = std::min(values.size(), reference.size()), width = 2 * side + 2;
  std::vector<double> row(width, 1.0), right(width, 0.0);
  const auto fill = [&](std::size_t j) {
    for (std::size_t k = 1; k < width; ++k) row[k] = reference[j + k - 1 - side];
    return std::ranges::all_of(row, [](double x) { return std::isfinite(x); }) && std::isfinite(values[j]);
  };
  Matrix normal(width, width);
  for (std::size_t j = side; j + side < n; ++j) {
    if (!fill(j)) continue;
    add_square(normal, 1.0, row);
    right = scaled_sum(right, values[j], row);
  }
  const auto gains = solve_symmetric(normal, right);
  if (!std::ranges::all_of(gains, [](double x) { return std::isfinite(x); })) return {};
  Explained result;
  result.residual.assign(values.size(), std::nan(""));
  for (std::size_t j = side; j + side < n; ++j)
    if (fill(j)) result.residual[j] = values[j] - dot(gains, row);
  result.gain = std::accumulate(gains.begin() + 1, gains.end(), 0.0);
  return result;
}

void skip_outliers(int lags, Data& data) {
  std::map<std::tuple<std::size_t, std::size_t, std::string>, std::vector<std::size_t>> vibrations;
  for (std::size_t i = 0; i < data.series.size(); ++i) {
    Series& series = data.series[i];
    const bool random = series.shake.kind == Motion::Kind::random;
    const bool reference = random && data.reference_integrated && !series.reference.empty();
    if (series.at_rest() || reference) {
      const auto same = series.reference;
      screen(series, same, lags, data);
    } else if (random) {
      vibrations[{series.recording, series.power_up, series.label}].push_back(i);
    }
  }
  for (const auto& [key, members] : vibrations)
    for (std::size_t k = 1; k < members.size(); ++k)
      screen(data.series[members.front()], data.series[members[k]], data);
}

}  // namespace tumble::random_vibration
