#include "tumble/methods/imu_ferraris/sections.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "tumble/core/marks.hpp"
#include "tumble/language/say.hpp"
#include "tumble/math/median.hpp"
#include "tumble/reduce/imu/sensors.hpp"
#include "tumble/reduce/stretches.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::imu_ferraris {

const std::array<std::string, sections>& labels() {
  static const std::array<std::string, sections> all{"x_p", "x_a",   "y_p",   "y_a",  "z_p",
                                                     "z_a", "x_rot", "y_rot", "z_rot"};
  return all;
}

namespace {

constexpr std::size_t fewest_of_block_mean = 8;  ///< samples in each block, where there are enough

constexpr std::size_t fewest_samples = 16;
constexpr double median_of_steps = 0.9539;  ///< [1] sd of white noise: median size of the step from sample to sample
/// [1] sd of the noise: chosen, noise whose tails are twice those of a normal one does not reach it twice in succession.
constexpr double far_from_middle = 6.0;
constexpr std::size_t fewest_far = 2;  ///< samples: a single one is an outlier
constexpr std::size_t most_blocks = 16;

std::string role_of(std::size_t output) {
  return imu::role_of(output < 3 ? imu::Kind::accelerometer : imu::Kind::gyro, output % 3);
}

/// "x_p=face 1, x_a=face 2": the user's labels to ours.
std::map<std::string, std::string> renamed(const std::string& text) {
  std::map<std::string, std::string> names;
  const std::vector<std::string> known(labels().begin(), labels().end());
  auto pairs = list_items(text);
  if (pairs.back().empty()) pairs.pop_back();
  for (const std::string& pair : pairs) {
    const auto labels_of_section = key_and_value(pair);
    const std::string ours(trimmed(labels_of_section ? labels_of_section->first : pair));
    if (!labels_of_section || std::ranges::find(known, ours) == known.end())
      throw Error(Error::Kind::bad_input,
                  say("labels = \"{}\": \"{}\" is no pair as in \"x_p=face 1, x_a=face 2\"{}; sections are {}", text,
                      pair, did_you_mean(ours, known), fmt::join(known, ", ")));
    names[std::string(trimmed(labels_of_section->second))] = ours;
  }
  return names;
}

/// Index of the section, or `sections`. "acc_" and "gyr_" may stand before it.
std::size_t section_of(std::string label, const std::map<std::string, std::string>& names) {
  if (const auto given = names.find(label); given != names.end()) label = given->second;
  for (const char* prefix : {"acc_", "gyr_"})
    if (label.starts_with(prefix)) label.erase(0, 4);
  return static_cast<std::size_t>(std::ranges::find(labels(), label) - labels().begin());
}

/// When a part ends [s] that no mark ends: with its last sample.
double end_of_samples(const Channel& channel, std::size_t begin, std::size_t end) {
  if (end - begin < 2) return end > begin ? channel.time(begin) : 0.0;
  const auto intervals = static_cast<double>(end - begin - 1);
  return channel.time(end - 1) + (channel.time(end - 1) - channel.time(begin)) / intervals;
}

/// Variance of block means times their length: that of a mean of n samples is this over n where blocks are longer than
/// the noise remembers.
void add_density(const Channel& channel, std::size_t begin, std::size_t end, std::size_t output, Section& section) {
  const std::size_t n = end - begin, blocks = std::clamp<std::size_t>(n / fewest_of_block_mean, 2, most_blocks),
                    length = n / blocks;
  std::vector<double> means;
  for (std::size_t b = 0; b < blocks; ++b) {
    double sum = 0.0, count = 0.0;
    for (std::size_t i = begin + b * length; i < begin + (b + 1) * length; ++i)
      if (const double v = channel.values[i]; !std::isnan(v)) sum += v, count += 1.0;
    if (count > 0.0) means.push_back(sum / count);
  }
  if (means.size() < 2) return;
  double mean = 0.0, squares = 0.0;
  for (const double v : means) mean += v / static_cast<double>(means.size());
  for (const double v : means) squares += (v - mean) * (v - mean);
  const double freedom = static_cast<double>(means.size()) - 1.0;
  double& density = section.density[output];
  double& before = section.freedom[output];
  density = (before * density + squares * static_cast<double>(length)) / (before + freedom);
  before += freedom;
}

void add_halves(const Channel& channel, std::size_t begin, std::size_t end, std::size_t part, Halves& halves) {
  std::array<double, 2> sum{}, count{};
  for (std::size_t i = begin; i < end; ++i) {
    const std::size_t half = i - begin < (end - begin) / 2 ? 0 : 1;
    if (std::isnan(channel.values[i])) continue;
    sum[half] += channel.values[i];
    ++count[half];
  }
  if (count[0] == 0.0 || count[1] == 0.0) return;
  const HalfStep step{part, sum[1] / count[1] - sum[0] / count[0], 1.0 / count[0] + 1.0 / count[1]};
  halves.squares += step.difference * step.difference;
  halves.noise += step.noise;
  ++halves.count;
  halves.steps.push_back(step);
}

/// Samples at both ends that are far from those in the middle, by the scatter from sample to sample, which a motion in a part
/// of the section does not change.
Edges edges_in(const Channel& channel, std::size_t begin, std::size_t end) {
  std::vector<double> values, steps;
  for (std::size_t i = begin; i < end; ++i)
    if (!std::isnan(channel.values[i])) values.push_back(channel.values[i]);
  for (std::size_t i = 1; i < values.size(); ++i) steps.push_back(std::abs(values[i] - values[i - 1]));
  if (values.size() < fewest_samples) return {};
  const double middle = median(values), scatter = median(steps) / median_of_steps;
  if (!(scatter > 0.0)) return {};  // steps of the converter hide it
  const auto is_far = [&](double value) { return std::abs(value - middle) > far_from_middle * scatter; };
  const auto leading = static_cast<std::size_t>(std::ranges::find_if_not(values, is_far) - values.begin());
  std::ranges::reverse(values);
  const auto trailing = static_cast<std::size_t>(std::ranges::find_if_not(values, is_far) - values.begin());
  const double step = (channel.time(end - 1) - channel.time(begin)) / static_cast<double>(end - begin - 1);
  const auto length = [&](std::size_t count) { return count < fewest_far ? 0.0 : static_cast<double>(count) * step; };
  return {length(leading), length(trailing)};
}

/// What lies between two marks of a section, in one recording.
struct Stretch {
  double from, to;         ///< [s]
  std::size_t begin, end;  ///< samples
};

void add_turned(const Channel& channel, const Stretch& stretch, std::size_t output, Section& section) {
  const Turned turned = turned_in(channel, stretch.begin, stretch.end, stretch.from, stretch.to);
  section.total[output] += turned.total;
  section.bridged[output] += turned.variance;
  section.longest_bridge = std::max(section.longest_bridge, turned.bridged);
  section.ends[output] = ends_of(channel, stretch.begin, stretch.end);
}

void add_output(const Channel& channel, const Stretch& stretch, std::size_t output, Section& section) {
  const auto [from, to, begin, end] = stretch;
  double sum = 0.0;
  std::size_t valid = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const double v = channel.values[i];
    if (std::isnan(v)) continue;
    sum += v;
    section.least[output] = std::min(section.least[output], v);
    section.greatest[output] = std::max(section.greatest[output], v);
    ++valid;
  }
  section.missing += end - begin - valid;
  section.missing_of[output] += end - begin - valid;
  if (valid == 0) return;
  const auto before = static_cast<double>(section.samples), now = static_cast<double>(end - begin);
  section.mean[output] =
      (before * section.mean[output] + now * (sum / static_cast<double>(valid))) / std::max(before + now, 1.0);
  add_turned(channel, stretch, output, section);
  const Edges edges = edges_in(channel, begin, end);
  section.edges.first = std::max(section.edges.first, edges.first);
  section.edges.last = std::max(section.edges.last, edges.last);
  if (end - begin < fewest_samples) return;
  add_density(channel, begin, end, output, section);
  add_halves(channel, begin, end, section.pieces.size(), section.halves[output]);
}

