#include "tumble/reduce/linear/boundaries.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tumble/math/median.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/square.hpp"

namespace tumble::linear {

bool adjoin(const ConductedTest& test, const Stretch& a, const Stretch& b) {
  if (a.recording != b.recording || a.power_up != b.power_up || a.segment + 1 != b.segment) return false;
  const double begin = b.power_on + test.power_ups[b.power_up].begins[b.segment];
  return std::abs(a.end - begin) < a.step;
}

namespace {

constexpr double fewest_of_level = 4.0;   ///< samples
constexpr double step_of_greatest = 3.0;  ///< a step of less than a third of the greatest shows boundaries worse
constexpr double boundary_by_noise = 6.0, boundary_by_scatter = 3.0;  ///< [sd] of the median share

/// Of the samples from one index to another that are present.
struct Level {
  double mean = 0.0, sd = 0.0;  ///< [SI of the output]
  double count = 0.0;
};

Level level_of(const EvenValues& values, std::size_t begin, std::size_t end) {
  Level level;
  double squares = 0.0;
  for (std::size_t i = begin; i < end; ++i) {
    if (std::isnan(values[i])) continue;
    const double d = values[i] - level.mean;
    level.mean += d / ++level.count;
    squares += d * (values[i] - level.mean);
  }
  if (level.count > 1.0) level.sd = std::sqrt(squares / (level.count - 1.0));
  return level;
}

/// The middle half of a segment.
Level middle_of(const Stretch& stretch) {
  const std::size_t quarter = stretch.samples / 4;
  return level_of(stretch.values, quarter, stretch.samples - quarter);
}

/// Two segments of which one follows the other without a pause.
struct Pair {
  const Stretch *before = nullptr, *after = nullptr;
  Level level_before, level_after;
};

std::vector<Pair> pairs_of(const ConductedTest& test) {
  constexpr std::size_t least = 8;  // samples, so that a middle and two ends remain
  std::vector<Pair> pairs;
  const auto& all = test.stretches;
  for (std::size_t k = 0; k + 1 < all.size(); ++k) {
    if (!adjoin(test, all[k], all[k + 1]) || std::min(all[k].values.size(), all[k + 1].values.size()) < least) continue;
    pairs.push_back({&all[k], &all[k + 1], middle_of(all[k]), middle_of(all[k + 1])});
    if (!(std::min(pairs.back().level_before.count, pairs.back().level_after.count) >= fewest_of_level))
      pairs.pop_back();
  }
  return pairs;
}

/// One end of a segment, and the level next to it.
struct Edge {
  const Stretch* stretch = nullptr;
  Level own;
  double step = 0.0;  ///< [SI of the output] from its own level to that of the neighbour
};

/// The ends (or the begins) of the segments, without those next to a level that hardly differs.
std::vector<Edge> edges_of(const std::vector<Pair>& pairs, bool last) {
  std::vector<Edge> edges;
  double most = 0.0;
  for (const Pair& pair : pairs) {
    const double step = pair.level_after.mean - pair.level_before.mean;
    edges.push_back(last ? Edge{pair.before, pair.level_before, step} : Edge{pair.after, pair.level_after, -step});
    most = std::max(most, std::abs(step));
  }
  std::erase_if(edges, [&](const Edge& edge) { return !(step_of_greatest * std::abs(edge.step) > most); });
  return edges;
}

/// How far the samples so deep in the segments lie towards the neighbours' levels, as a share of the way: the median,
/// where it is beyond the noise of the segments and beyond the scatter from segment to segment; else 0.
double share_at(const std::vector<Edge>& edges, std::size_t depth, bool last) {
  constexpr double of_a_median = 1.2533;  // sd of a median over that of a mean, of normal values: sqrt(pi/2)
  constexpr double negligible = 1e-3;     // of the way
  std::vector<double> shares;
  double noise = 0.0;
  for (const Edge& edge : edges) {
    const std::size_t n = edge.stretch->samples;
    if (4 * depth >= n) continue;
    const double v = edge.stretch->values[last ? n - 1 - depth : depth];
    if (std::isnan(v)) continue;
    shares.push_back((v - edge.own.mean) / edge.step);
    noise += square(edge.own.sd / edge.step);
  }
  if (shares.size() < 3) return 0.0;
  const double n = static_cast<double>(shares.size()), middle = median(shares);
  for (double& share : shares) share = std::abs(share - middle);
  const double by_noise = of_a_median * std::sqrt(noise) / n;
  const double by_scatter = of_a_median * sd_of_median_size * median(shares) / std::sqrt(n);
  return middle > std::max({boundary_by_noise * by_noise, boundary_by_scatter * by_scatter, negligible})
             ? std::min(middle, 1.0)
             : 0.0;
}

/// One finding for the ends of the segments, or for their begins.
Findings about_edges(const ConductedTest& test, bool last, const std::string& role) {
  const auto edges = edges_of(pairs_of(test), last);
  double samples = 0.0, strays = 0.0;
  for (double share = 1.0; share > 0.0; strays += share) {
    share = share_at(edges, static_cast<std::size_t>(samples), last);
    if (share > 0.0) ++samples;
  }
  const bool slow = samples - strays >= 1.0;  // the output approaches its level
  if (!(samples > 0.0) || (slow && !last)) return {};
  const Stretch& stretch = *edges.front().stretch;
  const double skipped = last ? 0.0 : stretch.first - test.power_ups[stretch.power_up].begins[stretch.segment];
  return {{Finding::Severity::error,
           last ? "segments_end_in_next" : "segments_begin_in_last",
           {{"shift", skipped + strays * stretch.step, "s"}},
           role,
           {edges.size(), stretch.label, {}}}};
}

}  // namespace

Findings about_boundaries(const ConductedTest& test, const std::string& role) {
  const Findings late = about_edges(test, true, role);
  return late.empty() ? about_edges(test, false, role) : late;
}

bool misplaced(const Findings& findings) {
  return std::ranges::any_of(findings, [](const Finding& finding) {
    return finding.code == "segments_end_in_next" || finding.code == "segments_begin_in_last";
  });
}

}  // namespace tumble::linear
