#include "tumble/math/noise/noise_likelihood/filter_search.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tumble/math/linear_algebra.hpp"

namespace tumble::noise_likelihood {
namespace {

/// [rate] from half the rate down; likelihoods are flat to this.
constexpr double widest_bandwidth = 0.5, ratio_of_bandwidths = 0.6;
constexpr double shortest_of_mean = 1.3, ratio_of_means = 1.3;  ///< [samples]; ratio from one length to the next
constexpr double needed_of_fall = 0.3;  ///< [1] of filter_fall, after both are refined: less is no filter

constexpr double filter_fall = 30.0;  ///< of -2 ln L by a filter: many shapes and bandwidths are tried

/// Filters from which the search begins.
std::vector<NoiseFilter> filters() {
  std::vector<NoiseFilter> all;
  for (const FilterShape shape : {FilterShape::first_order, FilterShape::first_order_means})
    for (double bandwidth = widest_bandwidth; bandwidth > least_bandwidth; bandwidth *= ratio_of_bandwidths)
      all.push_back({shape, bandwidth, 0.0});
  for (const FilterShape shape : {FilterShape::second_order, FilterShape::second_order_means})
    for (double bandwidth = widest_bandwidth; bandwidth > least_bandwidth; bandwidth *= ratio_of_bandwidths)
      for (const double damping : {0.5, 0.7, 1.0}) all.push_back({shape, bandwidth, damping});
  for (const FilterShape shape : {FilterShape::mean, FilterShape::mean_of_means, FilterShape::third_mean})
    for (double length = shape == FilterShape::mean ? shortest_of_mean : 1.0; length < longest_mean;
         length *= ratio_of_means)
      all.push_back({shape, bandwidth_of_means(shape, length), 0.0});
  return all;
}

/// Whether any low pass helps at all: bandwidths of the first and second order that stand for all shapes.
bool filter_seen(const BandData& data, bool ramp, const TriedTerms& before) {
  return std::ranges::any_of(std::vector<NoiseFilter>{{FilterShape::first_order, 0.4, 0.0},
                                                      {FilterShape::first_order, 0.2, 0.0},
                                                      {FilterShape::first_order, 0.08, 0.0},
                                                      {FilterShape::first_order, 0.025, 0.0},
                                                      {FilterShape::second_order, 0.1, 0.7},
                                                      {FilterShape::second_order, 0.04, 0.7},
                                                      {FilterShape::second_order, 0.015, 0.7}},
                             [&](const NoiseFilter& filter) {
                               return before.value() - with_filter(data, ramp, filter, before.terms).value() >
                                      0.3 * filter_fall;
                             });
}

}  // namespace

TriedTerms with_filter(const BandData& data, bool ramp, const NoiseFilter& filter, NoiseTerms terms) {
  constexpr double steep = 0.01;  ///< power at half the rate over that at frequency zero
  terms.filter = filter;
  TriedTerms measured = tried(data, terms, ramp, data.start);
  const auto own = data.filtered(filter);
  const auto white = column(data.design, 1);
  double power = 0.0, count = 0.0, least = INFINITY, most = 0.0;
  for (std::size_t b = 0; b < own.size(); ++b) {
    power += data.count[b] * data.z[b] / own[b];
    count += data.count[b];
    least = std::min(least, own[b] / white[b]);
    most = std::max(most, own[b] / white[b]);
  }
  if (least > steep * most) return measured;
  TriedTerms alone = tried(data, terms, ramp, scaled(power / count, own));
  return measured.value() < alone.value() ? measured : alone;
}

bool add_filter(const BandData& data, const SearchRange& range, TriedTerms& before) {
  if (!before.terms.used[1] || !filter_seen(data, range.ramp, before)) return false;
  std::vector<TriedTerms> best(static_cast<std::size_t>(FilterShape::third_mean) + 1);
  for (const NoiseFilter& filter : filters()) {
    TriedTerms one = with_filter(data, range.ramp, filter, before.terms);
    TriedTerms& same = best[static_cast<std::size_t>(filter.shape)];
    if (same.fit.c.empty() || one.value() < same.value()) same = std::move(one);
  }
  double least = INFINITY;
  for (const TriedTerms& one : best)
    if (!one.fit.c.empty()) least = std::min(least, one.value());
  const TriedTerms* chosen = nullptr;
  for (TriedTerms& one : best) {
    // Another bandwidth of the grid's spacing mends half the distance to no filter at most.
    if (one.fit.c.empty() || one.value() - least > 0.5 * (before.value() - least)) continue;
    one = best_parameters(data, one, range, fine);
    const auto cost = [](const TriedTerms& which) { return which.value() + 2.0 * size_of(which.terms); };
    if (chosen == nullptr || cost(one) < cost(*chosen)) chosen = &one;
  }
  const bool helps = before.value() - chosen->value() > filter_fall;
  if (helps) before = *chosen;
  return helps;
}

bool take_filter(const BandData& data, const SearchRange& range, const NoiseFilter& filter, TriedTerms& before) {
  if (!filter.given()) return false;
  before = best_parameters(data, with_filter(data, range.ramp, filter, before.terms), range, fine);
  return true;
}

bool filter_needed(const TriedTerms& without, const TriedTerms& with) {
  return without.value() + 2.0 * size_of(without.terms) - with.value() - 2.0 * size_of(with.terms) >
         needed_of_fall * filter_fall;
}

void try_other_filters(const BandData& data, const SearchRange& range, TermSelection& selection) {
  const TriedTerms& chosen = selection.all[selection.chosen];
  selection.other_filters.clear();
  selection.other_aicc.clear();
  if (chosen.terms.filter_parameters() == 0) return;
  const double contrasts = std::accumulate(data.count.begin(), data.count.end(), 0.0);
  for (auto shape = static_cast<int>(FilterShape::first_order); shape <= static_cast<int>(FilterShape::third_mean);
       ++shape) {
    NoiseFilter filter{static_cast<FilterShape>(shape), chosen.terms.filter.bandwidth, 0.0};
    if (filter.shape == chosen.terms.filter.shape) continue;
    if (filter.two_poles()) filter.damping = 0.7;
    for (const bool quantization : {false, true}) {
      NoiseTerms terms = chosen.terms;
      terms.used[0] = quantization;
      TriedTerms one = best_parameters(data, with_filter(data, range.ramp, filter, terms), range, coarse);
      if (!(std::ranges::min(one.fit.c) > 0.0)) continue;
      selection.other_aicc.push_back(aicc(one, range.ramp, contrasts));
      selection.other_filters.push_back(std::move(one));
    }
  }
}

}  // namespace tumble::noise_likelihood
