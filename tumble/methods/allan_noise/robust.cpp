#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "tumble/core/columns.hpp"
#include "tumble/methods/allan_noise/fit.hpp"
#include "tumble/methods/allan_noise/outliers.hpp"
#include "tumble/units/error.hpp"

namespace tumble::allan_noise {
namespace {

constexpr std::size_t most_rows = 200;

double time_at(const ChannelNoise& channel, std::size_t sample) {
  return channel.begin + static_cast<double>(sample) / channel.rate;
}

std::string shown_in(double value_si, const std::string& unit) {
  return fmt::format("{:.4g} {}", Unit::parse(unit).difference_from_si(value_si), unit);
}

/// A term with its standard deviation in SI.
struct Value {
  double value = 0.0, sd = 0.0;
};

Value value_of(const FittedTerm& term, double rate) {
  const double root = coefficient(term.unit.term, term.squared, rate);
  return {root * term.root_correction, 0.5 * root * term.squared_sd / term.squared};
}

/// An event with all channels that show it.
struct Together {
  const ChannelNoise* worst_channel = nullptr;
  Outlier worst;
  double from = 0.0, to = 0.0;
  std::set<std::size_t> channels;  ///< in their order
};

/// Knocks of all channels by time: those that touch are one.
std::vector<Together> knocks_of(const std::vector<ChannelNoise>& channels) {
  struct One {
    std::size_t number;
    const ChannelNoise* channel;
    Outlier event;
    double from, to;
  };
  std::vector<One> all;
  for (std::size_t number = 0; number < channels.size(); ++number) {
    const ChannelNoise& channel = channels[number];
    if (!channel.failure.empty() || !are_rare(channel.outliers, channel.samples)) continue;
    for (const Outlier& event : channel.outliers)
      if (is_knock(event))
        all.push_back({number, &channel, event, time_at(channel, event.begin), time_at(channel, event.end)});
  }
  std::ranges::stable_sort(all, {}, &One::from);
  std::vector<Together> together;
  for (const One& one : all) {
    if (together.empty() || one.from > together.back().to) together.push_back({nullptr, {}, one.from, one.to, {}});
    Together& last = together.back();
    last.to = std::max(last.to, one.to);
    if (!last.worst_channel || std::abs(one.event.deviations) > std::abs(last.worst.deviations)) {
      last.worst = one.event;
      last.worst_channel = one.channel;
    }
    last.channels.insert(one.number);
  }
  return together;
}

std::string labels_of(const std::set<std::size_t>& numbers, const std::vector<ChannelNoise>& channels) {
  std::string labels;
  for (const std::size_t number : numbers) labels += (labels.empty() ? "" : ", ") + channels[number].label;
  return labels;
}

void describe_knocks(const std::vector<ChannelNoise>& channels, Estimate& estimate) {
  const auto knocks = knocks_of(channels);
  if (knocks.empty()) return;
  const auto largest = [](const Together& k) {
    return k.worst_channel->label + " " + shown_in(k.worst.departure, rate_unit(k.worst_channel->kind));
  };
  estimate.tables.push_back(tabulate(
      "knocks", "short events that are far from the noise beside them",
      std::vector(knocks.begin(), knocks.begin() + static_cast<std::ptrdiff_t>(std::min(most_rows, knocks.size()))),
      {{"from", "s", &Together::from},
       {"to", "s", &Together::to},
       {"channels", [&](const Together& k) { return labels_of(k.channels, channels); }},
       {"largest", largest},
       {"over its usual sd",
        [](const Together& k) { return std::round(10.0 * std::abs(k.worst.deviations)) / 10.0; }}}));
  const auto& worst =
      *std::ranges::max_element(knocks, {}, [](const Together& one) { return std::abs(one.worst.deviations); });
  const bool aside =
      std::ranges::any_of(channels, [](const ChannelNoise& channel) { return !channel.knocks_set_aside.empty(); });
  std::vector<FindingValue> values;
  values.emplace_back("largest", worst.worst.departure, rate_unit(worst.worst_channel->kind));
  values.emplace_back("deviations", std::abs(worst.worst.deviations));
  values.emplace_back("channels", labels_of(worst.channels, channels));
  estimate.findings.push_back({Finding::Severity::warning,
                               aside ? "knocks_set_aside" : "knocks",
                               values,
                               worst.worst_channel->label,
                               {knocks.size(), Place(knocks[0].from), Place(worst.from)}});
}

/// The term whose value the outliers change most, in its own sd.
const FittedTerm* most_changed(const ChannelNoise& channel, double& change) {
  const FittedTerm* most = nullptr;
  change = 0.0;
  for (std::size_t t = 0; t < power_law_terms.size(); ++t) {
    const FittedTerm &with = channel.fit.terms[t], &without = channel.robust->terms[t];
    if (!with.kept || !without.kept) continue;
    const Value a = value_of(with, channel.rate), b = value_of(without, channel.rate);
    const double off = std::abs(a.value - b.value) / a.value;
    if (off > change) {
      change = off;
      most = &without;
    }
  }
  return most;
}

/// A noise term of a record as it is, and without its outliers.
struct RobustTerm {
  const ChannelNoise& channel;
  const FittedTerm &with, &without;