struct Reader {
  const Evidence& evidence;
  Recorded out;
  Problems problems;
  std::set<std::string> others;  ///< labels that are no section

  void take_unit(const Channel& channel, std::size_t output) {
    if (out.channel[output].empty()) {
      out.unit[output] = channel.unit;
      out.kind[output] = channel.kind;
      out.channel[output] = channel.name;
    } else if (out.unit[output].dimension() != channel.unit.dimension()) {
      problems.push_back(say("{} is in {} in one recording and in {} in another", Name{role_of(output)},
                             Name{out.unit[output].text()}, Name{channel.unit.text()}));
    }
  }

  void take(std::size_t number, const std::map<std::string, std::string>& names) {
    const Recording& recording = evidence.recordings[number];
    std::array<const Channel*, outputs> channels{};
    std::size_t gyros = 0;
    for (std::size_t k = 0; k < outputs; ++k) {
      channels[k] =
          k < 3 ? &require_channel(evidence, recording, role_of(k)) : channel_for(evidence, recording, role_of(k));
      if (channels[k]) take_unit(*channels[k], k);
      gyros += k >= 3 && channels[k];
    }
    if (gyros == 1 || gyros == 2)
      problems.push_back(say("{} has {} of the three gyros: name all or none", Name{recording.origin.file}, gyros));
    for (std::size_t m = 0; m < recording.marks.size(); ++m) {
      const std::size_t s = section_of(recording.marks[m].label, names);
      if (s == sections) {
        if (!recording.marks[m].label.empty()) others.insert(recording.marks[m].label);
        continue;
      }
      take_section(channels, number, recording.marks[m].begin, end_of_mark(recording, m), out.section[s]);
    }
  }

