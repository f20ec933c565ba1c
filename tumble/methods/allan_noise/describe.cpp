#include "tumble/methods/allan_noise/describe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/say.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/symmetric_factor.hpp"
#include "tumble/methods/allan_noise/periodic.hpp"
#include "tumble/methods/allan_noise/tables.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::allan_noise {
namespace {

using Severity = Finding::Severity;

std::string shown(double value_si, const std::string& unit) {
  return fmt::format("{:.3g} {}", Unit::parse(unit).difference_from_si(value_si), unit);
}

std::string duration(const ChannelNoise& channel) {
  const double seconds = static_cast<double>(channel.samples) / channel.rate;
  return seconds < 2.0 * hour ? say_seconds(std::round(seconds)) : fmt::format("{:.3g} h", seconds / hour);
}

/// What would show a term that this record does not.
std::string remedy(NoiseTerm term) {
  switch (term) {
    case NoiseTerm::quantization:
      return "twice the sampling rate shows half of that";
    case NoiseTerm::white:
      return "hidden by the other terms at every averaging time";
    case NoiseTerm::flicker:
      return "4 times the record shows half of that";
    case NoiseTerm::random_walk:
      return "twice the record shows half of that";
    case NoiseTerm::markov:
      return "a longer record shows less";
  }
  return "";
}

/// "" for the first Gauss-Markov process, "_2" for the second and so on.
std::string number_of(const NoiseFit& fit, std::size_t term) {
  std::size_t before = 0;
  for (std::size_t t = 0; t < term; ++t) before += fit.terms[t].unit.term == NoiseTerm::markov ? 1 : 0;
  return before > 0 && fit.terms[term].unit.term == NoiseTerm::markov ? fmt::format("_{}", before + 1) : "";
}

/// One parameter of a channel: where its variance stands in the fit's covariance, and its derivative by that.
struct Source {
  std::size_t index = 0;
  double gain = 1.0;
};

/// Adds the terms that are kept and the correlation times; the ramp comes last and has no source.
std::vector<Source> add_parameters(const ChannelNoise& channel, Estimate& estimate) {
  const NoiseFit& fit = channel.fit;
  std::vector<Source> sources;
  std::size_t process = 0;
  for (std::size_t t = 0; t < fit.terms.size(); ++t) {
    const FittedTerm& term = fit.terms[t];
    if (!term.kept) continue;
    const TermWords said = words(term.unit.term, channel.kind);
    const std::string number = number_of(fit, t);
    const double root = coefficient(term.unit.term, term.squared, channel.rate), value = root * term.root_correction;
    estimate.parameters.push_back({channel.label + "." + said.name + number, said.symbol, Unit::parse(said.unit), value,
                                   said.description, term.degrees_of_freedom});
    sources.push_back({t, 0.5 * root / term.squared});
    if (term.unit.term != NoiseTerm::markov) continue;
    estimate.parameters.push_back({channel.label + ".markov_time" + number, "T_c", Unit::parse("s"),
                                   term.unit.markov_time / channel.rate, "correlation time of the Gauss-Markov bias",
                                   term.degrees_of_freedom});
    sources.push_back({fit.terms.size() + process++, 1.0 / channel.rate});
  }
  if (fit.ramp.kept)
    estimate.parameters.push_back({channel.label + ".rate_ramp", "R", Unit::parse(ramp_unit(channel.kind)),
                                   fit.ramp.slope * channel.rate, "straight trend of the bias",
                                   fit.ramp.degrees_of_freedom});
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

/// Covariances by the derivative of the root; channels are taken as independent. The ramp is linear in the record, as
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
        noise(base + a, base + b) = one.gain * sources[c][b].gain * fit.covariance(one.index, sources[c][b].index);
      shape[base + a] = one.gain * one.gain * fit.model_error_variance[one.index];
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

std::string decision(const FittedTerm& term) {
  if (!term.kept && term.squared <= 0.0) return "left out: not above zero";
  if (!term.kept) return fmt::format("left out: chance alone gives this in {:.0f} %", 100.0 * term.chance);
  if (term.chance < 1e-6) return "kept: chance gives this less than once in a million";
  return fmt::format("kept: chance gives this in {:.2g} %", 100.0 * term.chance);
}

void add_rows(const ChannelNoise& channel, Table& table) {
  for (std::size_t t = 0; t < channel.fit.terms.size(); ++t) {
    const FittedTerm& term = channel.fit.terms[t];
    const TermWords said = words(term.unit.term, channel.kind);
    const auto of = [&](double squared) {
      return shown(coefficient(term.unit.term, std::max(squared, 0.0), channel.rate), said.unit);
    };
    const double sd = 0.5 * term.squared_sd / std::sqrt(std::max(term.squared, term.squared_sd)) *
                      coefficient(term.unit.term, 1.0, channel.rate);
    const auto digits = [](double value, double scale) { return std::round(value * scale) / scale; };
    table.rows.push_back({channel.label, said.name + number_of(channel.fit, t), said.symbol, of(term.squared),
                          shown(sd, said.unit), digits(term.z, 100.0), digits(term.improvement, 10.0),
                          of(term.upper_limit), decision(term)});
  }
  const NoiseRamp& ramp = channel.fit.ramp;
  const std::string unit = ramp_unit(channel.kind);
  const double z = ramp.slope / ramp.sd, slope = ramp.slope * channel.rate, sd = ramp.sd * channel.rate,
               limit = std::abs(slope) + student_quantile(0.975, ramp.degrees_of_freedom) * sd;
  table.rows.push_back(
      {channel.label, "rate_ramp", "R", shown(slope, unit), shown(sd, unit), std::round(100.0 * z) / 100.0, "",
       shown(limit, unit),
       fmt::format("{}: chance alone gives this in {:.2g} %", ramp.kept ? "kept" : "left out", 100.0 * ramp.chance)});
}

Curve line(const ChannelNoise& channel, const std::string& name, const std::vector<double>& variances) {
  Curve curve{channel.label + " " + name,
              "allan deviation " + channel.label,
              {"averaging time", Unit::parse("s"), {}},
              {"Allan deviation", Unit::parse(rate_unit(channel.kind)), {}},
              {},
              {},
              "",
              true,
              false};
  for (std::size_t i = 0; i < variances.size(); ++i) {
    curve.x.values.push_back(channel.curve[i].tau);
    curve.y.values.push_back(std::sqrt(variances[i]));
  }
  return curve;
}

void add_curves(const ChannelNoise& channel, std::vector<Curve>& curves) {
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
      variances.push_back(term.squared * unit_allan_variance(term.unit, static_cast<double>(channel.curve[i].factor)));
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
  curves.push_back(line(channel, "fitted", sum));
  for (auto& curve : terms) curves.push_back(std::move(curve));
}

void add_dropped(const ChannelNoise& channel, Findings& findings) {
  std::string list;
  for (const FittedTerm& term : channel.fit.terms) {
    if (term.kept) continue;
    const TermWords said = words(term.unit.term, channel.kind);
    list += fmt::format("{}{} below {} ({})", list.empty() ? "" : ", ", said.name,
                        shown(coefficient(term.unit.term, term.upper_limit, channel.rate), said.unit),
                        remedy(term.unit.term));
  }
  if (list.empty()) return;
  findings.push_back({Severity::info,
                      fmt::format("not seen in this record of {}, with 95 % limits: {}", duration(channel), list),
                      channel.label});
}

/// One finding for what is said alike of several channels.
Findings merged(const Findings& findings) {
  Findings result;
  for (const auto& finding : findings) {
    const auto same = std::find_if(result.begin(), result.end(), [&](const Finding& other) {
      return other.message == finding.message && other.severity == finding.severity;
    });
    if (same == result.end())
      result.push_back(finding);
    else
      same->where += ", " + finding.where;
  }
  return result;
}

/// Where the curve leaves the terms: the greatest departure in units of its statistical sd, and what makes such a bump.
void add_departure(const ChannelNoise& channel, Findings& findings) {
  const NoiseFit& fit = channel.fit;
  if (fit.model_error == 0.0) return;
  const auto departure = [](const NoiseResidual& one) { return std::abs(one.ratio - 1.0) / one.sd; };
  const NoiseResidual& worst =
      *std::max_element(fit.residuals.begin(), fit.residuals.end(),
                        [&](const NoiseResidual& a, const NoiseResidual& b) { return departure(a) < departure(b); });
  const double tau = 0.5 / worst.frequency / channel.rate;
  const double above = std::sqrt(std::max(0.0, worst.ratio)) - 1.0;
  std::string message = fmt::format(
      "the terms follow the {} to {:.2g} % only (chi-square {:.3g} with {:g} degrees of freedom); intervals are "
      "widened to match. The greatest departure is {:+.2g} % at {}",
      channel.likelihood ? "noise" : "deviation", 50.0 * fit.model_error, fit.chi_square, fit.degrees_of_freedom,
      100.0 * above, channel.likelihood ? fmt::format("{:.3g} Hz", 0.5 / tau) : say_seconds(tau));
  // A sine of frequency f lifts the deviation most at tau = 0.371/f, where tan x = 2 x with x = pi f tau.
  if (above > 0.0)
    message += fmt::format(": a vibration or a periodic disturbance near {:.2g} Hz does that",
                           (channel.likelihood ? 0.5 : 0.371) / tau);
  else
    message += ": a filter in the instrument, or motion at other times, does that";
  findings.push_back({Severity::warning, message, channel.label});
}

}  // namespace

std::string rate_unit(QuantityKind kind) { return kind == QuantityKind::angular_rate ? "deg/h" : "ug"; }

std::string ramp_unit(QuantityKind kind) { return rate_unit(kind) + "/h"; }

TermWords words(NoiseTerm term, QuantityKind kind) {
  const bool rate = kind == QuantityKind::angular_rate;
  switch (term) {
    case NoiseTerm::quantization:
      return {"quantization_noise", "Q", rate ? "arcsec" : "mm/s",
              rate ? "white noise of the angle" : "white noise of the velocity"};
    case NoiseTerm::white:
      return {rate ? "angle_random_walk" : "velocity_random_walk", "N", rate ? "deg/sqrt(h)" : "(m/s)/sqrt(h)",
              rate ? "white noise of the rate" : "white noise of the specific force"};
    case NoiseTerm::flicker:
      return {"bias_instability", "B", rate_unit(kind),
              "flicker of the bias; the flat part of the deviation is 0.664 B"};
    case NoiseTerm::random_walk:
      return {rate ? "rate_random_walk" : "acceleration_random_walk", "K", rate ? "deg/h/sqrt(h)" : "ug/sqrt(h)",
              "random walk of the bias"};
    case NoiseTerm::markov:
      return {"markov_sd", "sigma_c", rate_unit(kind), "first-order Gauss-Markov bias"};
  }
  return {};
}

double coefficient(NoiseTerm term, double squared, double rate) {
  switch (term) {
    case NoiseTerm::quantization:
      return std::sqrt(squared) / rate;
    case NoiseTerm::white:
      return std::sqrt(squared / rate);
    case NoiseTerm::random_walk:
      return std::sqrt(squared * rate);
    case NoiseTerm::flicker:
    case NoiseTerm::markov:
      break;
  }
  return std::sqrt(squared);
}

Estimate describe_noise(const std::vector<ChannelNoise>& channels, double wanted_sd) {
  Estimate estimate;
  std::vector<std::vector<Source>> sources;
  std::vector<ChannelNoise> fitted;
  Table table{"terms", "noise terms tried on each channel", {}, {}};
  for (const char* name :
       {"channel", "term", "symbol", "value tried", "sd", "z", "fall of -2 ln L", "95 % upper limit", "decision"})
    table.columns.push_back({name, Unit()});
  for (const auto& channel : channels) {
    estimate.findings.insert(estimate.findings.end(), channel.findings.begin(), channel.findings.end());
    if (!channel.failure.empty()) {
      estimate.findings.push_back({Severity::error, channel.failure, channel.label});
      continue;
    }
    sources.push_back(add_parameters(channel, estimate));
    add_rows(channel, table);
    add_curves(channel, estimate.curves);
    add_departure(channel, estimate.findings);
    add_dropped(channel, estimate.findings);
    estimate.fit.observations += channel.fit.residuals.size();
    estimate.fit.degrees_of_freedom += channel.fit.degrees_of_freedom;
    estimate.fit.chi_square += channel.fit.chi_square;
    estimate.fit.condition = std::max(estimate.fit.condition, channel.fit.condition);
    fitted.push_back(channel);
  }
  add_covariance(fitted, sources, estimate);
  estimate.tables.push_back(std::move(table));
  estimate.tables.push_back(readings_table(fitted));
  estimate.tables.push_back(densities_table(fitted));
  if (std::any_of(fitted.begin(), fitted.end(), [](const ChannelNoise& one) { return one.likelihood; })) {
    estimate.tables.push_back(composites_table(fitted));
    estimate.tables.push_back(advice_table(fitted, wanted_sd));
  }
  estimate.findings = merged(estimate.findings);
  return estimate;
}

}  // namespace tumble::allan_noise
