#include "tumble/methods/allan_noise/together.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/math/rounding_share.hpp"
#include "tumble/math/stability/joint_stability.hpp"
#include "tumble/methods/allan_noise/disturbed.hpp"
#include "tumble/methods/allan_noise/input.hpp"
#include "tumble/units/error.hpp"

namespace tumble::allan_noise {
namespace {

using Severity = Finding::Severity;

constexpr double whiter_by = 1e-3;  ///< [1] of the variance, by which a longer averaging time must be whiter

/// Indices of the channels that were sampled together: of one run of one recording, as long and as fast as each other.
using Group = std::vector<std::size_t>;

std::vector<Group> groups_of(const std::vector<ChannelRun>& stretches, const std::vector<ChannelNoise>& channels) {
  const auto together = [&](std::size_t a, std::size_t b) {
    return stretches[a].recording == stretches[b].recording && stretches[a].run == stretches[b].run &&
           channels[a].samples == channels[b].samples &&
           std::abs(channels[a].rate / channels[b].rate - 1.0) < rounding_share;
  };
  std::vector<Group> groups;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (!channels[i].failure.empty()) continue;
    const auto place =
        std::find_if(groups.begin(), groups.end(), [&](const Group& group) { return together(group[0], i); });
    if (place == groups.end())
      groups.push_back({i});
    else
      place->push_back(i);
  }
  return groups;
}

double white_share(const ChannelNoise& channel, double factor) {
  double white = 0.0, sum = 0.0;
  for (const auto& term : channel.fit.terms) {
    if (!term.kept) continue;
    const double part = term.squared * unit_allan_variance(term.unit, factor);
    sum += part;
    if (term.unit.term == NoiseTerm::white) white += part;
  }
  return sum > 0.0 ? white / sum : 0.0;
}

struct Pair {
  std::size_t a = 0, b = 0;
  std::vector<AllanCorrelation> points;
  std::size_t whitest = 0;  ///< point at which the lesser of the two shares of white noise is largest
};

std::size_t whitest(const std::vector<AllanCorrelation>& points, const ChannelNoise& a, const ChannelNoise& b) {
  double most = -1.0;
  std::size_t at = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double factor = static_cast<double>(points[i].factor);
    const double share = std::min(white_share(a, factor), white_share(b, factor));
    if (share > most + whiter_by) {
      most = share;
      at = i;
    }
  }
  return at;
}

void correlate(const Group& group, const std::vector<EvenSignal>& signals, const std::vector<ChannelNoise>& channels,
               const std::vector<std::size_t>& factors, std::vector<Pair>& pairs) {
  std::vector<std::span<const double>> values;
  for (const auto i : group) values.push_back(signals[i].values);
  for (auto& pair : allan_correlations(values, signals[group[0]].rate, factors, 0.95)) {
    const std::size_t a = group[pair.a], b = group[pair.b], at = whitest(pair.points, channels[a], channels[b]);
    pairs.push_back({a, b, std::move(pair.points), at});
  }
}

/// Correlation over the averaging time; `limits`: with its limits.
Curve curve_of(const Pair& pair, const std::vector<ChannelNoise>& channels, bool limits) {
  Curve curve{.name = channels[pair.a].label + " with " + channels[pair.b].label,
              .figure = "correlation of channels over the averaging time",
              .x = {"averaging time", Unit::parse("s")},
              .y = {"correlation", Unit()},
              .logarithmic_x = true};
  if (limits) curve.band = "95 % limits";
  for (const auto& point : pair.points)
    if (limits)
      add_point(curve, point.tau, point.correlation, point.lower, point.upper);
    else
      add_point(curve, point.tau, point.correlation);
  return curve;
}

/// One finding for all pairs that correlate significantly; table correlation has them all.
void add_correlated(const std::vector<Pair>& pairs, std::size_t comparisons, const std::vector<ChannelNoise>& channels,
                    double significance, Findings& findings) {
  Occurrences occurrences{.count = 0, .first = {}, .worst = {}};
  AllanCorrelation greatest;
  std::string where;
  for (const Pair& pair : pairs) {
    const AllanCorrelation& at = pair.points[pair.whitest];
    if (!(at.chance * static_cast<double>(comparisons) < significance)) continue;
    const Place place(channels[pair.a].label + ", " + channels[pair.b].label);
    where += (where.empty() ? "" : "; ") + place.label;
    if (occurrences.count++ == 0) occurrences.first = place;
    if (occurrences.worst.given() && std::abs(at.correlation) <= std::abs(greatest.correlation)) continue;
    greatest = at;
    occurrences.worst = place;
  }
  if (occurrences.count == 0) return;
  findings.push_back({Severity::warning,
                      "channels_correlated",
                      {{"correlation", greatest.correlation},
                       {"lower", greatest.lower},
                       {"upper", greatest.upper},
                       {"pairs", comparisons},
                       {"significance", significance}},
                      where,
                      occurrences});
}

