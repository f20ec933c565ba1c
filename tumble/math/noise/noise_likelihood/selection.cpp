#include "tumble/math/noise/noise_likelihood/selection.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "tumble/math/golden_section.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/noise/noise_likelihood/score.hpp"
#include "tumble/math/stability/allan_fit.hpp"
#include "tumble/units/error.hpp"

namespace tumble::noise_likelihood {
namespace {

/// Of the logarithm of a time or bandwidth, a factor of 1.8: others are looked for again.
constexpr double moved_by = 0.6;

constexpr double process_fall = 13.8;  ///< of -2 ln L by a Gauss-Markov process: 0.1 % of chi-square of two
constexpr double hopeless = 1000.0;    ///< of -2 ln L above all terms: no correlation time within an octave mends that
constexpr double between_octaves = 10.0;  ///< of -2 ln L, from an octave of the correlation time to its best
constexpr double least_damping = 0.3, most_damping = 2.0, widest = 0.6;

/// A parameter that enters the expectations nonlinearly: where it stands, and between what it is searched.
struct Nonlinear {
  std::function<double&(NoiseTerms&)> of;
  double low = 0.0, high = INFINITY;
};

std::vector<Nonlinear> nonlinear(const NoiseTerms& terms, const SearchRange& range) {
  std::vector<Nonlinear> all;
  for (std::size_t m = 0; m < terms.times.size(); ++m)
    all.push_back({[m](NoiseTerms& one) -> double& { return one.times[m]; }, shortest_time, range.longest});
  if (terms.filter_parameters() == 0) return all;
  const bool poles = terms.filter.two_poles() || terms.filter.shape == FilterShape::first_order ||
                     terms.filter.shape == FilterShape::first_order_means;
  const double low = poles ? least_bandwidth : bandwidth_of_means(terms.filter.shape, longest_mean),
               high = poles ? widest : bandwidth_of_means(terms.filter.shape, 1.0);
  all.push_back({[](NoiseTerms& one) -> double& { return one.filter.bandwidth; }, low, high});
  if (terms.filter.two_poles())
    all.push_back({[](NoiseTerms& one) -> double& { return one.filter.damping; }, least_damping, most_damping});
  return all;
}

/// The best of a line of models between `a` and `b`, by golden section.
TriedTerms best_between(const BandData& data, const TriedTerms& from, bool ramp, double a, double b, double tolerance,
                        const std::function<NoiseTerms(double)>& terms_at) {
  const auto of = [&](double x) { return tried(data, terms_at(x), ramp, from.fit.s); };
  const auto goes_on = [tolerance](double length) { return length > tolerance; };
  const auto less = [](const TriedTerms& x, const TriedTerms& y) { return x.value() < y.value(); };
  auto best = golden_section_search(a, b, of, goes_on, less);
  return less(best.at_left, best.at_right) ? std::move(best.at_left) : std::move(best.at_right);
}

/// ... along its logarithm, of one parameter within a factor 2 of where it is.
TriedTerms best_of_one(const BandData& data, const TriedTerms& from, bool ramp, const Nonlinear& which,
                       double tolerance) {
  NoiseTerms terms = from.terms;
  const double at = which.of(terms);
  return best_between(data, from, ramp, std::log(std::max(0.5 * at, which.low)),
                      std::log(std::min(2.0 * at, which.high)), tolerance, [&](double log_value) {
                        which.of(terms) = std::exp(log_value);
                        return terms;
                      });
}

/// ... on the way from `begin` to `from` and up to five times as far: parameters that depend on each other move
/// together.
TriedTerms best_together(const BandData& data, const TriedTerms& begin, const TriedTerms& from, bool ramp,
                         const std::vector<Nonlinear>& parameters, double tolerance) {
  NoiseTerms terms = from.terms, first = begin.terms, last = from.terms;
  return best_between(data, from, ramp, 0.0, 5.0, 100.0 * tolerance, [&](double way) {
    for (const Nonlinear& one : parameters) {
      const double at = one.of(first) * std::pow(one.of(last) / one.of(first), way);
      one.of(terms) = std::clamp(at, one.low, one.high);
    }
    return terms;
  });
}

/// The likeliest of these correlation times beside the terms of `like`.
TriedTerms likeliest(const BandData& data, const TriedTerms& like, bool ramp,
                     const std::vector<std::vector<double>>& times) {
  TriedTerms best;
  for (const auto& some : times) {
    NoiseTerms terms = like.terms;
    terms.times = some;
    TriedTerms one = tried(data, terms, ramp, like.fit.s);
    if (best.fit.c.empty() || one.value() < best.value()) best = std::move(one);
  }
  return best;
}

/// Octaves between the bounds, with `beside` before each.
std::vector<std::vector<double>> octaves(std::vector<double> beside, double longest) {
  std::vector<std::vector<double>> all;
  beside.push_back(shortest_time);
  for (; beside.back() < longest; beside.back() *= 2.0) all.push_back(beside);
  return all;
}

}  // namespace

Matrix columns(const BandData& data, const NoiseTerms& terms) {
  std::vector<std::size_t> list;
  for (std::size_t t = 0; t < power_laws; ++t)
    if (terms.used[t]) list.push_back(t);
  Matrix x = chosen_columns(data.design, list);
  if (terms.filter_parameters() > 0)
    std::ranges::copy(data.filtered(terms.filter), column(x, terms.used[0] ? 1 : 0).begin());
  for (const double time : terms.times) x = beside(x, as_column(data.markov(time)));
  return x;
}

TriedTerms tried(const BandData& data, const NoiseTerms& terms, bool ramp, const std::vector<double>& start) {
  return {terms, fit_by_scoring(data, columns(data, terms), ramp, start)};
}

TriedTerms best_parameters(const BandData& data, const TriedTerms& from, const SearchRange& range, double tolerance) {
  constexpr int most_rounds = 8;
  constexpr double enough = 0.02;  ///< of -2 ln L
  const auto parameters = nonlinear(from.terms, range);
  TriedTerms best = from;
  const auto take = [&](TriedTerms next) {
    if (next.value() < best.value()) best = std::move(next);
  };
  for (int round = 0; round < most_rounds; ++round) {
    const TriedTerms begin = best;
    bool moved = false;
    for (const Nonlinear& one : parameters) {
      NoiseTerms terms = best.terms;
      const double at = one.of(terms);
      take(best_of_one(data, best, range.ramp, one, tolerance));
      terms = best.terms;
      moved = moved || std::abs(std::log(one.of(terms) / at)) > moved_by;
    }
    if (!moved && (parameters.size() < 2 || begin.value() - best.value() < enough)) break;
    if (parameters.size() > 1) take(best_together(data, begin, best, range.ramp, parameters, tolerance));
  }
  return best;
}

bool add_process(const BandData& data, const SearchRange& range, TriedTerms& before) {
  const auto tries = octaves(before.terms.times, range.longest);
  if (tries.empty()) return false;
  TriedTerms best = likeliest(data, before, range.ramp, tries);
  if (before.value() - best.value() < 1.0) return false;
  best = best_parameters(data, best, range, fine);
  const bool helps = before.value() - best.value() > process_fall;
  if (helps) before = std::move(best);
  return helps;
}

int size_of(const NoiseTerms& terms) {
  return static_cast<int>(std::count(terms.used.begin(), terms.used.end(), true) + 2 * std::ssize(terms.times)) +
         terms.filter_parameters();
}

double aicc(const TriedTerms& one, bool ramp, double contrasts) {
  const double p = size_of(one.terms) + (ramp ? 1.0 : 0.0);
  return one.value() + 2.0 * p + 2.0 * p * (p + 1.0) / std::max(1.0, contrasts - p - 1.0);
}

double chance_of(double fall) { return fall <= 0.0 ? 1.0 : 0.5 * chi_square_tail(fall, 1.0); }

double chance_of_process(double fall) { return fall <= 0.0 ? 1.0 : chi_square_tail(0.5 * fall, 2.0); }

double chance_without(const BandData& data, const TriedTerms& without, const TriedTerms& with, std::size_t term,
                      const SearchRange& range) {
  constexpr double beyond_doubt = 300.0;
  const double fall = without.value() - with.value(), chance = chance_of(fall);
  if (chance > 0.5 || fall > beyond_doubt) return chance;
  const auto white = column(data.design, term);
  const auto own = term == 1 && with.terms.filter.given() ? data.filtered(with.terms.filter)
                                                          : std::vector<double>(white.begin(), white.end());
  return std::max(chance, chance_by_slope(data, without, own, range));
}

namespace {

/// The set `index` at its best: from its likeliest octave, the times of `full`, and those of each set with a term less.
TriedTerms best_of_set(const BandData& data, const SearchRange& range, const TriedTerms& full, std::size_t index,
                       const std::vector<TriedTerms>& smaller) {
  TriedTerms like{full.terms, full.fit};
  for (std::size_t t = 0; t < power_laws; ++t) like.terms.used[t] = (index >> t) & 1u;
  const std::size_t processes = index / subsets;
  std::vector<std::vector<double>> times;
  if (processes == 0 || processes == full.terms.times.size())
    times.push_back(processes == 0 ? std::vector<double>() : full.terms.times);
  if (processes == 1) {
    const auto more = octaves({}, range.longest);
    times.insert(times.end(), more.begin(), more.end());
  }
  for (std::size_t t = 0; processes > 0 && t < power_laws; ++t) {
    const std::size_t less = index & ~(std::size_t{1} << t);
    if (less != index && !smaller[less].fit.c.empty()) times.push_back(smaller[less].terms.times);
  }
  TriedTerms best = likeliest(data, like, range.ramp, times);
  return best.value() > full.value() + hopeless ? best : best_parameters(data, best, range, coarse);
}

bool is_supported(const BandData& data, const SearchRange& range, const TermSelection& selection, std::size_t index,
                  double significance) {
  const TriedTerms& one = selection.all[index];
  if (!(std::ranges::min(one.fit.c) > 0.0)) return false;
  if (index >= subsets) {
    const TriedTerms& without = selection.all[index - subsets];
    if (!without.fit.c.empty() && without.value() - one.value() < process_fall) return false;
  }
  for (std::size_t t = 0; t < power_laws; ++t) {
    const std::size_t without = index & ~(std::size_t{1} << t);
    if (without == index || selection.all[without].fit.c.empty()) continue;
    if (chance_without(data, selection.all[without], one, t, range) >= significance) return false;
  }
  return true;
}

/// Whether the power laws of the set `index` are among those of the set `of`.
bool within(std::size_t index, std::size_t of) { return (index % subsets & ~(of % subsets)) == 0; }

/// Takes a set that was tried into the selection; it is chosen if its AICc is the least so far and below `limit`.
void enter(const BandData& data, const SearchRange& range, std::size_t index, TriedTerms set, double significance,
           double limit, TermSelection& selection) {
  const double contrasts = std::accumulate(data.count.begin(), data.count.end(), 0.0);
  selection.all[index] = std::move(set);
  selection.aicc[index] = aicc(selection.all[index], range.ramp, contrasts);
  selection.supported[index] = is_supported(data, range, selection, index, significance);
  if (!selection.supported[index]) return;
  if (selection.chosen > 0) limit = std::min(limit, selection.aicc[selection.chosen]);
  if (selection.aicc[index] < limit) selection.chosen = index;
}

/// Sets in which a further process stands for a power law of the chosen set: averaged, and chosen if they are better by
/// more than what is averaged. A set with a term less is never likelier: correlation times at which a set is out of
/// reach are not tried with fewer terms.
void try_processes_instead(const BandData& data, const SearchRange& range, const TriedTerms& full, double significance,
                           std::size_t all, TermSelection& selection) {
  const auto times = octaves(full.terms.times, range.longest);
  const std::size_t before = selection.chosen, first = subsets * (full.terms.times.size() + 1);
  const double limit = selection.aicc[before] - near_in_aicc;
  const double reach = selection.aicc[before] + near_in_aicc + between_octaves;
  std::vector<std::vector<bool>> out(subsets, std::vector<bool>(times.size(), false));
  std::vector<TriedTerms> best(subsets);
  for (std::size_t mask = subsets; mask-- > 0;) {
    if ((within(before, mask) && mask != before % subsets) || !within(mask, all)) continue;
    TriedTerms like{full.terms, full.fit};
    for (std::size_t t = 0; t < power_laws; ++t) like.terms.used[t] = (mask >> t) & 1u;
    for (std::size_t i = 0; i < times.size(); ++i) {
      for (std::size_t t = 0; t < power_laws; ++t) out[mask][i] = out[mask][i] || out[mask | (std::size_t{1} << t)][i];
      if (out[mask][i]) continue;
      TriedTerms one = likeliest(data, like, range.ramp, {times[i]});
      out[mask][i] = one.value() > reach;
      if (best[mask].fit.c.empty() || one.value() < best[mask].value()) best[mask] = std::move(one);
    }
  }
  for (std::size_t mask = 0; mask < subsets; ++mask) {  // a set comes after those with a term less
    if (best[mask].fit.c.empty() || best[mask].value() > reach) continue;
    TriedTerms one = best_parameters(data, best[mask], range, coarse);
    const double longest = std::ranges::max(one.terms.times), shortest = std::ranges::min(one.terms.times);
    if (range.at_bound(longest) && longest > 2.0 * shortest_time) continue;  // a walk, as far as this record goes
    // At the short end it speaks against the power law, but is no process with a time of its own.
    const bool counts_only = range.at_bound(shortest) || mask == before % subsets;
    enter(data, range, first + mask, std::move(one), significance, counts_only ? -INFINITY : limit, selection);
  }
}

}  // namespace

TermSelection select(const BandData& data, const SearchRange& range, const TriedTerms& full, double significance,
                     std::size_t most_processes) {
  TermSelection selection;
  const std::size_t known = subsets * (full.terms.times.size() + 1);
  const bool further = full.terms.times.size() < most_processes;
  const std::size_t sets = known + (further ? subsets : 0);
  selection.all.resize(sets);
  selection.supported.assign(sets, false);
  selection.aicc.assign(sets, INFINITY);
  std::size_t all = 0;
  for (std::size_t t = 0; t < power_laws; ++t) all |= static_cast<std::size_t>(full.terms.used[t]) << t;
  for (std::size_t index = 1; index < known; ++index)  // a set comes after those with a term less
    if (within(index, all))
      enter(data, range, index, best_of_set(data, range, full, index, selection.all), significance, INFINITY,
            selection);
  if (selection.chosen == 0)
    throw Error(Error::Kind::bad_data,
                "no noise term fits: the values differ too much in size; look for samples out of range");
  if (further) try_processes_instead(data, range, full, significance, all, selection);
  return selection;
}

}  // namespace tumble::noise_likelihood
