#include "tumble/methods/allan_noise/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tumble/core/columns.hpp"
#include "tumble/language/say.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::allan_noise {
namespace {

constexpr double peak_of_markov = 0.617;  ///< [sd sqrt(T)] greatest Allan deviation of a Markov process, at 1.89 T

constexpr std::size_t most_composites = 6;  ///< shown of each channel

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
  return deviation / peak_of_markov;
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

/// A density of a channel as Kalibr and the like take it.
struct Density {
  const ChannelNoise& channel;
  std::size_t t;

  bool rate() const { return channel.kind == QuantityKind::angular_rate; }
  bool white() const { return channel.fit.terms[t].unit.term == NoiseTerm::white; }
  bool shown() const { return channel.fit.shown[t]; }
  std::string key() const {
    return fmt::format("{}_{}", rate() ? "gyroscope" : "accelerometer", white() ? "noise_density" : "random_walk");
  }
  std::string value() const {
    const FittedTerm& term = channel.fit.terms[t];
    return shown() ? fmt::format("{:.4g}", value_of(channel, t))
                   : fmt::format("< {:.3g}", coefficient(term.unit.term, term.upper_limit, channel.rate));
  }
  std::string sd() const {
    if (!shown()) return "";
    return fmt::format("{:.2g} %", 100.0 * (std::sqrt(channel.fit.value_covariance(t, t)) / channel.fit.value[t]));
  }
  std::string unit() const {
    return white() ? (rate() ? "rad/s/sqrt(Hz)" : "m/s^2/sqrt(Hz)") : (rate() ? "rad/s^2/sqrt(Hz)" : "m/s^3/sqrt(Hz)");
  }
  std::string of_a_sample() const {
    if (!white() || !shown()) return "";
    return fmt::format("sd of one sample at {:.6g} Hz: {:.4g} {}", channel.rate,
                       value_of(channel, t) * std::sqrt(channel.rate), rate() ? "rad/s" : "m/s^2");
  }
};

}  // namespace

Table readings_table(const std::vector<ChannelNoise>& channels) {
  struct Row {
    const ChannelNoise& channel;
    std::size_t t;
    Strongest at;

    const FittedTerm& term() const { return channel.fit.terms[t]; }
    TermWords said() const { return words(term().unit.term, channel.kind); }
    const DeviationPoint& point() const { return channel.curve[at.point]; }
    std::string text(double value) const {
      const std::string unit = said().unit;
      return fmt::format("{:.4g} {}", Unit::parse(unit).difference_from_si(value), unit);
    }
  };
  std::vector<Row> rows;
  for (const auto& channel : channels)
    for (std::size_t t = 0; t < channel.fit.terms.size() && !channel.curve.empty(); ++t)
      if (channel.fit.shown[t]) rows.push_back({channel, t, strongest(channel, channel.fit.terms[t])});
  const auto read = [](const Row& r) {
    return r.text(read_off(r.term().unit.term, r.point().tau, r.point().deviation));
  };
  return tabulate(
      "readings", "what a straight line on the Allan curve reads, beside the identified term", rows,
      {{"channel", [](const Row& r) { return r.channel.label; }},
       {"term", [](const Row& r) { return r.said().name; }},
       {"identified", [](const Row& r) { return r.text(value_of(r.channel, r.t)); }},
       {"read off the curve", read},
       {"at tau", [](const Row& r) { return say_seconds(r.point().tau); }},
       {"share of the term there", [](const Row& r) { return fmt::format("{:.0f} %", 100.0 * r.at.share); }}});
}

Table densities_table(const std::vector<ChannelNoise>& channels) {
  std::vector<Density> rows;
  for (const auto& channel : channels)
    for (const NoiseTerm which : {NoiseTerm::white, NoiseTerm::random_walk})
      for (std::size_t t = 0; t < channel.fit.terms.size(); ++t)
        if (channel.fit.terms[t].unit.term == which && channel.kind != QuantityKind::other)  // not of a clock
          rows.push_back({channel, t});
  return tabulate("densities",
                  "continuous noise density and bias random walk (Kalibr and the like); a flicker has neither", rows,
                  {{"channel", [](const Density& d) { return d.channel.label; }},
                   {"key", &Density::key},
                   {"value", &Density::value},
                   {"sd", &Density::sd},
                   {"unit", &Density::unit},
                   {"not to be entered instead", &Density::of_a_sample}});
}

Table composites_table(const std::vector<ChannelNoise>& channels) {
  struct Row {
    const ChannelNoise& channel;
    const NoiseComposite& composite;
  };
  std::vector<Row> rows;
  for (const auto& channel : channels)
    for (std::size_t i = 0; i < std::min(most_composites, channel.fit.composites.size()); ++i)
      rows.push_back({channel, channel.fit.composites[i]});
  const auto terms = [](const Row& r) {
    std::string text;
    for (const auto& term : r.composite.terms)
      text += (text.empty() ? "" : " + ") +
              (term.term == NoiseTerm::markov ? fmt::format("Markov {}", say_seconds(term.markov_time / r.channel.rate))
                                              : words(term.term, r.channel.kind).symbol);
    return text;
  };
  return tabulate("composites", "sets of terms by AICc above that of the one chosen", rows,
                  {{"channel", [](const Row& r) { return r.channel.label; }},
                   {"terms", terms},
                   {"parameters", [](const Row& r) { return r.composite.parameters; }},
                   {"AICc", [](const Row& r) { return std::round(10.0 * r.composite.aicc) / 10.0; }},
                   {"every term significant", [](const Row& r) { return r.composite.supported ? "yes" : "no"; }}});
}

Table advice_table(const std::vector<ChannelNoise>& channels, double wanted) {
  struct Row {
    const ChannelNoise& channel;
    const LengthAdvice& advice;
  };
  std::vector<Row> rows;
  for (const auto& channel : channels)
    for (const auto& advice : channel.advice) rows.push_back({channel, advice});
  const auto length = [](const Row& r) { return length_text(static_cast<double>(r.channel.samples) / r.channel.rate); };
  const auto takes = [](const Row& r) { return r.advice.seconds > 0.0 ? length_text(r.advice.seconds) : ""; };
  return tabulate("advice", fmt::format("length of record for {:.3g} % of each term (one sd)", 100.0 * wanted), rows,
                  {{"channel", [](const Row& r) { return r.channel.label; }},
                   {"term", [](const Row& r) { return r.advice.term; }},
                   {"now", [](const Row& r) { return r.advice.now; }},
                   {"from this record of", length},
                   {"wanted", [](const Row& r) { return r.advice.wanted; }},
                   {"takes", takes}});
}

}  // namespace tumble::allan_noise