void describe_pairs(std::vector<Pair> pairs, const std::vector<ChannelNoise>& channels, double significance,
                    Estimate& estimate) {
  const bool limits = pairs.size() <= 3;
  const std::size_t comparisons = pairs.size();
  std::erase_if(pairs, [](const Pair& pair) { return pair.points.empty(); });
  if (pairs.empty()) return;
  for (const auto& pair : pairs) estimate.curves.push_back(curve_of(pair, channels, limits));
  const auto at = [](const Pair& pair) -> const AllanCorrelation& { return pair.points[pair.whitest]; };
  const auto share = [&](const Pair& pair) {
    const double factor = static_cast<double>(at(pair).factor);
    return 100.0 * std::min(white_share(channels[pair.a], factor), white_share(channels[pair.b], factor));
  };
  estimate.tables.push_back(tabulate(
      "correlation", "correlation of channels at the averaging time where both are whitest", pairs,
      {{"channel", [&](const Pair& p) { return channels[p.a].label; }},
       {"with", [&](const Pair& p) { return channels[p.b].label; }},
       {"averaging time", "s", [&](const Pair& p) { return at(p).tau; }},
       {"correlation", [&](const Pair& p) { return std::round(1e4 * at(p).correlation) / 1e4; }},
       {"95 % limits", [&](const Pair& p) { return fmt::format("{:+.4f} to {:+.4f}", at(p).lower, at(p).upper); }},
       {"chance", [&](const Pair& p) { return fmt::format("{:.2g} %", 100.0 * at(p).chance); }},
       {"white share", [&](const Pair& p) { return fmt::format("{:.0f} %", share(p)); }}}));
  add_correlated(pairs, comparisons, channels, significance, estimate.findings);
}

/// Deviations of the instruments of a group by themselves, as curves.
struct Hat {
  std::vector<Curve> curves;
  std::size_t negative = 0, impossible = 0;  ///< variances not above zero, and those whose upper limit is zero
};

/// The deviation of one instrument by itself at one averaging time.
struct HatRow {
  std::string channel;
  Unit unit;  ///< of the deviation, as shown
  HatPoint::Instrument instrument;
  double tau, edf;

  std::string text(double variance) const {
    return fmt::format("{:.3g}", unit.difference_from_si(std::sqrt(variance)));
  }
};

Table hat_table(const std::vector<HatRow>& rows, double confidence) {
  const auto deviation = [](const HatRow& r) {
    return r.instrument.variance > 0.0 ? r.text(r.instrument.variance) : "not above 0";
  };
  const auto limits = [](const HatRow& r) {
    return fmt::format("{} to {}", r.text(r.instrument.lower), r.text(r.instrument.upper));
  };
  return tabulate("hat",
                  "deviation of each instrument by itself, from the differences of instruments of the same input", rows,
                  {{"channel", &HatRow::channel},
                   {"averaging time", "s", &HatRow::tau},
                   {"deviation", deviation},
                   {fmt::format("{:g} % limits", 100.0 * confidence), limits},
                   {"unit", [](const HatRow& r) { return r.unit.text(); }},
                   {"degrees of freedom", [](const HatRow& r) { return std::round(10.0 * r.edf) / 10.0; }}});
}

Hat hat_of(const Group& group, const std::vector<HatPoint>& points, const std::vector<ChannelNoise>& channels,
           std::vector<HatRow>& rows) {
  const Unit unit = Unit::parse(rate_unit(channels[group[0]].kind));
  Hat hat{std::vector<Curve>(group.size())};
  for (const auto& point : points) {
    for (std::size_t k = 0; k < group.size(); ++k) {
      const auto& instrument = point.instruments[k];
      hat.negative += instrument.variance <= 0.0 ? 1 : 0;
      hat.impossible += instrument.upper == 0.0 ? 1 : 0;
      rows.push_back({channels[group[k]].label, unit, instrument, point.tau, point.edf});
      if (instrument.variance > 0.0)
        add_point(hat.curves[k], point.tau, std::sqrt(instrument.variance), std::sqrt(instrument.lower),
                  std::sqrt(instrument.upper));
    }
  }
  return hat;
}

