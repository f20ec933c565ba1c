#include "tumble/math/noise/noise_likelihood.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/noise/noise_likelihood/average.hpp"
#include "tumble/math/noise/noise_likelihood/filter_search.hpp"
#include "tumble/math/noise/noise_likelihood/residuals.hpp"
#include "tumble/math/noise/noise_likelihood/spread.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using namespace noise_likelihood;

constexpr double endless_freedom = 1e6;       ///< more is infinite: the quantiles agree to 1e-6
constexpr double freedom_beside_walk = 20.0;  ///< of the fall by a ramp: keeps false ramps beside any walk below 0.5 %

constexpr double ramp_chance = 0.0027;  ///< 3 sigma

NoiseTerms power_laws_of(const NoiseLikelihoodOptions& options) {
  NoiseTerms all;
  for (std::size_t t = 0; t < power_laws; ++t)
    all.used[t] = std::count(options.terms.begin(), options.terms.end(), power_law_terms[t]) > 0;
  return all;
}

/// A power law that is not in the model, tried beside the others.
void describe_absent(const BandData& data, const TriedTerms& chosen, bool ramp, std::size_t term, FittedTerm& result) {
  const Matrix others = columns(data, chosen.terms), own = as_column(column(data.design, term));
  const ScoringFit with = fit_by_scoring(data, beside(others, own), ramp, chosen.fit.s);
  const Matrix weighted = scaled_rows(root_weights(data, with.s), beside(others, own));
  const auto scale = inverses(column_norms(weighted));
  const Matrix inverse = inverse_symmetric(gram(scaled_columns(weighted, scale)));
  result.squared = with.c.back();
  result.squared_sd = scale.back() * std::sqrt(inverse.values.back());
  result.z = result.squared / result.squared_sd;
  result.improvement = chosen.value() - with.minus_twice_log_likelihood;
  result.chance = chance_of(result.improvement);
  result.upper_limit = upper_limit(data, others, own.values, ramp, with, result.squared, result.squared_sd);
}

/// How much a term of the chosen set lowers -2 ln L, each set at its best parameters, and the chance of that.
void weigh(const BandData& data, const TermSelection& selection, const SearchRange& range, std::size_t t,
           FittedTerm& term) {
  const TriedTerms& chosen = selection.all[selection.chosen];
  const TriedTerms& without =
      selection.all[t < power_laws ? selection.chosen & ~(std::size_t{1} << t) : selection.chosen - subsets];
  term.improvement = std::numeric_limits<double>::infinity();
  term.chance = 0.0;
  if (without.fit.c.empty()) return;  // nothing to be compared with
  term.improvement = without.value() - chosen.value();
  term.chance = t < power_laws ? chance_without(data, without, chosen, t, range) : chance_of_process(term.improvement);
}

void describe_kept(const BandData& data, const TermSelection& selection, const SearchRange& range,
                   const LinearNoise& model, const NoiseSpread& known, NoiseFit& fit) {
  const TriedTerms& chosen = selection.all[selection.chosen];
  for (std::size_t a = 0; a < model.terms.size(); ++a) {
    FittedTerm& term = fit.terms[model.terms[a]];
    const std::size_t t = model.terms[a];
    term.kept = true;
    std::size_t place = chosen.fit.c.size() - chosen.terms.times.size() + t - power_laws;
    if (t < power_laws) place = std::count(chosen.terms.used.begin(), chosen.terms.used.begin() + t, true);
    weigh(data, selection, range, t, term);
    term.squared = chosen.fit.c[place];
    const double variance = known.covariance(a, a);
    term.squared_sd = std::sqrt(variance);
    term.z = term.squared / term.squared_sd;
    const double relative = variance / (term.squared * term.squared), root = std::sqrt(term.squared);
    term.root_correction = 1.0 + relative / 8.0;
    term.degrees_of_freedom =
        interval_freedom(data, model.x, chosen.fit.s, a, term.squared, root * term.root_correction,
                         0.5 * root * std::sqrt(relative), known.widening[a]);
    if (t >= power_laws) {
      const std::size_t time = model.terms.size() + t - power_laws;
      term.degrees_of_freedom =
          std::min(term.degrees_of_freedom, time_freedom(std::sqrt(known.covariance(time, time))));
    }
    const double factor = student_quantile(one_sided_95, term.degrees_of_freedom);
    term.upper_limit = term.squared * std::pow(term.root_correction + 0.5 * factor * std::sqrt(relative), 2);
  }
}

