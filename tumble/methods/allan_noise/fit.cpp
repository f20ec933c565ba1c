#include "tumble/methods/allan_noise/fit.hpp"

#include "tumble/methods/allan_noise/ramp.hpp"

namespace tumble {
namespace {

/// Points of the curve that are fitted.
std::vector<AllanObservation> observations(const std::vector<DeviationPoint>& curve, const Settings& settings) {
  std::vector<AllanObservation> within;
  for (const auto& point : curve)
    if (!(settings.has("fit_from") && point.tau < settings.number("fit_from")) &&
        !(settings.has("fit_to") && point.tau > settings.number("fit_to")))
      within.push_back({point.factor, point.deviation * point.deviation, point.count});
  return thinned(within);
}

/// In the form that the likelihood gives.
NoiseFit in_general(const AllanFit& from, const std::vector<AllanObservation>& used, const Ramp& ramp, double rate) {
  NoiseFit fit;
  fit.terms = from.terms;
  const std::size_t terms = from.terms.size(), times = from.markov_time_covariance.empty() ? 0 : 1;
  fit.covariance = Matrix(terms + times, terms + times);
  for (std::size_t a = 0; a < terms; ++a) {
    for (std::size_t b = 0; b < terms; ++b) fit.covariance(a, b) = from.covariance(a, b);
    if (times > 0) fit.covariance(a, terms) = fit.covariance(terms, a) = from.markov_time_covariance[a];
  }
  if (times > 0) fit.covariance(terms, terms) = from.markov_time_covariance.back();
  fit.model_error_variance = from.model_error_variance;
  fit.model_error_variance.resize(terms + times, 0.0);
  for (std::size_t i = 0; i < used.size(); ++i)
    fit.residuals.push_back({0.5 / static_cast<double>(used[i].factor), 1.0 + from.residual[i], from.residual_sd[i]});
  fit.ramp = {ramp.kept, ramp.slope / rate, ramp.sd / rate, ramp.degrees_of_freedom, ramp.chance};
  fit.chi_square = from.chi_square;
  fit.degrees_of_freedom = from.degrees_of_freedom;
  fit.model_error = from.model_error;
  fit.minus_twice_log_likelihood = from.minus_twice_log_likelihood;
  fit.condition = from.condition;
  return fit;
}

}  // namespace

NoiseFit fit_likelihood(const EvenSignal& signal, const Settings& settings) {
  NoiseLikelihoodOptions options;
  options.significance = settings.number("significance");
  if (settings.has("fit_from")) options.shortest = settings.number("fit_from") * signal.rate;
  if (settings.has("fit_to")) options.longest = settings.number("fit_to") * signal.rate;
  return fit_noise(NoiseBands(signal.values), options);
}

/// The noise about a line looks smaller than it is until what the line took is put back: if the trend does not stand
/// out even so, it never will.
NoiseFit fit_allan_curve(const EvenSignal& signal, const std::vector<DeviationPoint>& curve,
                         const AllanOptions& options, const Settings& settings) {
  AllanFitOptions how;
  how.significance = settings.number("significance");
  const std::size_t samples = signal.values.size();
  const auto whole = observations(curve, settings);
  const AllanFit plain = fit_allan_and_markov(whole, samples, how);
  constexpr double chance = 0.0027;  // 3 sigma
  AllanFit about = plain;
  std::vector<AllanObservation> used;
  Ramp ramp = estimate_ramp(signal.values, signal.rate, about);
  for (int round = 0; round < 3; ++round) {
    const auto level = levelled(signal.values, signal.rate, ramp.slope);
    used = observations(overlapping_allan(level, signal.rate, options), settings);
    if (round > 0) used = without_ramp(used, signal.rate, ramp);
    about = fit_allan_and_markov(used, samples, how);
    ramp = estimate_ramp(signal.values, signal.rate, about);
    if (ramp.chance > chance) return in_general(plain, whole, ramp, signal.rate);
  }
  ramp.kept = true;
  return in_general(about, used, ramp, signal.rate);
}

}  // namespace tumble
