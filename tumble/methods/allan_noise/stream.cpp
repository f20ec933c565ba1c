#include "tumble/methods/allan_noise/stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/say.hpp"
#include "tumble/math/median.hpp"
#include "tumble/math/noise/streaming_bands.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/math/stability/streaming_allan.hpp"
#include "tumble/methods/allan_noise/fit.hpp"
#include "tumble/methods/allan_noise/input.hpp"
#include "tumble/methods/allan_noise/lines.hpp"
#include "tumble/methods/allan_noise/outliers.hpp"
#include "tumble/units/error.hpp"

namespace tumble::allan_noise {
namespace {

constexpr std::size_t most_blocks = 800, segment = 4096, most_kept = 512;
constexpr std::size_t longest_factor = std::size_t{1} << 45;  // stages beyond the record's length hold nothing

/// Both together.
Scatter joined(const Scatter& a, const Scatter& b) {
  if (a.count == 0.0) return {b.count, b.mean, b.sd, a.first};
  if (b.count == 0.0) return a;
  const double count = a.count + b.count, step = b.mean - a.mean;
  const double squares = a.count * a.sd * a.sd + b.count * b.sd * b.sd + step * step * a.count * b.count / count;
  return {count, a.mean + step * b.count / count, std::sqrt(squares / count), a.first};
}

/// State of one channel.
struct StreamedChannel {
  StreamedChannel(const ChannelRun& stretch, std::size_t number, const Settings& settings)
      : index(number),
        clock(stretch.label, settings.has("rate") ? settings.number("rate") : 0.0, settings.word("timing")),
        allan(longest_factor, settings.number("points_per_decade")) {
    result.label = stretch.label;
    result.kind = kind_of_rate(*stretch.channel, settings);
    result.confidence = settings.number("confidence");
  }

  std::size_t index;  ///< among the channels of a block
  EvenStream clock;
  std::vector<double> next, now;  ///< read, and being worked through
  StreamingAllan allan;
  StreamingNoiseBands bands;
  ScatterBlocks scatter;
  SegmentSample segments;
  OutlierSearch outliers;
  Extremes extremes;
  std::size_t samples = 0;
  ChannelNoise result;
};

void take(const Recording& block, StreamedChannel& channel) {
  channel.next.clear();
  if (!channel.result.failure.empty()) return;
  try {
    channel.clock.take(block.channels[channel.index], channel.next);
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_data) throw;
    channel.result.failure = error.what();
    channel.next.clear();
  }
}

/// The two halves take about the same time.
void work_through(StreamedChannel& channel, bool first_half) {
  if (first_half) return channel.allan.push(channel.now);
  channel.bands.push(channel.now);
  channel.extremes.add(extremes_of(channel.now));
  channel.samples += channel.now.size();
  channel.scatter.push(channel.now);
  channel.segments.push(channel.now);
  channel.outliers.push(channel.now);
}

void finish(StreamedChannel& channel, const Settings& settings) {
  ChannelNoise& result = channel.result;
  result.findings = channel.clock.findings();
  result.rate = channel.clock.rate();
  result.samples = channel.samples;
  if (result.failure.empty()) result.failure = unusable(channel.extremes, channel.samples, result.rate);
  if (!result.failure.empty()) return;
  try {
    const double begin = channel.clock.begin();
    const Findings disturbed =
        disturbances(channel.scatter.blocks(), channel.scatter.size(), result.rate, begin, result.label);
    result.findings.insert(result.findings.end(), disturbed.begin(), disturbed.end());
    result.begin = begin;
    result.outliers = channel.outliers.events();
    const double longest = std::max(1.0, settings.number("longest_fraction") * static_cast<double>(result.samples));
    result.curve = channel.allan.points(result.rate, result.confidence);
    std::erase_if(result.curve, [&](const DeviationPoint& one) { return static_cast<double>(one.factor) > longest; });
    fit_likelihood(
        channel.bands.bands(), [&] { return spectral_lines(channel.segments.values()); }, begin, settings, result);
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_data) throw;
    result.failure = error.what();
  }
}

