#include "tumble/methods/allan_noise/fit.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tumble/math/noise/noise_length.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/methods/allan_noise/faults.hpp"
#include "tumble/methods/allan_noise/lines.hpp"
#include "tumble/methods/allan_noise/periodic.hpp"
#include "tumble/methods/allan_noise/ramp.hpp"
#include "tumble/methods/allan_noise/settling.hpp"
#include "tumble/reduce/uneven_bias.hpp"

namespace tumble::allan_noise {
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
  take_values_of_terms(fit);
  return fit;
}

std::string amount(double value_si, const std::string& unit) {
  return fmt::format("{:.3g} {}", Unit::parse(unit).difference_from_si(value_si), unit);
}

template <typename Line>
std::string list_of(const std::vector<Line>& lines, const ChannelNoise& channel) {
  std::string list;
  for (const auto& line : lines)
    list += fmt::format("{}{:.4g} Hz ({})", list.empty() ? "" : ", ", line.frequency * channel.rate,
                        amount(line.amplitude, rate_unit(channel.kind)));
  return list;
}

template <typename Line>
std::vector<FindingValue> values_of(const std::vector<Line>& lines, const ChannelNoise& channel) {
  return {{"lines", list_of(lines, channel)},
          {"frequency", lines[0].frequency * channel.rate, "Hz"},
          {"amplitude", lines[0].amplitude, rate_unit(channel.kind)}};
}

NoiseLikelihoodOptions options_of(const Settings& settings, double rate) {
  NoiseLikelihoodOptions options;
  options.significance = settings.number("significance");
  if (settings.has("fit_from")) options.shortest = settings.number("fit_from") * rate;
  if (settings.has("fit_to")) options.longest = settings.number("fit_to") * rate;
  return options;
}

/// Lengths for a relative sd of what is seen, and for half the limit of what is not.
std::vector<LengthAdvice> advice(const ChannelNoise& channel, const NoiseBands& bands, double wanted) {
  const NoiseFit& fit = channel.fit;
  const RecordLength length(bands, fit);
  const double record = static_cast<double>(channel.samples) / channel.rate;
  std::vector<LengthAdvice> rows;
  std::size_t process = 0;
  for (std::size_t t = 0; t < fit.terms.size(); ++t) {
    const FittedTerm& term = fit.terms[t];
    const TermWords said = words(term.unit.term, channel.kind);
    if (!term.kept) {
      const double limit = coefficient(term.unit.term, term.upper_limit, channel.rate);
      rows.push_back({said.name, "below " + amount(limit, said.unit), "limit " + amount(0.5 * limit, said.unit),
                      record * length.times_for(t, term.upper_limit / (4.0 * normal_one_sided_95))});
      continue;
    }
    const auto percent = [](double share) { return fmt::format("{:.2g} %", 100.0 * share); };
    rows.push_back({said.name, percent(std::sqrt(fit.value_covariance(t, t)) / fit.value[t]), percent(wanted),
                    record * length.times_for(t, 2.0 * wanted * term.squared)});
    if (term.unit.term != NoiseTerm::markov) continue;
    const std::size_t at = fit.terms.size() + process++;
    rows.push_back({"markov_time", percent(std::sqrt(fit.value_covariance(at, at)) / fit.value[at]), percent(wanted),
                    record * length.times_for(at, wanted * term.unit.markov_time)});
  }
  return rows;
}

/// Given: lines of which the fit does not use the frequencies.
void conclude(NoiseBands bands, const std::vector<SpectralLine>& avoided, double begin, const Settings& settings,
              ChannelNoise& result) {
  take_warm_up(bands, avoided, begin, options_of(settings, result.rate), result);
  const Findings changes = changes_along(bands, begin, result.rate, result.label);
  for (const Findings& some : {changes, uneven_bias(bands, begin, result.rate, rate_unit(result.kind), result.label),
                               times_at_bound(result), process_like_filter(result), filter_near_slow_terms(result)})
    result.findings.insert(result.findings.end(), some.begin(), some.end());
  result.advice = advice(result, bands, settings.number("wanted_sd"));
}

}  // namespace

void fit_likelihood(NoiseBands bands, const std::function<std::vector<SpectralLine>()>& lines_of_record, double begin,
                    const Settings& settings, ChannelNoise& result) {
  const auto options = options_of(settings, result.rate);
  result.fit = fit_noise(bands, options);
  std::vector<SpectralLine> lines;
  if (result.fit.model_error > 0.0) {
    lines = lines_of_record();
    if (!lines.empty()) {
      bands = without_lines(bands, lines);
      result.fit = fit_noise(bands, options);
      result.findings.push_back({Finding::Severity::warning,
                                 "lines_avoided",
                                 values_of(lines, result),
                                 result.label,
                                 {lines.size(), {}, {}}});
    }
  }
  conclude(std::move(bands), lines, begin, settings, result);
}

void fit_likelihood_and_lines(const EvenSignal& signal, const Settings& settings, ChannelNoise& result) {
  const auto options = options_of(settings, result.rate);
  const NoiseBands bands(signal.values);
  const PeriodicFit periodic = fit_beside_lines(signal.values, bands, fit_noise(bands, options), options);
  result.fit = periodic.fit;
  result.lines = periodic.lines;
  if (!periodic.lines.empty())
    result.findings.push_back({Finding::Severity::warning,
                               "lines_subtracted",
                               values_of(periodic.lines, result),
                               result.label,
                               {periodic.lines.size(), {}, {}}});
  if (!periodic.wandering.empty())
    result.findings.push_back({Finding::Severity::warning,
                               "unsteady_lines_avoided",
                               values_of(periodic.wandering, result),
                               result.label,
                               {periodic.wandering.size(), {}, {}}});
  conclude(periodic.bands, periodic.wandering, signal.begin, settings, result);
}

/// The noise about a line looks smaller than it is until the variance that the line took is added again: a trend that
/// is not significant against the smaller noise is not significant at all.
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

}  // namespace tumble::allan_noise
