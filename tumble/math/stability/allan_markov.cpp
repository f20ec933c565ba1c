#include <algorithm>
#include <cmath>
#include <functional>

#include "tumble/math/golden_section.hpp"
#include "tumble/math/stability/allan_fit.hpp"

namespace tumble {
namespace {

constexpr double least_freedom_without = 3.0;  ///< of the fit without a process, which takes two more

/// [samples] A correlation time nearer to the sampling interval is what a filter in the instrument leaves, not a
/// process to report.
constexpr double shortest_time = 8.0;
/// Correlation times that a record holds at least. Chosen: fewer show a random walk rather than a process that stays in
/// bounds; doubled, processes of a twentieth to a fortieth of the record are not found.
constexpr double fewest_times = 20.0;
/// p-value of the fit without a process, above which none is looked for.
constexpr double misfit_p = 0.05;
/// Fall of minus twice the log-likelihood for the two parameters of a process: chi-square with 2 degrees of freedom
/// exceeds it with p = 0.001 (13.82).
constexpr double process_improvement = 13.8;

/// The correlation time of the best likelihood between `low` and `high`, by golden section in its logarithm.
double best_time(const std::vector<AllanObservation>& observations, std::size_t samples, AllanFitOptions options,
                 double low, double high) {
  options.select = false;
  const auto at = [&](double log_time) {
    options.markov_time = std::exp(log_time);
    return fit_allan(observations, samples, options).minus_twice_log_likelihood;
  };
  int steps = 10;  // shorten the interval to 0.618^10 = 0.8 % of its length
  const auto best = golden_section_search(
      std::log(low), std::log(high), at, [&steps](double) { return steps-- > 0; }, std::less{});
  return std::exp(0.5 * (best.a + best.b));
}

}  // namespace

AllanFit fit_allan_and_markov(const std::vector<AllanObservation>& observations, std::size_t samples,
                              const AllanFitOptions& options) {
  const AllanFit without = fit_allan(observations, samples, options);
  const double dof = without.degrees_of_freedom;
  if (dof < least_freedom_without || chi_square_tail(without.chi_square / dof, dof) > misfit_p) return without;
  AllanFitOptions with = options;
  with.select = false;
  double best = 0.0, least = without.minus_twice_log_likelihood;
  for (double time = shortest_time; time < static_cast<double>(samples) / fewest_times; time *= 2.0) {
    with.markov_time = time;
    const double one = fit_allan(observations, samples, with).minus_twice_log_likelihood;
    if (one >= least) continue;
    least = one;
    best = time;
  }
  if (best == 0.0) return without;
  with.select = options.select;
  // Twice: the terms that fall away once the process is in give its correlation time more room.
  for (int round = 0; round < 2; ++round) {
    AllanFitOptions narrow = with;
    if (round > 0) {
      const AllanFit chosen = fit_allan(observations, samples, with);
      narrow.terms.clear();
      for (std::size_t t = 0; t < options.terms.size(); ++t)
        if (chosen.terms[t].kept) narrow.terms.push_back(options.terms[t]);
    }
    with.markov_time = best = best_time(observations, samples, narrow, 0.5 * best, 2.0 * best);
  }
  if (best < shortest_time) return without;
  AllanFit fit = fit_allan(observations, samples, with);
  const bool helps = without.minus_twice_log_likelihood - fit.minus_twice_log_likelihood > process_improvement;
  return helps && fit.terms.back().kept ? fit : without;
}

}  // namespace tumble
