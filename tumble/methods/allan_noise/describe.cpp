#include "tumble/methods/allan_noise/describe.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/symmetric_factor.hpp"
#include "tumble/methods/allan_noise/periodic.hpp"
#include "tumble/methods/allan_noise/tables.hpp"
#include "tumble/methods/allan_noise/words.hpp"
#include "tumble/reduce/answer.hpp"

namespace tumble::allan_noise {
namespace {

using Severity = Finding::Severity;

/// [periods] where a sine lifts the deviation most: tan x = 2 x with x = pi f tau.
constexpr double tau_of_sine = 0.371;

std::string shown(double value_si, const std::string& unit) {
  return fmt::format("{:.3g} {}", Unit::parse(unit).difference_from_si(value_si), unit);
}

double duration(const ChannelNoise& channel) { return static_cast<double>(channel.samples) / channel.rate; }

/// How a record could show a smaller term.
Phrase remedy(NoiseTerm term) {
  switch (term) {
    case NoiseTerm::quantization:
      return {"twice_the_rate_shows_half"};
    case NoiseTerm::white:
      return {"other_terms_hide_it"};
    case NoiseTerm::flicker:
      return {"four_records_show_half"};
    case NoiseTerm::random_walk:
      return {"two_records_show_half"};
    case NoiseTerm::markov:
      break;
  }
  return {"longer_record_shows_less"};
}

/// "" for the first Gauss-Markov process, "_2" for the second and so on.
std::string number_of(const NoiseFit& fit, std::size_t term) {
  std::size_t before = 0;
  for (std::size_t t = 0; t < term; ++t) before += fit.terms[t].unit.term == NoiseTerm::markov ? 1 : 0;
  return before > 0 && fit.terms[term].unit.term == NoiseTerm::markov ? fmt::format("_{}", before + 1) : "";
}

/// One parameter of a channel: where its variance stands in the fit's covariance, and its unit there [SI].
struct Source {
  std::size_t index = 0;
  double gain = 1.0;
};

void add_filter(const ChannelNoise& channel, std::size_t first, Estimate& estimate, std::vector<Source>& sources) {
  const NoiseFit& fit = channel.fit;
  const auto above_zero = [&](std::size_t i) {
    return fit.value[i] >
           student_quantile(two_sided_95, fit.filter_freedom[i - first]) * std::sqrt(fit.value_covariance(i, i));
  };
  if (!fit.filter.given() || !above_zero(first)) return;
  estimate.parameters.push_back(
      {channel.label + ".bandwidth", "f_3dB", Unit::parse("Hz"), fit.value[first] * channel.rate,
       "-3 dB frequency of the sensor's own filter: " + filter_name(fit.filter), fit.filter_freedom[0]});
  sources.push_back({first, channel.rate});
  if (!fit.filter.two_poles() || !above_zero(first + 1)) return;
  estimate.parameters.push_back({channel.label + ".damping", "zeta", Unit(), fit.value[first + 1],
                                 "damping of the sensor's own filter", fit.filter_freedom[1]});
  sources.push_back({first + 1, 1.0});
}

/// Adds the terms that are shown, the correlation times and the filter; the ramp comes last and has no source.
std::vector<Source> add_parameters(const ChannelNoise& channel, Estimate& estimate) {
  const NoiseFit& fit = channel.fit;
  std::vector<Source> sources;
  const std::size_t before = estimate.parameters.size();
  std::size_t process = 0;
  for (std::size_t t = 0; t < fit.terms.size(); ++t) {
    const FittedTerm& term = fit.terms[t];
    const bool markov = term.unit.term == NoiseTerm::markov;
    const std::size_t time = fit.terms.size() + process;
    if (markov) ++process;
    if (!fit.shown[t]) continue;
    const TermWords said = words(term.unit.term, channel.kind);
    const std::string number = number_of(fit, t);
    const double unit = coefficient(term.unit.term, 1.0, channel.rate);
    estimate.parameters.push_back({channel.label + "." + said.name + number, said.symbol, Unit::parse(said.unit),
                                   unit * fit.value[t], said.description, term.degrees_of_freedom});
    sources.push_back({t, unit});
    if (!markov) continue;
    estimate.parameters.push_back({channel.label + ".markov_time" + number, "T_c", Unit::parse("s"),
                                   fit.value[time] / channel.rate, "correlation time of the Gauss-Markov bias",
                                   term.degrees_of_freedom});
    sources.push_back({time, 1.0 / channel.rate});
  }
  add_filter(channel, fit.terms.size() + process, estimate, sources);
  if (fit.ramp.kept)
    estimate.parameters.push_back(
        {channel.label + (channel.kind == QuantityKind::other ? ".frequency_drift" : ".rate_ramp"), "R",
         Unit::parse(ramp_unit(channel.kind)), fit.ramp.slope * channel.rate, "straight trend of the bias",
         fit.ramp.degrees_of_freedom});
  for (std::size_t i = before; i < estimate.parameters.size(); ++i) estimate.parameters[i].channels = {channel.label};
  return sources;
}

/// Subtracts the variances of the departure from the covariance of all. Of terms that are strongly correlated not all
/// of it can be subtracted so that a covariance remains: then half of it is, or a quarter, and so on, and the sum
/// stays.
///
/// Given     covariance  of all sources [SI], p x p;   departure   [SI^2] p
void subtract_departure(Matrix& covariance, std::vector<double>& departure) {
  constexpr double rounding = 1e-10;
  constexpr int most_halves = 30;
  std::vector<double> scale;
  for (std::size_t i = 0; i < covariance.rows; ++i) scale.push_back(covariance(i, i));
  for (int half = 0;; ++half) {
    Matrix rest = covariance;
    for (std::size_t i = 0; i < rest.rows; ++i) rest(i, i) -= departure[i];
    if (half == most_halves || symmetric_factor(rest, scale).excess < rounding) {
      covariance = std::move(rest);
      return;
    }
    for (double& variance : departure) variance *= 0.5;
  }
}

/// Covariances of the parameters; channels are taken as independent. The ramp is linear in the record, as
/// the others are quadratic: not correlated with them.
void add_covariance(const std::vector<ChannelNoise>& channels, const std::vector<std::vector<Source>>& sources,
                    Estimate& estimate) {
  const std::size_t all = estimate.parameters.size();
  Matrix noise(all, all);
  std::vector<double> shape(all, 0.0);
  std::size_t base = 0;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const NoiseFit& fit = channels[c].fit;
    for (std::size_t a = 0; a < sources[c].size(); ++a) {
      const Source& one = sources[c][a];
      for (std::size_t b = 0; b < sources[c].size(); ++b)
        noise(base + a, base + b) =
            one.gain * sources[c][b].gain * fit.value_covariance(one.index, sources[c][b].index);
      shape[base + a] = one.gain * one.gain * fit.value_error_variance[one.index];
      noise(base + a, base + a) = std::max(noise(base + a, base + a), shape[base + a]);
    }
    base += sources[c].size();
    if (!fit.ramp.kept) continue;
    noise(base, base) = std::pow(fit.ramp.sd * channels[c].rate, 2);
    ++base;
  }
  subtract_departure(noise, shape);
  settle(estimate,
         {from_covariance("output noise", noise), from_variances("departure of the record from the terms", shape)});
}

std::string decision(const FittedTerm& term, bool shown) {
  if (!term.kept && term.squared <= 0.0) return "not used: not above zero";
  if (!term.kept) return fmt::format("not used: not significant (p = {:.2f})", term.chance);
  if (!shown) return "used; not above zero with 95 %";
  if (std::isinf(term.improvement)) return "used: the only term";
  return term.chance < least_shown_p ? "used (p < 1e-6)" : fmt::format("used (p = {:.2g})", term.chance);
}

struct StabilityRow {
  std::string channel, term, symbol, value, sd;
  double z;
  Table::Cell improvement;
  std::string limit, decision;
};

void add_stability_rows(const ChannelNoise& channel, std::vector<StabilityRow>& rows) {
  for (std::size_t t = 0; t < channel.fit.terms.size(); ++t) {
    const FittedTerm& term = channel.fit.terms[t];
    const TermWords said = words(term.unit.term, channel.kind);
    const auto of = [&](double squared) {
      return shown(coefficient(term.unit.term, std::max(squared, 0.0), channel.rate), said.unit);
    };
    const double sd = 0.5 * term.squared_sd / std::sqrt(std::max(term.squared, term.squared_sd)) *
                      coefficient(term.unit.term, 1.0, channel.rate);
    const auto digits = [](double value, double scale) { return std::round(value * scale) / scale; };
    const bool known = std::isfinite(sd);  // two short pieces can tell that a term is not needed, and no more
    rows.push_back({.channel = channel.label,
                    .term = said.name + number_of(channel.fit, t),
                    .symbol = said.symbol,
                    .value = of(term.squared),
                    .sd = known ? shown(sd, said.unit) : "unknown",
                    .z = digits(term.z, 100.0),
                    .improvement = std::isinf(term.improvement) ? Table::Cell("") : digits(term.improvement, 10.0),
                    .limit = of(term.upper_limit),
                    .decision = decision(term, channel.fit.shown[t])});
  }
  const NoiseRamp& ramp = channel.fit.ramp;
  const std::string unit = ramp_unit(channel.kind);
  const double z = ramp.slope / ramp.sd, slope = ramp.slope * channel.rate, sd = ramp.sd * channel.rate,
               limit = std::abs(slope) + student_quantile(two_sided_95, ramp.degrees_of_freedom) * sd;
  rows.push_back({channel.label, "rate_ramp", "R", shown(slope, unit), shown(sd, unit), std::round(100.0 * z) / 100.0,
                  "", shown(limit, unit),
                  (ramp.kept ? "used" : "not used: not significant") + fmt::format(" (p = {:.2g})", ramp.chance)});
}

Table terms_table(const std::vector<ChannelNoise>& channels) {
  std::vector<StabilityRow> rows;
  for (const auto& channel : channels) add_stability_rows(channel, rows);
  return tabulate("terms", "noise terms tried on each channel", rows,
                  {{"channel", &StabilityRow::channel},
                   {"term", &StabilityRow::term},
                   {"symbol", &StabilityRow::symbol},
                   {"value tried", &StabilityRow::value},
                   {"sd", &StabilityRow::sd},
                   {"z", &StabilityRow::z},
                   {"fall of -2 ln L", &StabilityRow::improvement},
                   {"95 % upper limit", &StabilityRow::limit},
                   {"decision", &StabilityRow::decision}});
}

Curve line(const ChannelNoise& channel, const std::string& name, const std::vector<double>& variances) {
  Curve curve{.name = channel.label + " " + name,
              .figure = "allan deviation " + channel.label,
              .x = {"averaging time", Unit::parse("s")},
              .y = {"Allan deviation", Unit::parse(rate_unit(channel.kind))},
              .logarithmic = true};
  for (std::size_t i = 0; i < variances.size(); ++i) add_point(curve, channel.curve[i].tau, std::sqrt(variances[i]));
  return curve;
}

void add_stability_curves(const ChannelNoise& channel, std::vector<Curve>& curves) {
  std::vector<double> measured, sum(channel.curve.size(), 0.0);
  for (const auto& point : channel.curve) measured.push_back(point.deviation * point.deviation);
  Curve points = line(channel, "allan_deviation", measured);
  points.points = true;
  points.band = fmt::format("{:g} % confidence", 100.0 * channel.confidence);
  for (const auto& point : channel.curve) {
    points.lower.push_back(point.lower);
    points.upper.push_back(point.upper);
  }
  curves.push_back(std::move(points));
  std::vector<Curve> terms;
  for (const FittedTerm& term : channel.fit.terms) {
    if (!term.kept) continue;
    std::vector<double> variances;
    for (std::size_t i = 0; i < sum.size(); ++i) {
      variances.push_back(fitted_allan_variance(channel.fit, term, static_cast<double>(channel.curve[i].factor)));
      sum[i] += variances.back();
    }
    terms.push_back(line(channel, words(term.unit.term, channel.kind).name, variances));
  }
  if (!channel.lines.empty()) {
    std::vector<double> variances(sum.size(), 0.0);
    for (std::size_t i = 0; i < sum.size(); ++i) {
      for (const FittedLine& one : channel.lines)
        variances[i] += allan_variance_of(one, static_cast<double>(channel.curve[i].factor));
      sum[i] += variances[i];
    }
    terms.push_back(line(channel, "lines", variances));
  }
  if (!channel.course_variance.empty()) {
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += channel.course_variance[i];
    terms.push_back(line(channel, "warm-up and temperature", channel.course_variance));
  }
  curves.push_back(line(channel, "fitted", sum));
  for (auto& curve : terms) curves.push_back(std::move(curve));
}

/// A term that is not significant in some channels of one kind: where, and its greatest limit.
struct HiddenTerm {
  TermWords term;
  Phrase remedy;
  double limit = 0.0, length = 0.0;  ///< [SI] at 95 %, [s] of the record that gives this limit
  std::vector<std::string> channels;
  bool supported = false;  ///< in the set chosen, though other sets explain the record nearly as well without it
  Occurrences occurrences{.count = 0, .first = {}, .worst = {}};
};

/// Adds the channel to the terms that it does not show.
void add_hidden(const ChannelNoise& channel, std::vector<HiddenTerm>& hidden) {
  for (std::size_t t = 0; t < channel.fit.terms.size(); ++t) {
    const FittedTerm& term = channel.fit.terms[t];
    if (channel.fit.shown[t]) continue;
    const TermWords name = words(term.unit.term, channel.kind);
    const double limit = coefficient(term.unit.term, term.upper_limit, channel.rate);
    auto entry = std::ranges::find_if(hidden, [&](const HiddenTerm& one) {
      return one.term.name == name.name && one.term.unit == name.unit && one.supported == term.kept;
    });
    if (entry == hidden.end()) entry = hidden.insert(entry, {.term = name, .remedy = remedy(term.unit.term)});
    entry->supported = term.kept;
    Occurrences& occurrences = entry->occurrences;
    if (occurrences.count == 0) occurrences.first = channel.label;
    if (occurrences.count == 0 || limit > entry->limit) {
      occurrences.worst = channel.label;
      entry->limit = limit;
      entry->length = duration(channel);
    }
    if (!entry->channels.empty() && entry->channels.back() == channel.label) continue;  // another Gauss-Markov process
    ++occurrences.count;
    entry->channels.push_back(channel.label);
  }
}

Findings findings_of(const std::vector<HiddenTerm>& hidden) {
  Findings findings;
  for (const HiddenTerm& one : hidden) {
    findings.push_back({Severity::info,
                        one.supported ? "noise_term_may_be_another" : "noise_term_not_significant",
                        {{"term", one.term.name},
                         {"limit", one.limit, one.term.unit},
                         {"length", one.length, "s"},
                         {"remedy", one.remedy}},
                        fmt::format("{}", fmt::join(one.channels, ", ")),
                        one.occurrences});
    for (const std::string& channel : one.channels)
      findings.back().hidden.push_back({channel + "." + one.term.name, channel});
  }
  return findings;
}

/// One finding for several channels with equal codes and values as shown.
Findings merged(const Findings& findings) {
  Findings result;
  for (const auto& finding : findings) {
    const auto same = std::ranges::find_if(result, [&](const Finding& other) {
      return other.code == finding.code && other.severity == finding.severity && other.message == finding.message;
    });
    if (same == result.end())
      result.push_back(finding);
    else
      same->where += ", " + finding.where;
  }
  return result;
}

/// The greatest departure of the curve from the terms in units of its statistical sd, and what causes such a bump.
void add_departure(const ChannelNoise& channel, Findings& findings) {
  const NoiseFit& fit = channel.fit;
  if (fit.model_error == 0.0) return;
  const auto departure = [](const NoiseResidual& one) { return std::abs(one.ratio - 1.0) / one.sd; };
  const NoiseResidual& worst = *std::ranges::max_element(fit.residuals, {}, departure);
  const double tau = 0.5 / worst.frequency / channel.rate, change = std::sqrt(std::max(0.0, worst.ratio)) - 1.0;
  std::vector<FindingValue> values{{"share", 0.5 * fit.model_error, "%"},
                                   {"chi_square", fit.chi_square},
                                   {"degrees_of_freedom", fit.degrees_of_freedom},
                                   {"change", change, "%"}};
  if (channel.likelihood) {
    values.emplace_back("frequency", 0.5 / tau, "Hz");
    findings.push_back(
        {Severity::warning, change > 0.0 ? "noise_above_terms" : "noise_below_terms", values, channel.label});
  } else {
    values.emplace_back("tau", tau, "s");
    values.emplace_back("frequency", tau_of_sine / tau, "Hz");
    findings.push_back(
        {Severity::warning, change > 0.0 ? "deviation_above_terms" : "deviation_below_terms", values, channel.label});
  }
}

}  // namespace