void add_covariance(const LinearNoise& model, const NoiseSpread& known, const TriedTerms& chosen, NoiseFit& fit) {
  const std::size_t terms = fit.terms.size(), processes = chosen.terms.times.size(),
                    all = terms + processes + static_cast<std::size_t>(model.filter_parameters);
  std::vector<std::size_t> place = model.terms;
  std::vector<double> scale(known.covariance.rows, 1.0);
  for (const std::size_t m : model.processes) {
    scale[place.size()] = chosen.terms.times[m];
    place.push_back(terms + m);
  }
  for (int k = 0; k < model.filter_parameters; ++k) {
    scale[place.size()] = k == 0 ? chosen.terms.filter.bandwidth : chosen.terms.filter.damping;
    place.push_back(terms + processes + static_cast<std::size_t>(k));
  }
  fit.covariance = Matrix(all, all);
  fit.model_error_variance.assign(all, 0.0);
  for (std::size_t a = 0; a < place.size(); ++a) {
    for (std::size_t b = 0; b < place.size(); ++b)
      fit.covariance(place[a], place[b]) = scale[a] * scale[b] * known.covariance(a, b);
    fit.model_error_variance[place[a]] = scale[a] * scale[a] * known.by_error(a, a);
  }
}

/// What is reported, averaged; intervals that would reach zero leave a limit only.
void add_values(const BandData& data, const std::vector<double>& statistical_count, const TermSelection& selection,
                const LinearNoise& model, const NoiseSpread& known, NoiseFit& fit) {
  const NoiseValues alone = values_of_chosen(selection, model, known);
  const NoiseValues mean = averaged_values(data, statistical_count, selection, alone);
  fit.value = mean.value;
  fit.value_covariance = mean.covariance;
  fit.value_error_variance = mean.error_variance;
  fit.averaged_sets = mean.sets;
  fit.shown.assign(fit.terms.size(), false);
  for (std::size_t i = fit.terms.size() + fit.time_at_bound.size(); i < mean.value.size(); ++i)
    fit.filter_freedom.push_back(
        std::min(endless_freedom, logarithm_freedom(std::sqrt(mean.covariance(i, i)) / mean.value[i])));
  for (std::size_t t = 0; t < fit.terms.size(); ++t) {
    FittedTerm& term = fit.terms[t];
    const double variance = mean.covariance(t, t), sd = std::sqrt(variance);
    if (!term.kept) {
      term.upper_limit = std::max(term.upper_limit, std::pow(mean.value[t] + normal_one_sided_95 * sd, 2));
      continue;
    }
    // What the sets differ by is known from all of them: it counts as of many degrees of freedom.
    term.degrees_of_freedom *= std::max(1.0, std::pow(variance / alone.covariance(t, t), 2));
    fit.shown[t] = mean.value[t] > student_quantile(two_sided_95, term.degrees_of_freedom) * sd;
    term.upper_limit = std::max(
        term.upper_limit, std::pow(mean.value[t] + student_quantile(one_sided_95, term.degrees_of_freedom) * sd, 2));
  }
}

double two_sided(double t, double freedom) {
  return 2.0 * boost::math::cdf(boost::math::complement(boost::math::students_t(freedom), t));
}

/// The ramp's slope with the random walk at its limit where the record shows none, and the chance of so much.
NoiseRamp ramp_of(const BandData& data, const TriedTerms& chosen, const LinearNoise& model, const NoiseSpread& known,
                  const FittedTerm& walk) {
  NoiseRamp ramp;
  auto s = chosen.fit.s;
  if (!walk.kept) s = scaled_sum(s, walk.upper_limit, column(data.design, power_laws - 1));
  const RampFit best = fit_ramp(data, s);
  if (!std::isfinite(best.variance)) return {.sd = INFINITY};
  std::vector<double> each;  // share of each band in the information about the slope, over s
  for (std::size_t b = 0; b < s.size(); ++b)
    each.push_back(best.variance * data.slow[b] * data.count[b] * data.ramp_square[b] / (s[b] * s[b]));
  const auto by = transposed_product(model.x, each);  // relative change of the slope's variance by each coefficient
  ramp.slope = best.slope;
  ramp.sd = std::sqrt(best.variance);
  ramp.degrees_of_freedom =
      std::clamp(2.0 / std::max(quadratic_form(by, known.covariance), 1e-9), 1.0, endless_freedom);
  ramp.chance = two_sided(std::abs(ramp.slope) / ramp.sd, ramp.degrees_of_freedom);
  return ramp;
}

