#include "tumble/methods/allan_noise/disturbed.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/math/median.hpp"

namespace tumble::allan_noise {
namespace {

constexpr std::size_t fewest_blocks_of_parts = 10;  ///< so that most_share of them is one

constexpr double unusual = 4.0, raised = 1.5, most_share = 0.1;

/// Standard deviation of a block about its least-squares line; 0 of less than 3 samples.
double scatter_about_line(std::span<const double> values) {
  const double middle = 0.5 * static_cast<double>(values.size() - 1);
  double n = 0.0, t = 0.0, tt = 0.0, origin = 0.0, x = 0.0, tx = 0.0, xx = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    if (n == 0.0) origin = values[i];
    const double time = static_cast<double>(i) - middle, value = values[i] - origin;
    n += 1.0;
    t += time;
    tt += time * time;
    x += value;
    tx += time * value;
    xx += value * value;
  }
  if (n < 3.0) return 0.0;
  const double spread = tt - t * t / n, slope = (tx - t * x / n) / spread;
  return std::sqrt(std::max(0.0, xx - x * x / n - slope * slope * spread) / n);
}

double usual(const std::vector<double>& scatter) {
  std::vector<double> positive;
  for (const double sd : scatter)
    if (sd > 0.0) positive.push_back(sd);
  return positive.empty() ? 0.0 : median(positive);
}

/// Which blocks are disturbed.
std::vector<bool> flagged(const std::vector<double>& scatter, const std::vector<double>& about_line) {
  const double most = unusual * usual(scatter), most_about = unusual * usual(about_line),
               near = raised * usual(about_line);
  const std::size_t blocks = scatter.size();
  std::vector<bool> flags(blocks, false);
  for (std::size_t i = 0; i < blocks; ++i) {
    if (!(scatter[i] > most && about_line[i] > most_about)) continue;
    std::size_t first = i, last = i;
    while (first > 0 && about_line[first - 1] > near) --first;
    while (last + 1 < blocks && about_line[last + 1] > near) ++last;
    for (std::size_t j = first - std::min<std::size_t>(first, 1); j <= std::min(last + 1, blocks - 1); ++j)
      flags[j] = true;
  }
  return flags;
}

double seconds(const RecordPart& part, double rate) { return static_cast<double>(part.end - part.begin) / rate; }

}  // namespace

std::vector<RecordPart> disturbed_parts(const EvenSignal& signal, const BlockScatter& measured) {
  const std::size_t samples = signal.values.size(), size = measured.size, blocks = measured.blocks.size();
  if (blocks < fewest_blocks_of_parts) return {};
  const auto block = [&](std::size_t i) { return signal.values.subspan(i * size, size); };
  std::vector<double> scatter, about_line;
  for (const Scatter& one : measured.blocks) scatter.push_back(one.sd);
  const double most = unusual * usual(scatter);
  if (std::none_of(scatter.begin(), scatter.end(), [&](double one) { return one > most; })) return {};
  for (std::size_t i = 0; i < blocks; ++i) about_line.push_back(scatter_about_line(block(i)));
  const auto flags = flagged(scatter, about_line);
  std::vector<RecordPart> parts;
  double all = 0.0;
  for (std::size_t i = 0; i < blocks; ++i) {
    if (!flags[i]) continue;
    const std::size_t end = i + 1 == blocks ? samples : (i + 1) * size;
    if (parts.empty() || parts.back().end != i * size) parts.push_back({i * size, i * size});
    all += static_cast<double>(end - parts.back().end);
    parts.back().end = end;
  }
  if (all > most_share * static_cast<double>(samples)) return {};
  return parts;
}

void set_missing(const std::vector<RecordPart>& parts, EvenSignal& signal) {
  if (parts.empty()) return;
  if (signal.made.empty()) signal.made.assign(signal.values.begin(), signal.values.end());
  for (const auto& part : parts)
    for (std::size_t i = part.begin; i < std::min(part.end, signal.made.size()); ++i) signal.made[i] = std::nan("");
  signal.values = signal.made;
  signal.extremes = extremes_of(signal.values);
}

void set_disturbed_aside(const Settings& settings, EvenSignal& signal, ChannelNoise& result) {
  const BlockScatter scatter = block_scatter(signal.values);
  if (settings.word("disturbed") == "cut") result.set_aside = disturbed_parts(signal, scatter);
  if (result.set_aside.empty()) {
    const Findings disturbed = disturbances(scatter.blocks, scatter.size, signal.rate, signal.begin, result.label);
    result.findings.insert(result.findings.end(), disturbed.begin(), disturbed.end());
    return;
  }
  double all = 0.0;
  for (const auto& part : result.set_aside) all += seconds(part, signal.rate);
  const double first = signal.begin + static_cast<double>(result.set_aside[0].begin) / signal.rate;
  result.findings.push_back({Finding::Severity::warning,
                             "parts_set_aside",
                             {{"length", all, "s"},
                              {"from", first, "s"},
                              {"to", first + seconds(result.set_aside[0], signal.rate), "s"},
                              {"limit", unusual}},
                             result.label,
                             {result.set_aside.size(), first, {}}});
  set_missing(result.set_aside, signal);
}

void describe_set_aside(const std::vector<ChannelNoise>& channels, Estimate& estimate) {
  struct Row {
    std::string channel;
    double from, length;  ///< [s]
  };
  std::vector<Row> rows;
  for (const auto& channel : channels)
    for (const auto& part : channel.set_aside)
      rows.push_back(
          {channel.label, channel.begin + static_cast<double>(part.begin) / channel.rate, seconds(part, channel.rate)});
  add_unless_empty(estimate.tables,
                   tabulate("set_aside", "parts of the record that are not noise and were excluded", rows,
                            {{"channel", &Row::channel},
                             {"from", "s", &Row::from},
                             {"to", "s", [](const Row& r) { return r.from + r.length; }},
                             {"length", "s", &Row::length}}));
}

}  // namespace tumble::allan_noise
