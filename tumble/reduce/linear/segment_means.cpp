#include "tumble/reduce/linear/segment_means.hpp"

#include <optional>
#include <utility>

#include "tumble/reduce/linear/work.hpp"

namespace tumble::linear {
namespace {

/// White noise, slow noise and the errors of the rig.
Matrix covariance_of_means(const Work& work, const SegmentMeans& means, const std::vector<double>& slow_variance) {
  const std::size_t n = means.segments.size();
  Matrix covariance(n, n);
  for (std::size_t a = 0; a < n; ++a) {
    covariance(a, a) = work.solution.fit.white_variance / means.duration[a];
    for (std::size_t c = 0; c < work.data.slow.size(); ++c)
      for (std::size_t b = 0; b < n; ++b)
        covariance(a, b) += slow_variance[c] * work.data.slow[c].kernel(means.segments[a], means.segments[b]);
  }
  for (std::size_t k = 0; k < work.data.effects.size(); ++k)
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = 0; b < n; ++b)
        if (a == b || !work.data.effects[k].each_segment) covariance(a, b) += means.effects(a, k) * means.effects(b, k);
  return covariance;
}

}  // namespace

SegmentMeans segment_means(const Work& work, std::vector<std::size_t> segments,
                           const std::vector<double>& slow_variance) {
  SegmentMeans means{.segments = std::move(segments)};
  const std::size_t n = means.segments.size(), p = work.data.design.columns, effects = work.data.effects.size();
  means.design = Matrix(n, p);
  means.effects = Matrix(n, effects);
  means.output.assign(n, 0.0);
  means.time.assign(n, 0.0);
  means.duration.assign(n, 0.0);
  std::vector<std::optional<std::size_t>> row(work.solution.segments.size());
  for (std::size_t r = 0; r < n; ++r) {
    row[means.segments[r]] = r;
    means.duration[r] = work.solution.segments[means.segments[r]].duration;
  }
  for (std::size_t i = 0; i < work.data.weights.size(); ++i) {
    if (!row[work.data.segment[i]]) continue;
    const std::size_t r = *row[work.data.segment[i]];
    const double share = work.data.weights[i] / means.duration[r];
    for (std::size_t j = 0; j < p; ++j) means.design(r, j) += share * work.data.design(i, j);
    for (std::size_t k = 0; k < effects; ++k) means.effects(r, k) += share * work.data.effects[k].column[i];
    means.output[r] += share * work.data.observations[i];
    means.time[r] += share * work.rows.time[i];
  }
  means.covariance = covariance_of_means(work, means, slow_variance);
  return means;
}

}  // namespace tumble::linear