  static void take_section(const std::array<const Channel*, outputs>& channels, std::size_t recording, double from,
                           double to, Section& section) {
    std::size_t samples = 0;
    double length = 0.0;
    for (std::size_t k = 0; k < outputs; ++k) {
      if (!channels[k]) continue;
      const auto [begin, end] = samples_between(*channels[k], from, to);
      add_output(*channels[k], {from, to, begin, end}, k, section);
      if (k > 0) continue;
      samples = end - begin;
      length = (std::isfinite(to) ? to : end_of_samples(*channels[k], begin, end)) - from;
    }
    section.samples += samples;
    section.time += length;
    section.pieces.push_back({recording, from, length});
    ++section.parts;
  }

  void check_units() {
    for (std::size_t k = 0; k < outputs; ++k)
      if (!out.channel[k].empty() && out.unit[k].dimension() != out.unit[k / 3 * 3].dimension())
        problems.push_back(say("{} is in {}, but {} in {}: the three of a triad must be in one unit", Name{role_of(k)},
                               Name{out.unit[k].text()}, Name{role_of(k / 3 * 3)}, Name{out.unit[k / 3 * 3].text()}));
  }

  void check_alive() {
    if (std::ranges::none_of(out.section, [](const auto& section) { return section.parts > 0; })) return;  // none found
    for (std::size_t k = 0; k < outputs; ++k) {
      bool alive = out.channel[k].empty();
      for (const auto& section : out.section)
        alive = alive || (section.parts > 0 && (section.density[k] > 0.0 || section.mean[k] != out.section[0].mean[k]));
      if (!alive) problems.push_back(say("channel '{}' holds the same value throughout", out.channel[k]));
    }
  }

