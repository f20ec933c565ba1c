#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/lack_of_fit.hpp"
#include "tumble/math/square.hpp"
#include "tumble/reduce/linear/segment_means.hpp"
#include "tumble/reduce/linear/words.hpp"
#include "tumble/reduce/linear/work.hpp"

namespace tumble::linear {
namespace {

constexpr double excess_by_chance = 1e-4;  ///< [1] of a sound test, one output
constexpr double drift_over_stated = 3.0;  ///< [1] of the variance as stated, at least: less hardly changes an interval

/// The variances of the slow noise as stated: nothing for what the fit has found beyond it.
std::vector<double> stated_variances(const Work& work) {
  std::vector<double> variances = work.solution.fit.slow_variance;
  for (std::size_t c = 0; c < variances.size(); ++c)
    if (!work.data.slow[c].known) variances[c] = 0.0;
  return variances;
}

/// The bias of each power-up is free: no statement limits it.
Matrix with_power_ups(const Work& work, const SegmentMeans& means) {
  std::vector<std::size_t> starts;
  for (const std::size_t g : means.segments) starts.push_back(work.evidence.test.stretches[g].start);
  return beside(means.design, indicators(starts));
}

/// Degrees of freedom of the variance of the means: that of the white noise is found from the rows within the segments,
/// and the rest is stated.
double freedom_of(const Work& work, const SegmentMeans& means) {
  const double within = static_cast<double>(work.data.weights.size()) - static_cast<double>(means.segments.size()) -
                        static_cast<double>(work.data.design.columns);
  double white = 0.0, all = 0.0;
  for (std::size_t a = 0; a < means.segments.size(); ++a) {
    white += work.solution.fit.white_variance / means.duration[a];
    all += means.covariance(a, a);
  }
  // without rows within them the white noise is found from the means, and takes in what they differ by
  return within > 0.0 && white > 0.0 ? within * square(all / white) : std::numeric_limits<double>::infinity();
}

}  // namespace

void warn_of_excess(const Problem& problem, Work& work) {
  if (std::ranges::none_of(work.data.slow, [](const SlowNoise& slow) { return slow.known && slow.variance > 0.0; }))
    return;
  std::vector<std::size_t> all(work.solution.segments.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const SegmentMeans means = segment_means(work, std::move(all), stated_variances(work));
  const auto fit = lack_of_fit(with_power_ups(work, means), identity(means.segments.size()), means.output,
                               means.covariance, freedom_of(work, means));
  if (!(fit.freedom > 0.0) || fit.ratio < drift_over_stated || fit.probability > excess_by_chance) return;
  work.solution.findings.push_back(
      {Finding::Severity::warning, "more_drift_than_stated", {{"times", std::sqrt(fit.ratio)}}, problem.role});
}

}  // namespace tumble::linear
