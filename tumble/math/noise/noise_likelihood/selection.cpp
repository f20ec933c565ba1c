#include "tumble/math/noise/noise_likelihood/selection.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/noise/noise_likelihood/score.hpp"
#include "tumble/math/stability/allan_fit.hpp"
#include "tumble/units/error.hpp"

namespace tumble::noise_likelihood {
namespace {

constexpr double process_fall = 13.8;  ///< of -2 ln L by a Gauss-Markov process: 0.1 % of chi-square of two

double aicc(const TriedTerms& one, bool ramp, double contrasts) {
  const double p = size_of(one.terms) + (ramp ? 1.0 : 0.0);
  return one.value() + 2.0 * p + 2.0 * p * (p + 1.0) / std::max(1.0, contrasts - p - 1.0);
}

}  // namespace

Matrix columns(const BandData& data, const NoiseTerms& terms) {
  std::vector<std::size_t> list;
  for (std::size_t t = 0; t < power_laws; ++t)
    if (terms.used[t]) list.push_back(t);
  Matrix x = chosen_columns(data.design, list);
  for (const double time : terms.times) x = beside(x, as_column(data.markov(time)));
  return x;
}

TriedTerms tried(const BandData& data, const NoiseTerms& terms, bool ramp, const std::vector<double>& start) {
  return {terms, fit_by_scoring(data, columns(data, terms), ramp, start)};
}

TriedTerms best_time(const BandData& data, NoiseTerms terms, bool ramp, const std::vector<double>& start,
                     std::size_t which, double low, double high) {
  const auto of = [&](double log_time) {
    terms.times[which] = std::exp(log_time);
    return tried(data, terms, ramp, start);
  };
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
  double a = std::log(low), b = std::log(high);
  double left = b - golden * (b - a), right = a + golden * (b - a);
  TriedTerms at_left = of(left), at_right = of(right);
  while (b - a > 2e-3) {
    if (at_left.value() < at_right.value()) {
      b = right;
      right = left;
      at_right = std::move(at_left);
      at_left = of(left = b - golden * (b - a));
    } else {
      a = left;
      left = right;
      at_left = std::move(at_right);
      at_right = of(right = a + golden * (b - a));
    }
  }
  return at_left.value() < at_right.value() ? at_left : at_right;
}

bool add_process(const BandData& data, bool ramp, double longest, TriedTerms& before) {
  TriedTerms best = before;
  for (double time = shortest_time; time < longest; time *= 2.0) {
    NoiseTerms with = before.terms;
    with.times.push_back(time);
    TriedTerms one = tried(data, with, ramp, before.fit.s);
    if (one.value() < best.value()) best = std::move(one);
  }
  const std::size_t which = before.terms.times.size();
  if (best.terms.times.size() == which || before.value() - best.value() < 1.0) return false;
  const double time = best.terms.times.back();
  best = best_time(data, best.terms, ramp, best.fit.s, which, std::max(0.5 * time, shortest_time),
                   std::min(2.0 * time, longest));
  const bool helps = before.value() - best.value() > process_fall;
  if (helps) before = std::move(best);
  return helps;
}

int size_of(const NoiseTerms& terms) {
  return static_cast<int>(std::count(terms.used.begin(), terms.used.end(), true) + 2 * std::ssize(terms.times));
}

double chance_of(double fall) { return fall <= 0.0 ? 1.0 : 0.5 * chi_square_tail(fall, 1.0); }

double chance_without(const BandData& data, const TriedTerms& without, const TriedTerms& with, std::size_t term) {
  constexpr double beyond_doubt = 300.0;
  const double fall = without.value() - with.value(), chance = chance_of(fall);
  if (chance > 0.5 || fall > beyond_doubt) return chance;
  return std::max(chance, chance_by_slope(data, without, column(data.design, term)));
}

TermSelection select(const BandData& data, bool ramp, const TriedTerms& full, double significance) {
  TermSelection selection;
  const std::size_t subsets = std::size_t{1} << power_laws;
  selection.all.resize(subsets);
  selection.supported.assign(subsets, false);
  selection.aicc.assign(subsets, INFINITY);
  const double contrasts = std::accumulate(data.count.begin(), data.count.end(), 0.0);
  double least = INFINITY;
  for (std::size_t mask = 0; mask < subsets; ++mask) {
    NoiseTerms terms = full.terms;
    bool within = true;
    for (std::size_t t = 0; t < power_laws; ++t) {
      terms.used[t] = (mask >> t) & 1u;
      within = within && (full.terms.used[t] || !terms.used[t]);
    }
    if (size_of(terms) == 0 || !within) continue;
    selection.all[mask] = tried(data, terms, ramp, full.fit.s);
    const TriedTerms& one = selection.all[mask];
    bool supported = std::ranges::min(one.fit.c) > 0.0;
    for (std::size_t t = 0; t < power_laws && supported; ++t) {
      const std::size_t without = mask & ~(std::size_t{1} << t);
      if (without == mask || selection.all[without].fit.c.empty()) continue;
      supported = chance_without(data, selection.all[without], one, t) < significance;
    }
    selection.supported[mask] = supported;
    selection.aicc[mask] = aicc(one, ramp, contrasts);
    if (!supported || selection.aicc[mask] >= least) continue;
    least = selection.aicc[mask];
    selection.chosen = mask;
  }
  if (!std::isfinite(least))
    throw Error(Error::Kind::bad_data,
                "no noise term fits: the values differ too much in size; look for samples out of range");
  return selection;
}

}  // namespace tumble::noise_likelihood