  void check() {
    check_units();
    check_alive();
    std::vector<std::string> missing_poses, missing_turns;
    for (std::size_t s = 0; s < sections; ++s)
      if (out.section[s].parts == 0) (s < poses ? missing_poses : missing_turns).push_back(labels()[s]);
    out.gyros = !out.channel[3].empty() && missing_turns.size() < turns;
    if (!missing_poses.empty() || (out.gyros && !missing_turns.empty())) {
      auto missing = missing_poses;
      if (out.gyros) missing.insert(missing.end(), missing_turns.begin(), missing_turns.end());
      const Sentence have = others.empty() ? Sentence() : say("; other labels are {}", fmt::join(others, ", "));
      const bool none = missing_poses.size() == poses && others.empty();
      problems.push_back(
          say("no section {}{}{}", fmt::join(missing, ", "), have,
              none ? Sentence(": the recording has no labels; --set segment_column=COLUMN makes marks of a column that "
                              "holds them")
                   : say("; record it, or say which label it has: labels = \"{}=...\"", Name{missing.front()})));
    }
    if (!out.channel[3].empty() && !out.gyros)
      out.findings.push_back({Finding::Severity::warning, "no_known_turns", {}});
    for (std::size_t s = 0; s < sections; ++s) check_samples(s);
    if (out.gyros) about_bridges();
    about_edges();
  }

  void about_bridges() {
    for (std::size_t s = poses; s < sections; ++s)
      if (const Section& turn = out.section[s]; turn.longest_bridge > 0.0) {
        double most = 0.0;
        for (std::size_t k = 3; k < outputs; ++k)
          most = std::max(most, std::sqrt(turn.bridged[k]) / std::abs(out.section[s].total[s - poses + 3]));
        out.findings.push_back({Finding::Severity::info,
                                "turn_bridged",
                                {{"length", turn.longest_bridge, "s"}, {"share", most, "%"}},
                                labels()[s]});
      }
  }

  /// Most poses begin or end with samples of what is beside them: the marks, or the stamps, are late or early.
  void about_edges() {
    std::vector<double> first, last;
    std::string one_of_first, one_of_last;
    const auto take_edge = [](double length, const std::string& label, std::vector<double>& all, std::string& one) {
      if (!(length > 0.0)) return;
      all.push_back(length);
      if (one.empty()) one = label;
    };
    for (std::size_t p = 0; p < poses; ++p) {
      take_edge(out.section[p].edges.first, labels()[p], first, one_of_first);
      take_edge(out.section[p].edges.last, labels()[p], last, one_of_last);
    }
    const auto say_so = [&](const std::vector<double>& all, const char* code, const std::string& one) {
      if (2 * all.size() >= poses)
        out.findings.push_back({Finding::Severity::warning, code, {{"first", one}, {"shift", median(all), "s"}}});
    };
    say_so(first, "segments_begin_in_last", one_of_first);
    say_so(last, "segments_end_in_next", one_of_last);
  }

  void check_samples(std::size_t s) {
    const Section& section = out.section[s];
    if (section.parts == 0 || (s >= poses && !out.gyros)) return;
    if (section.samples < fewest_samples)
      problems.push_back(say("section {} has {}: at least {} are needed", Name{labels()[s]},
                             said_count(section.samples, "sample"), fewest_samples));
    else if (2 * std::ranges::max(section.missing_of) > section.samples)
      problems.push_back(say("more than half of the samples of section {} are missing", Name{labels()[s]}));
    else if (section.missing > 0)
      out.findings.push_back({s < poses ? Finding::Severity::info : Finding::Severity::warning,
                              "section_lacks_samples",
                              {{"missing", section.missing}},
                              labels()[s]});
    for (std::size_t k = 0; k < (out.gyros ? outputs : 3) && section.samples >= fewest_samples; ++k)
      if (section.freedom[k] <= 0.0)
        problems.push_back(say("{} has no samples in section {}", Name{role_of(k)}, Name{labels()[s]}));
  }
};

}  // namespace

Recorded recorded(const Evidence& evidence) {
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "there is no recording to identify from");
  const auto& settings = evidence.plan.settings;
  const auto names = renamed(settings.has("labels") ? settings.word("labels") : "");
  Reader reader{evidence, {}, {}, {}};
  for (std::size_t r = 0; r < evidence.recordings.size(); ++r) reader.take(r, names);
  reader.check();
  if (!reader.problems.empty()) throw Error(Error::Kind::bad_data, reader.problems);
  return reader.out;
}

}  // namespace tumble::imu_ferraris