  TermWords said() const { return words(with.unit.term, channel.kind); }
  std::string value(const FittedTerm& term) const {
    return term.kept ? shown_in(value_of(term, channel.rate).value, said().unit) : "not significant";
  }
  std::string sd(const FittedTerm& term) const {
    return term.kept ? shown_in(value_of(term, channel.rate).sd, said().unit) : "";
  }
};

Table robust_table(const std::vector<ChannelNoise>& channels) {
  std::vector<RobustTerm> rows;
  for (const auto& channel : channels) {
    if (!channel.failure.empty() || !channel.robust) continue;
    for (std::size_t t = 0; t < power_law_terms.size(); ++t) {
      const FittedTerm &with = channel.fit.terms[t], &without = channel.robust->terms[t];
      if (with.kept || without.kept) rows.push_back({channel, with, without});
    }
  }
  return tabulate("robust", "the noise terms of the record as it is, and without its outliers", rows,
                  {{"channel", [](const RobustTerm& r) { return r.channel.label; }},
                   {"term", [](const RobustTerm& r) { return r.said().name; }},
                   {"value", [](const RobustTerm& r) { return r.value(r.with); }},
                   {"sd", [](const RobustTerm& r) { return r.sd(r.with); }},
                   {"without outliers", [](const RobustTerm& r) { return r.value(r.without); }},
                   {"its sd", [](const RobustTerm& r) { return r.sd(r.without); }},
                   {"outliers", [](const RobustTerm& r) { return r.channel.robust_removed; }}});
}

Finding outliers_finding(const ChannelNoise& channel) {
  double change = 0.0;
  const FittedTerm* term = most_changed(channel, change);
  Occurrences often{channel.robust_removed, {}, {}};
  double most = 0.0;
  for (const Outlier& event : channel.outliers) {
    if (!often.first.given()) often.first = Place(time_at(channel, event.worst));
    if (std::abs(event.deviations) <= most) continue;
    most = std::abs(event.deviations);
    often.worst = Place(time_at(channel, event.worst));
  }
  std::vector<FindingValue> values;
  values.emplace_back("share", static_cast<double>(channel.robust_removed) / static_cast<double>(channel.samples), "%");
  values.emplace_back("deviations", most);
  constexpr double matters = 0.02;
  if (term == nullptr || change < matters) return {Finding::Severity::info, "outliers", values, channel.label, often};
  const TermWords said = words(term->unit.term, channel.kind);
  const auto place = static_cast<std::size_t>(term - channel.robust->terms.data());
  values.emplace_back("term", said.name);
  values.emplace_back("value", value_of(channel.fit.terms[place], channel.rate).value, said.unit);
  values.emplace_back("without", value_of(*term, channel.rate).value, said.unit);
  return {Finding::Severity::warning, "outliers_change_terms", values, channel.label, often};
}

/// Outliers that are no knocks, of a record that is read once: the terms without them are not known.
Finding single_outliers(const ChannelNoise& channel) {
  Occurrences often{0, {}, {}};
  double most = 0.0;
  for (const Outlier& event : channel.outliers) {
    if (is_knock(event) && are_rare(channel.outliers, channel.samples)) continue;
    if (often.count++ == 0) often.first = Place(time_at(channel, event.worst));
    if (std::abs(event.deviations) <= most) continue;
    most = std::abs(event.deviations);
    often.worst = Place(time_at(channel, event.worst));
  }
  return {Finding::Severity::warning, "single_outliers", {{"deviations", most}}, channel.label, often};
}

}  // namespace

void add_robust_terms(const EvenSignal& signal, const Settings& settings, ChannelNoise& result) {
  const bool aside = !result.knocks_set_aside.empty();
  if (std::ranges::all_of(result.outliers, [&](const Outlier& one) { return aside && is_knock(one); })) return;
  EvenSignal rest = signal;
  rest.made = without_outliers(signal.values, result.robust_removed);
  rest.values = rest.made;
  if (result.robust_removed == 0) return;
  ChannelNoise robust;
  robust.label = result.label;
  robust.kind = result.kind;
  robust.rate = result.rate;
  robust.samples = result.samples;
  try {
    fit_likelihood_and_lines(rest, settings, robust);
    result.robust = robust.fit;
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_data) throw;
  }
}

void describe_outliers(const std::vector<ChannelNoise>& channels, Estimate& estimate) {
  describe_knocks(channels, estimate);
  for (const auto& channel : channels) {
    if (!channel.failure.empty()) continue;
    if (channel.fit.scatter_ratio > 1.0)
      estimate.findings.push_back(
          {Finding::Severity::info, "noise_not_gaussian", {{"ratio", channel.fit.scatter_ratio}}, channel.label});
    if (channel.robust)
      estimate.findings.push_back(outliers_finding(channel));
    else if (const Finding single = single_outliers(channel); single.occurrences.count > 0)
      estimate.findings.push_back(single);
  }
  add_unless_empty(estimate.tables, robust_table(channels));
}

}  // namespace tumble::allan_noise
