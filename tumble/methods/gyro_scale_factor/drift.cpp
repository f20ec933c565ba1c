#include <algorithm>
#include <map>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/lack_of_fit.hpp"
#include "tumble/methods/gyro_scale_factor/departures.hpp"
#include "tumble/methods/gyro_scale_factor/segments.hpp"

namespace tumble::gyro_scale_factor {
namespace {

constexpr double least_freedom_of_drift = 5.0;
constexpr double least_determinant = 1e-6;  ///< [1] of the product of the squares: the two drifts are distinct

/// Segments of one power-up at one rate, less their means: what a change of bias and of scale factor with time adds.
struct Repeats {
  std::vector<double> time, time_by_rate, measured;  ///< [s], [rad], [SI of the output]
  double freedom = 0.0, length = 0.0;                ///< [1], [s] from the first to the last segment
};

void add_group(const Segments& group, Repeats& repeats) {
  const double n = static_cast<double>(group.size()), rate = group.front()->felt.rate.x;
  double time = 0.0;
  for (const auto* s : group) time += (s->begin + 0.5 * s->duration) / n;
  for (const auto* s : group) {
    const double since = s->begin + 0.5 * s->duration - time;
    repeats.time.push_back(since);
    repeats.time_by_rate.push_back(since * rate);
    repeats.measured.push_back(s->measured - mean_of(group));
  }
  repeats.freedom += n - 1.0;
}

Repeats repeats_of(const linear::Solution& solution, const Line& line) {
  std::map<int, Segments> runs;
  for (const auto* s : all_of(solution)) runs[s->run].push_back(s);
  Repeats repeats;
  for (const auto& [run, segments] : runs) {
    repeats.length = std::max(repeats.length, segments.back()->begin - segments.front()->begin);
    for (const auto& group : groups_of(segments, line.range))
      if (group.size() > 1) add_group(group, repeats);
  }
  return repeats;
}

}  // namespace

Findings about_drift(const linear::Solution& solution, const Line& line) {
  constexpr double rare = 1e-9;  // by white noise: flicker noise seems to drift much more often
  const Repeats repeats = repeats_of(solution, line);
  if (!(repeats.freedom >= least_freedom_of_drift)) return {};
  const double tt = dot(repeats.time, repeats.time), tw = dot(repeats.time, repeats.time_by_rate);
  const double ww = dot(repeats.time_by_rate, repeats.time_by_rate), ty = dot(repeats.time, repeats.measured);
  const double wy = dot(repeats.time_by_rate, repeats.measured), determinant = tt * ww - tw * tw;
  if (!(determinant > least_determinant * tt * ww)) return {};
  const double bias = (ww * ty - tw * wy) / determinant, scale = (tt * wy - tw * ty) / determinant;
  const double rest = std::max(dot(repeats.measured, repeats.measured) - bias * ty - scale * wy, 0.0);
  const double freedom = repeats.freedom - 2.0, variance = rest / freedom / determinant;
  Findings findings;
  if (chance_of_ratio(bias * bias / (variance * ww), 1.0, freedom) < rare)
    findings.push_back({Finding::Severity::warning,
                        "bias_drifts",
                        {{"change", bias * repeats.length / line.slope, "deg/h"}, {"length", repeats.length, "s"}},
                        "bias"});
  if (chance_of_ratio(scale * scale / (variance * tt), 1.0, freedom) < rare)
    findings.push_back({Finding::Severity::warning,
                        "scale_factor_drifts",
                        {{"change", scale * repeats.length / line.slope, "ppm"}, {"length", repeats.length, "s"}},
                        "scale_factor"});
  return findings;
}

}  // namespace tumble::gyro_scale_factor