/// Where the record shows no walk and no process beside the ramp, walk and ramp still compete for the same few sines:
/// how much -2 ln L is lower with the ramp than with all power laws and none, and the sd for which the slope would be
/// as far from zero.
void weigh_against_walk(const BandData& data, const NoiseLikelihoodOptions& options, const NoiseFilter& filter,
                        NoiseRamp& ramp) {
  const NoiseTerms all = power_laws_of(options);
  const auto fitted = [&](bool beside) {
    return filter.given() ? with_filter(data, beside, filter, all).fit : tried(data, all, beside, data.start).fit;
  };
  const ScoringFit with = fitted(true), without = fitted(false);
  const double fall = without.minus_twice_log_likelihood -
                      (with.minus_twice_log_likelihood + std::log(with.slope_variance));  // at its best, not integrated
  // A walk of few sines makes the fall greater by chance than a chi-square is: Student's distribution of 20 degrees of
  // freedom keeps false ramps beside any walk below 0.5 %.
  const double chance = fall > 0.0 ? two_sided(std::sqrt(fall), freedom_beside_walk) : 1.0;
  if (chance >= ramp.chance) return;
  ramp.chance = chance;
  ramp.sd = std::abs(ramp.slope) / std::sqrt(fall);
  ramp.degrees_of_freedom = 1e6;
}

void list_composites(const TermSelection& selection, NoiseFit& fit) {
  for (std::size_t index = 0; index < selection.all.size(); ++index) {
    const TriedTerms& one = selection.all[index];
    if (one.fit.c.empty()) continue;
    NoiseComposite composite{{},
                             one.value(),
                             size_of(one.terms),
                             selection.aicc[index] - selection.aicc[selection.chosen],
                             selection.supported[index]};
    for (std::size_t t = 0; t < power_laws; ++t)
      if (one.terms.used[t]) composite.terms.push_back({power_law_terms[t]});
    for (const double time : one.terms.times) composite.terms.push_back({NoiseTerm::markov, time});
    fit.composites.push_back(composite);
  }
  std::stable_sort(fit.composites.begin(), fit.composites.end(), [](const NoiseComposite& a, const NoiseComposite& b) {
    return a.supported != b.supported ? a.supported : a.aicc < b.aicc;
  });
}

/// Whether the filter follows the record, or takes away most of what the terms miss without it: of vibration at some
/// frequencies it only takes the shape.
bool explains(const BandData& whole, const SearchRange& range, const TriedTerms& with, const TriedTerms& without) {
  constexpr double most_left = 0.25;
  if (model_error(whole, range.ramp, with) == 0.0) return true;
  const auto excess = [&](const TriedTerms& one) {
    const auto residuals = residuals_of(whole, one.fit);
    return chi_square(residuals, 0.0) - residual_freedom(residuals, one, range.ramp);
  };
  return excess(with) < most_left * excess(without);
}

/// All power laws with the processes and the filter that the record asks for. before: from a fit before; may be null.
TriedTerms fullest(const BandData& whole, const SearchRange& range, const NoiseLikelihoodOptions& options,
                   const NoiseFilter* before) {
  const NoiseTerms all = power_laws_of(options);
  TriedTerms plain = tried(whole, all, range.ramp, whole.start), filtered = plain;
  const bool seen = options.filter && (before == nullptr ? add_filter(whole, range, filtered)
                                                         : take_filter(whole, range, *before, filtered));
  const auto with_processes = [&](TriedTerms& one) {
    for (std::size_t m = 0; m < options.most_markov && add_process(whole, range, one); ++m) {
    }
  };
  with_processes(plain);
  if (!seen) return plain;
  // A process may have been taken for a filter.
  with_processes(filtered);
  return filter_needed(plain, filtered) && explains(whole, range, filtered, plain) ? filtered : plain;
}

/// The set that was chosen, at parameters found to the last digit that matters.
void refine_chosen(const BandData& data, const SearchRange& range, TermSelection& selection) {
  TriedTerms& chosen = selection.all[selection.chosen];
  chosen = best_parameters(data, chosen, range, fine);
}

/// The sets of terms where each range of frequencies has this relative error, whose counts `data` receives.
TermSelection chosen_beside(const std::vector<double>& count, double error, const SearchRange& range,
                            const TriedTerms& full, const NoiseLikelihoodOptions& options, BandData& data) {
  data.count = counts_with(count, error);
  TriedTerms again = full;
  if (error > 0.0) again = tried(data, full.terms, range.ramp, full.fit.s);
  for (bool first = true;; first = false) {
    TermSelection selection = select(data, range, again, options.significance, options.most_markov);
    refine_chosen(data, range, selection);
    if (error == 0.0) try_other_filters(data, range, selection);  // else no shape is right
    const auto best = std::ranges::min_element(selection.other_aicc);
    if (!first || best == selection.other_aicc.end() || *best > selection.aicc[selection.chosen]) return selection;
    const auto& better = selection.other_filters[static_cast<std::size_t>(best - selection.other_aicc.begin())];
    again = best_parameters(data, with_filter(data, range.ramp, better.terms.filter, full.terms), range, fine);
  }
}

