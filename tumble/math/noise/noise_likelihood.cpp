#include "tumble/math/noise/noise_likelihood.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/noise/noise_likelihood/residuals.hpp"
#include "tumble/math/noise/noise_likelihood/spread.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using namespace noise_likelihood;

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

void describe_kept(const BandData& data, const TermSelection& selection, const LinearNoise& model,
                   const NoiseSpread& known, const TriedTerms& chosen, NoiseFit& fit) {
  for (std::size_t a = 0; a < model.terms.size(); ++a) {
    FittedTerm& term = fit.terms[model.terms[a]];
    const std::size_t t = model.terms[a];
    term.kept = true;
    std::size_t place = chosen.fit.c.size() - chosen.terms.times.size() + t - power_laws;
    if (t < power_laws) {
      place = std::count(chosen.terms.used.begin(), chosen.terms.used.begin() + t, true);
      const TriedTerms& without = selection.all[selection.chosen & ~(std::size_t{1} << t)];
      const bool sole = without.fit.c.empty();  // nothing to be compared with
      term.improvement = sole ? 0.0 : without.value() - chosen.value();
      term.chance = sole ? 0.0 : chance_without(data, without, chosen, t);
    }
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
    const double factor = student_quantile(0.95, term.degrees_of_freedom);
    term.upper_limit = term.squared * std::pow(term.root_correction + 0.5 * factor * std::sqrt(relative), 2);
  }
}

void add_covariance(const LinearNoise& model, const NoiseSpread& known, const TriedTerms& chosen, NoiseFit& fit) {
  const std::size_t terms = fit.terms.size(), all = terms + chosen.terms.times.size();
  std::vector<std::size_t> place = model.terms;
  std::vector<double> scale(known.covariance.rows, 1.0);
  for (const std::size_t m : model.processes) {
    scale[place.size()] = chosen.terms.times[m];
    place.push_back(terms + m);
  }
  fit.covariance = Matrix(all, all);
  fit.model_error_variance.assign(all, 0.0);
  for (std::size_t a = 0; a < place.size(); ++a) {
    for (std::size_t b = 0; b < place.size(); ++b)
      fit.covariance(place[a], place[b]) = scale[a] * scale[b] * known.covariance(a, b);
    fit.model_error_variance[place[a]] = scale[a] * scale[a] * known.by_error(a, a);
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
  ramp.degrees_of_freedom = std::clamp(2.0 / std::max(quadratic_form(by, known.covariance), 1e-9), 1.0, 1e6);
  ramp.chance = two_sided(std::abs(ramp.slope) / ramp.sd, ramp.degrees_of_freedom);
  return ramp;
}

/// Where the record shows no walk and no process beside the ramp, walk and ramp still compete for the same few sines:
/// how much -2 ln L is lower with the ramp than with all power laws and none, and the sd for which the slope would be
/// as far from zero.
void weigh_against_walk(const BandData& data, const NoiseLikelihoodOptions& options, NoiseRamp& ramp) {
  const NoiseTerms all = power_laws_of(options);
  const ScoringFit with = tried(data, all, true, data.start).fit, without = tried(data, all, false, data.start).fit;
  const double fall = without.minus_twice_log_likelihood -
                      (with.minus_twice_log_likelihood + std::log(with.slope_variance));  // at its best, not integrated
  // A walk of few sines makes the fall greater by chance than a chi-square is: Student's distribution of 20 degrees of
  // freedom keeps false ramps beside any walk below 0.5 %.
  const double chance = fall > 0.0 ? two_sided(std::sqrt(fall), 20.0) : 1.0;
  if (chance >= ramp.chance) return;
  ramp.chance = chance;
  ramp.sd = std::abs(ramp.slope) / std::sqrt(fall);
  ramp.degrees_of_freedom = 1e6;
}

void list_composites(const TermSelection& selection, NoiseFit& fit) {
  for (std::size_t mask = 0; mask < selection.all.size(); ++mask) {
    const TriedTerms& one = selection.all[mask];
    if (one.fit.c.empty()) continue;
    NoiseComposite composite{{},
                             one.value(),
                             size_of(one.terms),
                             selection.aicc[mask] - selection.aicc[selection.chosen],
                             selection.supported[mask]};
    for (std::size_t t = 0; t < power_laws; ++t)
      if (one.terms.used[t]) composite.terms.push_back({power_law_terms[t]});
    for (const double time : one.terms.times) composite.terms.push_back({NoiseTerm::markov, time});
    fit.composites.push_back(composite);
  }
  std::stable_sort(fit.composites.begin(), fit.composites.end(), [](const NoiseComposite& a, const NoiseComposite& b) {
    return a.supported != b.supported ? a.supported : a.aicc < b.aicc;
  });
}

NoiseFit fit_beside(const BandData& whole, bool ramp, std::size_t samples, const NoiseLikelihoodOptions& options) {
  const NoiseTerms all = power_laws_of(options);
  TriedTerms full = tried(whole, all, ramp, whole.start);
  const double longest = static_cast<double>(samples) / 20.0;
  for (std::size_t m = 0; m < options.most_markov && add_process(whole, ramp, longest, full); ++m) {
  }
  NoiseFit fit;
  fit.model_error = model_error(whole, ramp, full);
  BandData data = whole;
  data.count = counts_with(whole.count, fit.model_error);
  TermSelection selection = select(data, ramp, full, options.significance);
  if (!full.terms.times.empty()) {
    // The terms that fall away give the correlation times more room.
    TriedTerms refined = selection.all[selection.chosen];
    for (int round = 0; round < 2; ++round)
      for (std::size_t m = 0; m < refined.terms.times.size(); ++m)
        refined = best_time(data, refined.terms, ramp, refined.fit.s, m,
                            std::max(0.5 * refined.terms.times[m], shortest_time),
                            std::min(2.0 * refined.terms.times[m], longest));
    refined.terms.used = all.used;
    selection = select(data, ramp, refined, options.significance);
  }
  const TriedTerms& chosen = selection.all[selection.chosen];
  for (const NoiseTerm term : power_law_terms) fit.terms.push_back({{term}});
  for (const double time : chosen.terms.times) fit.terms.push_back({{NoiseTerm::markov, time}});
  const LinearNoise model = linear(data, chosen);
  const NoiseSpread known = spread(data, whole.count, model, chosen);
  describe_kept(data, selection, model, known, chosen, fit);
  for (std::size_t t = 0; t < power_laws; ++t)
    if (!fit.terms[t].kept) describe_absent(data, chosen, ramp, t, fit.terms[t]);
  add_covariance(model, known, chosen, fit);
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
  if (unseen) weigh_against_walk(data, options, with.ramp);
  if (with.ramp.chance <= ramp_chance) {
    with.ramp.kept = true;
    return with;
  }
  NoiseFit without = fit_beside(data, false, bands.samples, options);
  without.ramp = with.ramp;
  return without;
}

}  // namespace tumble
