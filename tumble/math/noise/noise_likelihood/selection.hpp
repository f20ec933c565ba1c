#pragma once

#include <cstddef>
#include <vector>

#include "tumble/math/noise/noise_likelihood/scoring.hpp"

namespace tumble::noise_likelihood {

constexpr std::size_t power_laws = power_law_terms.size();
constexpr double shortest_time = 8.0;  ///< [samples] of a process: nearer to the sampling interval it would be a filter

/// NoiseTerms of one model: columns of the four power laws, then processes.
struct NoiseTerms {
  std::vector<bool> used{true, true, true, true};  ///< power laws
  std::vector<double> times;                       ///< [samples] of the processes
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

/// The model with the correlation time of process `which` set to its best between `low` and `high` [samples], by golden
/// section.
TriedTerms best_time(const BandData& data, NoiseTerms terms, bool ramp, const std::vector<double>& start,
                     std::size_t which, double low, double high);

/// One process more beside the terms of `before`, where it lowers -2 ln L enough. Given: longest correlation time
/// [samples]. Returned: whether it does.
bool add_process(const BandData& data, bool ramp, double longest, TriedTerms& before);

int size_of(const NoiseTerms& terms);

/// Probability [1] of so great a fall of -2 ln L [1] by a coefficient that is zero: half a chi-square, as none is below
/// zero.
double chance_of(double fall);

/// Probability [1] that chance alone makes a term of the power laws look as needed as it does.
double chance_without(const BandData& data, const TriedTerms& without, const TriedTerms& with, std::size_t term);

struct TermSelection {
  std::vector<TriedTerms> all;  ///< [mask] over the power laws
  std::vector<bool> supported;
  std::vector<double> aicc;
  std::size_t chosen = 0;
};

/// Every subset of the power laws beside the processes. Given: significance [1] of a term that remains.
TermSelection select(const BandData& data, bool ramp, const TriedTerms& full, double significance);

}  // namespace tumble::noise_likelihood
