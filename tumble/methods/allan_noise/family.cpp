#include "tumble/methods/allan_noise/family.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/math/stability/allan_family_curve.hpp"
#include "tumble/methods/allan_noise/input.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble::allan_noise {
namespace {

struct Member {
  const char* name;
  Stability measure;
  const char* title;
  bool of_angle;  ///< a time or an angle [u s], not a rate
};

constexpr Member members[] = {
    {"adev", Stability::allan, "Allan", false},
    {"oadev", Stability::overlapping_allan, "overlapping Allan", false},
    {"mdev", Stability::modified_allan, "modified Allan", false},
    {"tdev", Stability::time, "time deviation", true},
    {"hdev", Stability::hadamard, "Hadamard", false},
    {"ohdev", Stability::overlapping_hadamard, "overlapping Hadamard", false},
    {"totdev", Stability::total, "total", false},
    {"mtotdev", Stability::modified_total, "modified total", false},
    {"ttotdev", Stability::time_total, "time total", true},
    {"htotdev", Stability::hadamard_total, "Hadamard total", false},
    {"pdev", Stability::parabolic, "parabolic", false},
    {"theo1", Stability::theo1, "Theo1", false},
    {"theoh", Stability::theoh, "TheoH", false},
    {"mtie", Stability::peak_interval_error, "MTIE", true},
    {"tierms", Stability::rms_interval_error, "TIE rms", true},
};

const Member& member_of(Stability measure) {
  return *std::find_if(std::begin(members), std::end(members),
                       [&](const Member& member) { return member.measure == measure; });
}

std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words;
  std::string word;
  for (const char c : text + ",") {
    if (c == ',' || c == ' ' || c == '[' || c == ']' || c == '"' || c == '\'') {
      if (!word.empty()) words.push_back(word);
      word.clear();
    } else {
      word += c;
    }
  }
  return words;
}

std::vector<Member> asked_for(const std::string& text) {
  const auto words = words_of(text);
  std::vector<Member> result;
  for (const auto& member : members)
    if (std::any_of(words.begin(), words.end(),
                    [&](const std::string& word) { return word == "all" || word == member.name; }))
      result.push_back(member);
  return result;
}

Unit unit_of(const Member& member, QuantityKind kind) {
  if (member.of_angle && kind == QuantityKind::other) return Unit::parse("s");
  if (member.of_angle) return Unit::parse(kind == QuantityKind::angular_rate ? "arcsec" : "mm/s");
  return Unit::parse(rate_unit(kind));
}

/// The time deviation is the modified one times tau/sqrt(3), which may have been asked for too.
std::vector<DeviationPoint> from_modified(const ChannelNoise& channel, Stability measure) {
  const Stability modified = measure == Stability::time ? Stability::modified_allan : Stability::modified_total;
  const bool is_time = measure == Stability::time || measure == Stability::time_total;
  for (const auto& one : channel.family) {
    if (!is_time || one.measure != modified) continue;
    auto points = one.points;
    for (auto& point : points)
      for (double* const value : {&point.deviation, &point.lower, &point.upper}) *value *= point.tau / std::sqrt(3.0);
    return points;
  }
  return {};
}

std::string noise_name(int alpha, QuantityKind kind) {
  if (kind == QuantityKind::other && alpha > 0) return alpha == 2 ? "white phase" : "flicker phase";
  const std::string of = kind == QuantityKind::angular_rate     ? "rate"
                         : kind == QuantityKind::specific_force ? "specific force"
                                                                : "frequency";
  switch (alpha) {
    case 2:
      return kind == QuantityKind::angular_rate ? "white angle" : "white velocity";
    case 1:
      return kind == QuantityKind::angular_rate ? "flicker angle" : "flicker velocity";
    case 0:
      return "white " + of;
    case -1:
      return "flicker " + of;
    case -2:
      return "random walk " + of;
    default:
      return "steeper than a walk";
  }
}

/// A point of a measure of a channel.
struct FamilyPoint {
  const ChannelNoise& channel;
  const Member& member;
  const DeviationPoint& point;