void describe_hat(const Group& group, const std::vector<EvenSignal>& signals, const std::vector<ChannelNoise>& channels,
                  const std::vector<std::size_t>& factors, double confidence, Estimate& estimate,
                  std::vector<HatRow>& rows) {
  const QuantityKind kind = channels[group[0]].kind;
  std::vector<std::span<const double>> values;
  std::string labels;
  for (const auto i : group) {
    values.push_back(signals[i].values);
    labels += (labels.empty() ? "" : ", ") + channels[i].label;
  }
  const auto points = three_cornered_hat(values, signals[group[0]].rate, factors, confidence);
  Hat hat = hat_of(group, points, channels, rows);
  for (std::size_t k = 0; k < group.size(); ++k) {
    Curve& curve = hat.curves[k];
    if (curve.x.values.empty()) continue;
    curve.name = channels[group[k]].label + " by itself";
    curve.figure = fmt::format("{} of the same input: {}",
                               kind == QuantityKind::angular_rate ? "gyros" : "accelerometers", labels);
    curve.x.name = "averaging time";
    curve.x.unit = Unit::parse("s");
    curve.y.name = "Allan deviation";
    curve.y.unit = Unit::parse(rate_unit(kind));
    curve.band = fmt::format("{:g} % confidence", 100.0 * confidence);
    curve.logarithmic = curve.points = true;
    estimate.curves.push_back(std::move(curve));
  }
  if (hat.negative > 0)
    estimate.findings.push_back({hat.impossible > 0 ? Severity::warning : Severity::info,
                                 hat.impossible > 0 ? "hat_variances_below_zero" : "hat_variances_not_above_zero",
                                 {{"variances", points.size() * group.size()}, {"below", hat.impossible}},
                                 labels,
                                 {hat.negative, {}, {}}});
}

std::vector<std::size_t> octaves(std::size_t samples, const Settings& settings) {
  const double longest = settings.number("longest_fraction") * static_cast<double>(samples);
  return averaging_factors(std::max<std::size_t>(1, static_cast<std::size_t>(longest)), 0.0);
}

void describe_hats(const std::vector<Group>& groups, const std::vector<EvenSignal>& signals,
                   const std::vector<ChannelNoise>& channels, const Settings& settings, Estimate& estimate) {
  const double confidence = settings.number("confidence");
  std::vector<HatRow> rows;
  for (const auto& group : groups) {
    for (const auto kind : {QuantityKind::angular_rate, QuantityKind::specific_force}) {
      Group alike;
      std::copy_if(group.begin(), group.end(), std::back_inserter(alike),
                   [&](std::size_t i) { return channels[i].kind == kind; });
      if (alike.size() < 3) continue;
      describe_hat(alike, signals, channels, octaves(channels[alike[0]].samples, settings), confidence, estimate, rows);
    }
  }
  if (rows.empty())
    estimate.findings.push_back({Severity::warning, "too_few_instruments_for_hat", {}});
  else
    estimate.tables.push_back(hat_table(rows, confidence));
}

}  // namespace

void describe_together(const std::vector<ChannelRun>& stretches, const std::vector<ChannelNoise>& channels,
                       const Settings& settings, Estimate& estimate) {
  const bool correlation = settings.flag("correlation"), hat = settings.flag("hat");
  if (!correlation && !hat) return;
  std::vector<EvenSignal> signals(stretches.size());
  for (std::size_t i = 0; i < stretches.size(); ++i)
    if (channels[i].failure.empty()) signals[i] = rate_signal(stretches[i], settings);
  const auto groups = groups_of(stretches, channels);
  for (const auto& group : groups)  // disturbed parts of one are missing in all, so that they remain comparable
    for (const auto i : group)
      for (const auto k : group) set_missing(channels[k].set_aside, signals[i]);
  if (hat) describe_hats(groups, signals, channels, settings, estimate);
  if (!correlation) return;
  std::vector<Pair> pairs;
  for (const auto& group : groups)
    correlate(group, signals, channels, octaves(channels[group[0]].samples, settings), pairs);
  describe_pairs(std::move(pairs), channels, settings.number("significance"), estimate);
}

}  // namespace tumble::allan_noise