std::vector<StreamedChannel> opened(const Recording& block, const Plan& plan) {
  Evidence evidence;
  evidence.plan = plan;
  evidence.recordings.push_back(block);
  const Recording& recording = evidence.recordings.front();
  evidence.recordings.front().marks.clear();
  std::vector<StreamedChannel> channels;
  for (const auto& stretch : channel_runs(evidence, channels_of_data(plan.settings))) {
    const auto number = static_cast<std::size_t>(stretch.channel - recording.channels.data());
    channels.emplace_back(stretch, number, plan.settings);
  }
  return channels;
}

/// Options that look at the record as a whole.
void refuse_unstreamable(const Settings& settings) {
  std::vector<std::string> problems;
  const auto refuse = [&](bool asked, const char* what) {
    if (asked)
      problems.push_back(
          fmt::format("{} needs all samples in memory, which this recording is too large for: leave it out, or raise "
                      "--memory-limit",
                      what));
  };
  refuse(settings.word("estimator") != "likelihood", "estimator = allan");
  refuse(settings.word("timing") == "stamps", "timing = stamps");
  refuse(settings.word("taus") != "log", "taus");
  refuse(settings.word("data") != "rate" && settings.word("data") != "frequency", "data other than rate and frequency");
  refuse(settings.has("deviations"), "deviations");
  refuse(settings.word("spectrum") != "none", "spectrum");
  refuse(settings.integer("windows") != 0, "windows");
  refuse(settings.flag("correlation"), "correlation");
  refuse(settings.flag("hat"), "hat");
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

}  // namespace

void ScatterBlocks::push(std::span<const double> values) {
  while (!values.empty()) {
    if (blocks_.empty() || filled_ == size_) {
      if (blocks_.size() == most_blocks) {
        for (std::size_t i = 0; i < most_blocks / 2; ++i) blocks_[i] = joined(blocks_[2 * i], blocks_[2 * i + 1]);
        blocks_.resize(most_blocks / 2);
        size_ *= 2;
      }
      blocks_.push_back({0.0, 0.0, 0.0, samples_});
      filled_ = 0;
    }
    const auto some = values.first(std::min(values.size(), size_ - filled_));
    blocks_.back() = joined(blocks_.back(), scatter_of(some, samples_));
    filled_ += some.size();
    samples_ += some.size();
    values = values.subspan(some.size());
  }
}

std::vector<Scatter> ScatterBlocks::blocks() const {
  auto full = blocks_;
  if (filled_ < size_ && !full.empty()) full.pop_back();
  return full;
}

void SegmentSample::push(std::span<const double> values) {
  while (!values.empty()) {
    const std::size_t into = position_ % segment;
    if (into == 0 && position_ / segment % stride_ == 0 && kept_.size() == most_kept * segment) {
      for (std::size_t i = 1; i < most_kept / 2; ++i)
        std::copy_n(kept_.begin() + static_cast<std::ptrdiff_t>(2 * i * segment), segment,
                    kept_.begin() + static_cast<std::ptrdiff_t>(i * segment));
      kept_.resize(most_kept / 2 * segment);
      stride_ *= 2;
    }
    const auto some = values.first(std::min(values.size(), segment - into));
    if (position_ / segment % stride_ == 0) kept_.insert(kept_.end(), some.begin(), some.end());
    position_ += some.size();
    values = values.subspan(some.size());
  }
}

std::span<const double> SegmentSample::values() const {
  return std::span(kept_).first(stride_ == 1 ? kept_.size() : kept_.size() / segment * segment);
}

EvenStream::EvenStream(std::string label, double rate, std::string timing)
    : label_(std::move(label)), timing_(std::move(timing)), given_(rate) {}

void EvenStream::take(const Channel& block, std::vector<double>& values) {
  if (block.values.empty()) return;
  finite_extremes(block, 0, block.values.size(), label_);
  if (samples_ == 0) first_ = last_ = block.time(0);
  if (block.timeline.uniform()) uniform_ = block.timeline.rate;
  if (block.timeline.uniform() || given_ > 0.0)
    values.insert(values.end(), block.values.begin(), block.values.end());
  else
    by_stamps(block, values);
  samples_ += block.values.size();
  last_ = block.time(block.values.size() - 1);
}

