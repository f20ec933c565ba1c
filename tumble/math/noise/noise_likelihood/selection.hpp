#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "tumble/math/noise/noise_filter.hpp"
#include "tumble/math/noise/noise_likelihood/scoring.hpp"

namespace tumble::noise_likelihood {

constexpr std::size_t power_laws = power_law_terms.size();
constexpr double fine = 2e-3;          ///< tolerance of logarithms of the result: 0.2 % of a time or bandwidth
constexpr double coarse = 0.02;        ///< tolerance of logarithms where sets of terms are compared
constexpr double shortest_time = 8.0;  ///< [samples] of a process: nearer to the sampling interval it would be a filter

/// NoiseTerms of one model: columns of the four power laws, then processes.
struct NoiseTerms {
  std::vector<bool> used{true, true, true, true};  ///< power laws
  std::vector<double> times;                       ///< [samples] of the processes
  NoiseFilter filter;                              ///< of the white noise

  /// Parameters of the filter where there is white noise to be filtered.
  int filter_parameters() const { return used[1] ? filter.parameters() : 0; }
};

/// Expected mean squares of the terms with unit coefficients [bands x terms].
Matrix columns(const BandData& data, const NoiseTerms& terms);

struct TriedTerms {
  NoiseTerms terms;
  ScoringFit fit;
  double value() const { return fit.minus_twice_log_likelihood; }  ///< -2 ln L [1]
};

/// The likelihood of these terms, searched from the coefficients `start` [u^2].
TriedTerms tried(const BandData& data, const NoiseTerms& terms, bool ramp, const std::vector<double>& start);

/// Where the parameters of processes and filters are looked for.
struct SearchRange {
  bool ramp = false;
  double longest = INFINITY;  ///< correlation time [samples]

  /// Whether a correlation time [samples] lies at one end, where the likelihood may still rise beyond.
  bool at_bound(double time) const {
    constexpr double at_end = 0.02;  // the tolerance of the search
    return time < (1.0 + at_end) * shortest_time || time > (1.0 - at_end) * longest;
  }
};

/// The likelihood with the correlation times and the filter at their best, searched from those of `terms` (within a
/// factor 2 of each, again while that pays). Given: tolerance [1] of their logarithms.
TriedTerms best_parameters(const BandData& data, const TriedTerms& from, const SearchRange& range, double tolerance);

/// One process more beside the terms of `before`, where it lowers -2 ln L enough. Returned: whether it does.
bool add_process(const BandData& data, const SearchRange& range, TriedTerms& before);

int size_of(const NoiseTerms& terms);

/// Given: contrasts [1]. Returned: Akaike's criterion for finite samples [1].
double aicc(const TriedTerms& one, bool ramp, double contrasts);

/// Probability [1] of so great a fall of -2 ln L [1] by a coefficient that is zero: half a chi-square, as none is below
/// zero.
double chance_of(double fall);

/// Probability [1] of so great a fall of -2 ln L [1] by a Gauss-Markov process that is not there: chi-square of two.
double chance_of_process(double fall);

/// p-value [1] of a term of the power laws: the probability that a record without the term makes it look as needed as
/// it does.
double chance_without(const BandData& data, const TriedTerms& without, const TriedTerms& with, std::size_t term,
                      const SearchRange& range);

constexpr std::size_t subsets = std::size_t{1} << power_laws;

struct TermSelection {
  /// [mask + subsets p] over the power laws beside p processes, each at its own best correlation times and filter;
  /// without coefficients where it was not tried
  std::vector<TriedTerms> all;
  std::vector<bool> supported;
  std::vector<double> aicc;
  std::size_t chosen = 0;
  /// The chosen set, and that with or without quantization, with the white noise through filters of other shapes.
  std::vector<TriedTerms> other_filters;
  std::vector<double> other_aicc;
};

/// Sets of terms whose AICc is at most so much above that of the chosen one are averaged.
constexpr double near_in_aicc = 10.0;

/// Every subset of the power laws beside none to all of the processes of `full`, and, up to `most_processes`, sets in
/// which one process more replaces power laws that the record does not distinguish from it. Given: significance [1]
/// of a term that remains.
TermSelection select(const BandData& data, const SearchRange& range, const TriedTerms& full, double significance,
                     std::size_t most_processes);

}  // namespace tumble::noise_likelihood