  bool known() const { return point.edf > 0.0; }
  std::string text(double value) const {
    return fmt::format("{:.4g}", unit_of(member, channel.kind).difference_from_si(value));
  }
  std::string limits() const { return known() ? text(point.lower) + " to " + text(point.upper) : "none known"; }
};

Table family_table(const std::vector<ChannelNoise>& channels) {
  std::vector<FamilyPoint> points;
  for (const auto& channel : channels)
    if (channel.failure.empty())
      for (const auto& one : channel.family)
        for (const auto& point : one.points) points.push_back({channel, member_of(one.measure), point});
  return tabulate(
      "family", "measures of stability, with limits by the noise type at each averaging time", points,
      {{"channel", [](const FamilyPoint& p) { return p.channel.label; }},
       {"deviation", [](const FamilyPoint& p) { return p.member.name; }},
       {"averaging time", "s", [](const FamilyPoint& p) { return p.point.tau; }},
       {"value", [](const FamilyPoint& p) { return p.text(p.point.deviation); }},
       {"limits", &FamilyPoint::limits},
       {"unit", [](const FamilyPoint& p) { return unit_of(p.member, p.channel.kind).text(); }},
       {"degrees of freedom", [](const FamilyPoint& p) { return p.known() ? fmt::format("{:.1f}", p.point.edf) : ""; }},
       {"noise type", [](const FamilyPoint& p) { return noise_name(p.point.alpha, p.channel.kind); }}});
}

Curve curve_of(const ChannelNoise& channel, const Member& member, const std::vector<DeviationPoint>& points) {
  Curve curve{.name = fmt::format("{} {}", channel.label, member.name),
              .figure = "family of deviations " + channel.label,
              .x = {"averaging time", Unit::parse("s")},
              .y = {member.of_angle ? "deviation of the integral" : "deviation", unit_of(member, channel.kind)},
              .logarithmic = true};
  const bool known = std::all_of(points.begin(), points.end(), [](const DeviationPoint& one) { return one.edf > 0.0; });
  if (known) curve.band = fmt::format("{:g} % confidence", 100.0 * channel.confidence);
  for (const auto& point : points)
    if (known)
      add_point(curve, point.tau, point.deviation, point.lower, point.upper);
    else
      add_point(curve, point.tau, point.deviation);
  return curve;
}

}  // namespace

std::string family_names() {
  std::string text;
  for (const auto& member : members) text += std::string(member.name) + ", ";
  return text + "or all";
}

Problems family_problems(const std::string& asked) {
  std::vector<std::string> names{"all"};
  Problems problems;
  for (const auto& member : members) names.emplace_back(member.name);
  for (const auto& word : words_of(asked))
    if (std::find(names.begin(), names.end(), word) == names.end())
      problems.push_back(
          say("deviations = {}: expected any of {}{}", Name{word}, Name{family_names()}, did_you_mean(word, names)));
  return problems;
}

void add_family(const EvenSignal& signal, const Settings& settings, ChannelNoise& result) {
  if (!settings.has("deviations")) return;
  const AllanOptions options = curve_options_of(settings, signal);
  for (const auto& member : asked_for(settings.word("deviations"))) {
    auto points = from_modified(result, member.measure);
    if (points.empty()) points = stability_curve(member.measure, signal.values, signal.rate, options, result.curve);
    if (points.empty())
      result.findings.push_back({Finding::Severity::warning,
                                 "no_averaging_time_between_gaps",
                                 {{"deviation", member.name}, {"title", member.title}},
                                 result.label});
    else
      result.family.push_back({member.measure, std::move(points)});
  }
}

void describe_family(const std::vector<ChannelNoise>& channels, Estimate& estimate) {
  for (const auto& channel : channels) {
    if (channel.family.empty() || !channel.failure.empty()) continue;
    const Member& plain = member_of(Stability::overlapping_allan);
    if (std::none_of(channel.family.begin(), channel.family.end(),
                     [&](const FamilyCurve& one) { return one.measure == plain.measure; }))
      estimate.curves.push_back(curve_of(channel, plain, channel.curve));
    for (const auto& one : channel.family)
      estimate.curves.push_back(curve_of(channel, member_of(one.measure), one.points));
  }
  add_unless_empty(estimate.tables, family_table(channels));
}

}  // namespace tumble::allan_noise