NoiseFit fit_beside(const BandData& whole, bool ramp, std::size_t samples, const NoiseLikelihoodOptions& options,
                    const NoiseFilter* before = nullptr) {
  const SearchRange range{ramp, static_cast<double>(samples) / 20.0};
  const TriedTerms full = fullest(whole, range, options, before);
  NoiseFit fit;
  fit.model_error = model_error(whole, ramp, full);
  BandData data = whole;
  TermSelection selection = chosen_beside(whole.count, fit.model_error, range, full, options, data);
  // What the significant terms cannot follow, though all terms could, is not passed over either.
  if (const double error = model_error(whole, ramp, selection.all[selection.chosen]); error > fit.model_error) {
    fit.model_error = error;
    selection = chosen_beside(whole.count, error, range, full, options, data);
  }
  const TriedTerms& chosen = selection.all[selection.chosen];
  for (const NoiseTerm term : power_law_terms) fit.terms.push_back({{term}});
  for (const double time : chosen.terms.times) {
    fit.terms.push_back({{NoiseTerm::markov, time}});
    fit.time_at_bound.push_back(range.at_bound(time));
  }
  fit.longest_time = range.longest;
  if (chosen.terms.filter_parameters() > 0) fit.filter = chosen.terms.filter;
  const LinearNoise model = linear(data, chosen);
  const NoiseSpread known = spread(data, whole.count, model, chosen);
  describe_kept(data, selection, range, model, known, fit);
  for (std::size_t t = 0; t < power_laws; ++t)
    if (!fit.terms[t].kept) describe_absent(data, chosen, ramp, t, fit.terms[t]);
  add_covariance(model, known, chosen, fit);
  add_values(data, whole.count, selection, model, known, fit);
  list_composites(selection, fit);
  fit.ramp = ramp_of(data, chosen, model, known, fit.terms[power_laws - 1]);
  fit.residuals = residuals_of(whole, chosen.fit);
  fit.chi_square = chi_square(fit.residuals, 0.0);
  fit.degrees_of_freedom = std::max(0.0, residual_freedom(fit.residuals, chosen, ramp));
  fit.minus_twice_log_likelihood = chosen.value();
  fit.condition = known.condition;
  fit.scatter_ratio = known.scatter_ratio;
  return fit;
}

}  // namespace

void take_values_of_terms(NoiseFit& fit) {
  const std::size_t terms = fit.terms.size(), all = fit.covariance.rows;
  std::vector<double> gain(all, 1.0);
  fit.value.assign(all, 0.0);
  fit.shown.assign(terms, false);
  for (std::size_t t = 0, process = 0; t < terms; ++t) {
    const FittedTerm& term = fit.terms[t];
    gain[t] = 0.0;
    if (term.kept) {
      const double root = std::sqrt(term.squared);
      gain[t] = 0.5 / root;
      fit.value[t] = root * term.root_correction;
    }
    if (term.unit.term == NoiseTerm::markov && terms + process < all)
      fit.value[terms + process++] = term.unit.markov_time;
  }
  fit.value_covariance = scaled_columns(scaled_rows(gain, fit.covariance), gain);
  fit.value_error_variance = fit.model_error_variance;
  for (std::size_t i = 0; i < all; ++i) fit.value_error_variance[i] *= gain[i] * gain[i];
  for (std::size_t t = 0; t < terms; ++t)
    fit.shown[t] = fit.terms[t].kept && fit.value[t] > student_quantile(two_sided_95, fit.terms[t].degrees_of_freedom) *
                                                           std::sqrt(fit.value_covariance(t, t));
}

NoiseFit fit_noise(const NoiseBands& bands, const NoiseLikelihoodOptions& options) {
  NoiseBands used = bands;
  std::erase_if(used.bands, [&](const NoiseBand& band) {
    return band.frequency * options.shortest > 0.5 || 0.5 > band.frequency * options.longest;
  });
  const BandData data(used);
  if (data.count.size() < 2 || !(std::ranges::max(data.z) > 0.0))
    throw Error(Error::Kind::bad_data, "nothing that changes between the averaging times to fit");
  // Pieces too short for neighbours among the slow values show no trend.
  if (!std::isfinite(fit_ramp(data, data.start).variance)) return fit_beside(data, false, bands.samples, options);
  NoiseFit with = fit_beside(data, true, bands.samples, options);
  const bool unseen = !with.terms[power_laws - 1].kept && with.terms.size() == power_law_terms.size();
  if (unseen) weigh_against_walk(data, options, with.filter, with.ramp);
  if (with.ramp.chance <= ramp_chance) {
    with.ramp.kept = true;
    return with;
  }
  NoiseFit without = fit_beside(data, false, bands.samples, options, &with.filter);
  without.ramp = with.ramp;
  return without;
}

}  // namespace tumble
