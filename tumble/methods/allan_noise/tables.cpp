#include "tumble/methods/allan_noise/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tumble/language/say.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::allan_noise {
namespace {

constexpr std::size_t most_composites = 6;  ///< shown of each channel

Table with_columns(const char* name, const std::string& caption, std::initializer_list<const char*> columns) {
  Table table{name, caption, {}, {}};
  for (const char* column : columns) table.columns.push_back({column, Unit()});
  return table;
}

double curve_at(const ChannelNoise& channel, const FittedTerm& term, std::size_t i) {
  return fitted_allan_variance(channel.fit, term, static_cast<double>(channel.curve[i].factor));
}

/// Point of the curve where a term has its greatest share of the fitted variance.
struct Strongest {
  std::size_t point = 0;
  double share = 0.0;
};

Strongest strongest(const ChannelNoise& channel, const FittedTerm& term) {
  Strongest best;
  for (std::size_t i = 0; i < channel.curve.size(); ++i) {
    double sum = 0.0;
    for (const auto& other : channel.fit.terms)
      if (other.kept) sum += curve_at(channel, other, i);
    if (sum > 0.0 && curve_at(channel, term, i) / sum > best.share) best = {i, curve_at(channel, term, i) / sum};
  }
  return best;
}

/// The coefficient of the line of a term's slope through one point of the curve.
double read_off(NoiseTerm term, double tau, double deviation) {
  switch (term) {
    case NoiseTerm::quantization:
      return deviation * tau / std::numbers::sqrt3;
    case NoiseTerm::white:
      return deviation * std::sqrt(tau);
    case NoiseTerm::flicker:
      return deviation / std::sqrt(2.0 * std::numbers::ln2 / pi);
    case NoiseTerm::random_walk:
      return deviation * std::sqrt(3.0 / tau);
    case NoiseTerm::markov:
      break;
  }
  return deviation / 0.617;
}

std::string length_text(double seconds) {
  if (!std::isfinite(seconds)) return "no length";
  if (seconds < 7200.0) return say_seconds(seconds < 10.0 ? seconds : std::round(seconds));
  if (seconds < 172800.0) return fmt::format("{:.3g} h", seconds / hour);
  return fmt::format("{:.3g} days", seconds / 86400.0);
}

double value_of(const ChannelNoise& channel, std::size_t t) {
  return channel.fit.value[t] * coefficient(channel.fit.terms[t].unit.term, 1.0, channel.rate);
}

void add_density(const ChannelNoise& channel, NoiseTerm which, Table& table) {
  if (channel.kind == QuantityKind::other) return;  // of a clock
  const bool rate = channel.kind == QuantityKind::angular_rate, white = which == NoiseTerm::white;
  const std::string key =
      fmt::format("{}_{}", rate ? "gyroscope" : "accelerometer", white ? "noise_density" : "random_walk");
  const std::string unit =
      white ? (rate ? "rad/s/sqrt(Hz)" : "m/s^2/sqrt(Hz)") : (rate ? "rad/s^2/sqrt(Hz)" : "m/s^3/sqrt(Hz)");
  for (std::size_t t = 0; t < channel.fit.terms.size(); ++t) {
    const FittedTerm& term = channel.fit.terms[t];
    if (term.unit.term != which) continue;
    const bool shown = channel.fit.shown[t];
    const double value = value_of(channel, t);
    const double limit = coefficient(which, term.upper_limit, channel.rate);
    const double relative = shown ? std::sqrt(channel.fit.value_covariance(t, t)) / channel.fit.value[t] : 0.0;
    table.rows.push_back({channel.label, key, shown ? fmt::format("{:.4g}", value) : fmt::format("< {:.3g}", limit),
                          shown ? fmt::format("{:.2g} %", 100.0 * relative) : "", unit,
                          white && shown ? fmt::format("sd of one sample at {:.6g} Hz: {:.4g} {}", channel.rate,
                                                       value * std::sqrt(channel.rate), rate ? "rad/s" : "m/s^2")
                                         : ""});
  }
}

}  // namespace

Table readings_table(const std::vector<ChannelNoise>& channels) {
  Table table =
      with_columns("readings", "what a straight line on the Allan curve reads, beside the identified term",
                   {"channel", "term", "identified", "read off the curve", "at tau", "share of the term there"});
  for (const auto& channel : channels) {
    if (channel.curve.empty()) continue;
    for (std::size_t t = 0; t < channel.fit.terms.size(); ++t) {
      const FittedTerm& term = channel.fit.terms[t];
      if (!channel.fit.shown[t]) continue;
      const TermWords said = words(term.unit.term, channel.kind);
      const Strongest at = strongest(channel, term);
      const auto& point = channel.curve[at.point];
      const Unit unit = Unit::parse(said.unit);
      const auto shown = [&](double value) {
        return fmt::format("{:.4g} {}", unit.difference_from_si(value), said.unit);
      };
      table.rows.push_back({channel.label, said.name, shown(value_of(channel, t)),
                            shown(read_off(term.unit.term, point.tau, point.deviation)), say_seconds(point.tau),
                            fmt::format("{:.0f} %", 100.0 * at.share)});
    }
  }
  return table;
}

Table densities_table(const std::vector<ChannelNoise>& channels) {
  Table table = with_columns(
      "densities", "continuous noise density and bias random walk (Kalibr and the like); a flicker has neither",
      {"channel", "key", "value", "sd", "unit", "not to be entered instead"});
  for (const auto& channel : channels)
    for (const NoiseTerm term : {NoiseTerm::white, NoiseTerm::random_walk}) add_density(channel, term, table);
  return table;
}

Table composites_table(const std::vector<ChannelNoise>& channels) {
  Table table = with_columns("composites", "sets of terms by AICc above that of the one chosen",
                             {"channel", "terms", "parameters", "AICc", "every term significant"});
  for (const auto& channel : channels) {
    std::size_t shown = 0;
    for (const auto& one : channel.fit.composites) {
      if (shown++ == most_composites) break;
      std::string terms;
      for (const auto& term : one.terms)
        terms +=
            (terms.empty() ? "" : " + ") + (term.term == NoiseTerm::markov
                                                ? fmt::format("Markov {}", say_seconds(term.markov_time / channel.rate))
                                                : words(term.term, channel.kind).symbol);
      table.rows.push_back({channel.label, terms, static_cast<double>(one.parameters),
                            std::round(10.0 * one.aicc) / 10.0, one.supported ? "yes" : "no"});
    }
  }
  return table;
}

Table advice_table(const std::vector<ChannelNoise>& channels, double wanted) {
  Table table =
      with_columns("advice", fmt::format("length of record for {:.3g} % of each term (one sd)", 100.0 * wanted),
                   {"channel", "term", "now", "from this record of", "wanted", "takes"});
  for (const auto& channel : channels) {
    const double length = static_cast<double>(channel.samples) / channel.rate;
    for (const auto& row : channel.advice) {
      const std::string takes = row.seconds > 0.0 ? length_text(row.seconds) : "";
      table.rows.push_back({channel.label, row.term, row.now, length_text(length), row.wanted, takes});
    }
  }
  return table;
}

}  // namespace tumble::allan_noise