double fitted_allan_variance(const NoiseFit& fit, const FittedTerm& term, double factor) {
  if (term.unit.term != NoiseTerm::white || !fit.filter.given())
    return term.squared * unit_allan_variance(term.unit, factor);
  const auto autocovariance = filtered_autocovariance(fit.filter);
  return term.squared * (mean_covariance(autocovariance, factor, 0) - mean_covariance(autocovariance, factor, 1));
}

Estimate describe_noise(const std::vector<ChannelNoise>& channels, double wanted_sd) {
  Estimate estimate;
  std::vector<std::vector<Source>> sources;
  std::vector<ChannelNoise> fitted;
  std::vector<HiddenTerm> hidden;
  for (const auto& channel : channels) {
    estimate.findings.insert(estimate.findings.end(), channel.findings.begin(), channel.findings.end());
    if (!channel.failure.empty()) {
      estimate.findings.push_back(
          {Severity::error, "channel_not_analysed", {{"reason", channel.failure}}, channel.label});
      continue;
    }
    sources.push_back(add_parameters(channel, estimate));
    add_stability_curves(channel, estimate.curves);
    add_departure(channel, estimate.findings);
    add_hidden(channel, hidden);
    estimate.fit.observations += channel.fit.residuals.size();
    estimate.fit.degrees_of_freedom += channel.fit.degrees_of_freedom;
    estimate.fit.chi_square += channel.fit.chi_square;
    estimate.fit.condition = std::max(estimate.fit.condition, channel.fit.condition);
    fitted.push_back(channel);
  }
  add_covariance(fitted, sources, estimate);
  estimate.tables = {terms_table(fitted), readings_table(fitted), densities_table(fitted)};
  if (std::any_of(fitted.begin(), fitted.end(), [](const ChannelNoise& one) { return one.likelihood; })) {
    estimate.tables.push_back(composites_table(fitted));
    estimate.tables.push_back(advice_table(fitted, wanted_sd));
  }
  for (auto& finding : findings_of(hidden)) estimate.findings.push_back(std::move(finding));
  estimate.findings = merged(estimate.findings);
  return estimate;
}

}  // namespace tumble::allan_noise