/// A step may depart by a quarter from a whole number of intervals.
void EvenStream::by_stamps(const Channel& block, std::vector<double>& values) {
  constexpr double most_lost = 1e8;
  const auto& stamps = *block.timeline.stamps;
  if (interval_ == 0.0) {
    std::vector<double> steps;
    for (std::size_t i = 1; i < stamps.size(); ++i) steps.push_back(stamps[i] - stamps[i - 1]);
    interval_ = steps.empty() ? 0.0 : median(steps);
  }
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    const bool very_first = i == 0 && samples_ == 0;
    const double before = i == 0 ? last_ : stamps[i - 1], step = stamps[i] - before;
    if (step < 0.0)
      throw Error(
          Error::Kind::bad_data,
          fmt::format("{}: the clock runs backwards at {}: mend the stamps, or say rate=... to take the samples "
                      "as evenly spaced",
                      label_, say_instant(before)));
    const double count = std::round(step / interval_);
    if (timing_ == "auto" && !very_first) {
      if (!(count >= 1.0 && count < most_lost && std::abs(step - count * interval_) <= 0.25 * interval_))
        throw Error(
            Error::Kind::bad_data,
            fmt::format("{}: the stamps do not keep to {} at {}, and a recording too large for memory cannot be "
                        "sorted by them: say timing=even or rate=... to take the samples as evenly spaced",
                        label_, say_seconds(interval_), say_instant(stamps[i])));
      if (count > 1.0) {
        if (gaps_++ == 0) first_gap_ = before;
        lost_ += static_cast<std::size_t>(count) - 1;
        values.insert(values.end(), static_cast<std::size_t>(count) - 1, std::nan(""));
      }
    }
    values.push_back(block.values[i]);
  }
}

double EvenStream::rate() const {
  if (given_ > 0.0) return given_;
  if (uniform_ > 0.0) return uniform_;
  const auto intervals = static_cast<double>(samples_ + lost_) - 1.0;
  return last_ > first_ ? intervals / (last_ - first_) : 0.0;
}

Findings EvenStream::findings() const {
  using Severity = Finding::Severity;
  Findings findings;
  const double stamped = last_ > first_ ? (static_cast<double>(samples_) - 1.0) / (last_ - first_) : 0.0;
  if (given_ > 0.0 && stamped > 0.0 && std::abs(given_ / stamped - 1.0) > 0.01)
    findings.push_back(
        {Severity::warning, "rate_differs_from_file", {{"rate", given_, "Hz"}, {"stamped", stamped, "Hz"}}, label_});
  if (gaps_ > 0)
    findings.push_back({Severity::info, "gaps_kept_as_missing", {{"lost", lost_}}, label_, {gaps_, first_gap_, {}}});
  return findings;
}

std::vector<ChannelNoise> noise_of_stream(const StreamedEvidence& evidence) {
  const Settings& settings = evidence.plan.settings;
  refuse_unstreamable(settings);
  std::vector<StreamedChannel> channels;
  std::future<void> working;
  evidence.play([&](const Recording& block) {
    if (channels.empty()) channels = opened(block, evidence.plan);
    for (auto& channel : channels) take(block, channel);
    if (working.valid()) working.get();
    for (auto& channel : channels) std::swap(channel.now, channel.next);
    working = in_background(
        [&] { parallel_for(2 * channels.size(), [&](std::size_t i) { work_through(channels[i / 2], i % 2 == 0); }); });
  });
  if (working.valid()) working.get();
  parallel_for(channels.size(), [&](std::size_t i) { finish(channels[i], settings); });
  std::vector<ChannelNoise> results;
  results.reserve(channels.size());
  for (auto& channel : channels) results.push_back(std::move(channel.result));
  return results;
}

}  // namespace tumble::allan_noise
