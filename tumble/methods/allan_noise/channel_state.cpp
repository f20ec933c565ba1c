#include <algorithm>

#include "tumble/methods/allan_noise/fit.hpp"
#include "tumble/methods/allan_noise/input.hpp"
#include "tumble/methods/allan_noise/lines.hpp"
#include "tumble/methods/allan_noise/stream.hpp"
#include "tumble/units/error.hpp"

namespace tumble::allan_noise {
namespace {

constexpr std::size_t longest_factor = std::size_t{1} << 45;  // stages beyond the record's length hold nothing

/// Adds the clock of the part that follows: the rate is that of both together.
void add(const Clocked& next, std::size_t samples, Clocked& clock) {
  if (clock.gaps == 0) clock.first_gap = next.first_gap;
  clock.gaps += next.gaps;
  clock.lost += next.lost;
  clock.end = next.end;
  if (clock.rate != next.rate && clock.end > clock.begin)
    clock.rate = (static_cast<double>(samples) - 1.0) / (clock.end - clock.begin);
}

}  // namespace

ChannelState::ChannelState(const ChannelRun& stretch, const Settings& settings)
    : label(stretch.label),
      kind(kind_of_rate(*stretch.channel, settings)),
      allan(longest_factor, settings.number("points_per_decade")) {}

ChannelState::ChannelState(const ChannelRun& stretch, const Settings& settings, std::size_t first, std::size_t all)
    : label(stretch.label),
      kind(kind_of_rate(*stretch.channel, settings)),
      start(first),
      total(all),
      allan(longest_factor, settings.number("points_per_decade"), first),
      bands(first, all),
      scatter(first, all),
      segments(first, all) {}

void ChannelState::push_to_bands(std::span<const double> values) {
  bands.push(values);
  extremes.add(extremes_of(values));
  samples += values.size();
  scatter.push(values);
  segments.push(values);
  search.push(values);
}

void ChannelState::close() {
  outliers = search.events();
  for (Outlier& one : outliers) {
    one.begin += start;
    one.end += start;
    one.worst += start;
  }
}

void ChannelState::append(const ChannelState& next) {
  if (!failure.empty()) return;
  failure = next.failure;
  if (!failure.empty()) return;
  allan.append(next.allan);
  bands.append(next.bands);
  scatter.append(next.scatter);
  segments.append(next.segments);
  outliers.insert(outliers.end(), next.outliers.begin(), next.outliers.end());
  extremes.add(next.extremes);
  samples += next.samples;
  add(next.clock, samples, clock);
}

ChannelNoise ChannelState::noise(const Settings& settings) const {
  ChannelNoise result;
  result.label = label;
  result.kind = kind;
  result.confidence = settings.number("confidence");
  result.findings = findings_of(clock, label);
  result.rate = clock.rate;
  result.samples = samples;
  result.failure = failure.empty() ? unusable(extremes, samples, result.rate) : Sentence(failure.c_str());
  if (!result.failure.empty()) return result;
  try {
    const Findings disturbed = disturbances(scatter.blocks(), scatter.size(), result.rate, clock.begin, label);
    result.findings.insert(result.findings.end(), disturbed.begin(), disturbed.end());
    result.begin = clock.begin;
    result.outliers = outliers;
    const double longest = std::max(1.0, settings.number("longest_fraction") * static_cast<double>(samples));
    result.curve = allan.points(result.rate, result.confidence);
    std::erase_if(result.curve, [&](const DeviationPoint& one) { return static_cast<double>(one.factor) > longest; });
    fit_likelihood(
        bands.bands(), [&] { return spectral_lines(segments.values()); }, clock.begin, settings, result);
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_data) throw;
    result.failure = reason_of(error);
  }
  return result;
}

std::vector<std::pair<ChannelRun, std::size_t>> channels_of_block(const Recording& block, const Plan& plan) {
  Evidence evidence;
  evidence.plan = plan;
  evidence.recordings.push_back(block);
  const Recording& recording = evidence.recordings.front();
  evidence.recordings.front().marks.clear();
  std::vector<std::pair<ChannelRun, std::size_t>> channels;
  for (auto stretch : channel_runs(evidence, channels_of_data(plan.settings))) {
    const auto number = static_cast<std::size_t>(stretch.channel - recording.channels.data());
    stretch.channel = &block.channels[number];
    channels.emplace_back(stretch, number);
  }
  return channels;
}

}  // namespace tumble::allan_noise
