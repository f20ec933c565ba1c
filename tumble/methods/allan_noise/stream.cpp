#include "tumble/methods/allan_noise/stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/clocks/ticks.hpp"
#include "tumble/language/say.hpp"
#include "tumble/math/median.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/reduce/even_signal.hpp"
#include "tumble/units/error.hpp"

namespace tumble::allan_noise {
namespace {

constexpr double keeps_to_interval = 0.25;  ///< [intervals] that a stamp may be off whole intervals

constexpr std::size_t most_blocks = 800, segment = 4096, most_kept = 512;

/// Both together.
Scatter joined(const Scatter& a, const Scatter& b) {
  if (a.count == 0.0) return {b.count, b.mean, b.sd, a.first};
  if (b.count == 0.0) return a;
  const double count = a.count + b.count, step = b.mean - a.mean;
  const double squares = a.count * a.sd * a.sd + b.count * b.sd * b.sd + step * step * a.count * b.count / count;
  return {count, a.mean + step * b.count / count, std::sqrt(squares / count), a.first};
}

/// One channel of a recording that is handed out in blocks.
struct StreamedChannel {
  std::size_t index;  ///< among the channels of a block
  EvenStream clock;
  std::vector<double> next, now;  ///< read, and being worked through
  ChannelState state;
};

void take(const Recording& block, StreamedChannel& channel) {
  channel.next.clear();
  if (!channel.state.failure.empty()) return;
  try {
    channel.clock.take(block.channels[channel.index], channel.next);
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_data) throw;
    channel.state.failure = error.what();
    channel.next.clear();
  }
}

std::vector<StreamedChannel> opened(const Recording& block, const Plan& plan) {
  std::vector<StreamedChannel> channels;
  for (const auto& [stretch, number] : channels_of_block(block, plan))
    channels.push_back({number, EvenStream(stretch.label, plan.settings), {}, {}, {stretch, plan.settings}});
  return channels;
}

}  // namespace

/// Options that look at the record as a whole.
void refuse_unstreamable(const Settings& settings) {
  Problems problems;
  const auto refuse = [&](bool asked, const Sentence& what) {
    if (asked)
      problems.push_back(
          say("{} needs all samples in memory, which this recording is too large for: leave it out, or raise "
              "--memory-limit",
              what));
  };
  refuse(settings.word("estimator") != "likelihood", say("{}", Name{"estimator = allan"}));
  refuse(settings.word("timing") == "stamps", say("{}", Name{"timing = stamps"}));
  refuse(settings.word("taus") != "log", say("{}", Name{"taus"}));
  refuse(settings.word("data") != "rate" && settings.word("data") != "frequency", "data other than rate and frequency");
  refuse(settings.has("from"), say("{}", Name{"from"}));
  refuse(settings.has("deviations"), say("{}", Name{"deviations"}));
  refuse(settings.word("spectrum") != "none", say("{}", Name{"spectrum"}));
  refuse(settings.integer("windows") != 0, say("{}", Name{"windows"}));
  refuse(settings.flag("correlation"), say("{}", Name{"correlation"}));
  refuse(settings.flag("hat"), say("{}", Name{"hat"}));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

ScatterBlocks::ScatterBlocks(std::size_t start, std::size_t total) : samples_(start) {
  while (size_ * most_blocks < total) size_ *= 2;
  filled_ = start % size_;
}

void ScatterBlocks::push(std::span<const double> values) {
  while (!values.empty()) {
    if (blocks_.empty() || filled_ == size_) {
      if (blocks_.size() == most_blocks) {
        for (std::size_t i = 0; i < most_blocks / 2; ++i) blocks_[i] = joined(blocks_[2 * i], blocks_[2 * i + 1]);
        blocks_.resize(most_blocks / 2);
        size_ *= 2;
      }
      if (filled_ == size_) filled_ = 0;
      blocks_.push_back({0.0, 0.0, 0.0, samples_ - filled_});
    }
    const auto some = values.first(std::min(values.size(), size_ - filled_));
    blocks_.back() = joined(blocks_.back(), scatter_of(some, samples_));
    filled_ += some.size();
    samples_ += some.size();
    values = values.subspan(some.size());
  }
}

void ScatterBlocks::append(const ScatterBlocks& next) {
  if (next.blocks_.empty()) return;
  auto more = next.blocks_.begin();
  if (!blocks_.empty() && filled_ < size_) blocks_.back() = joined(blocks_.back(), *more++);
  blocks_.insert(blocks_.end(), more, next.blocks_.end());
  filled_ = next.filled_;
  samples_ = next.samples_;
}

std::vector<Scatter> ScatterBlocks::blocks() const {
  auto full = blocks_;
  if (filled_ < size_ && !full.empty()) full.pop_back();
  return full;
}

SegmentSample::SegmentSample(std::size_t start, std::size_t total) : position_(start) {
  const std::size_t segments = (total + segment - 1) / segment;
  while ((segments + stride_ - 1) / stride_ > most_kept) stride_ *= 2;
}

void SegmentSample::append(const SegmentSample& next) {
  kept_.insert(kept_.end(), next.kept_.begin(), next.kept_.end());
  position_ = next.position_;
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

EvenStream::EvenStream(std::string label, const Settings& settings)
    : label_(std::move(label)),
      timing_(settings.word("timing")),
      given_(settings.has("rate") ? settings.number("rate") : 0.0) {}

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

/// Samples that are lost before each stamp [s] of a block whose clock is coarse; empty: its clock is not. The stamps
/// before it belong to the search, so that the step to the block is one among others.
std::vector<std::size_t> EvenStream::lost_by_ticks(const std::vector<double>& stamps) {
  constexpr std::size_t longest_tail = 4096;
  std::vector<double> window = tail_;
  window.insert(window.end(), stamps.begin(), stamps.end());
  if (!std::ranges::is_sorted(window)) return {};
  const Ticks ticks = ticked(window, ticked_);
  std::vector<std::size_t> lost;
  if (ticks.stamps) {
    ticked_ = ticks.stamps->interval;
    lost.resize(stamps.size());
    for (const auto& [after, count] : ticks.stamps->gaps)
      if (after + 1 >= tail_.size()) lost[after + 1 - tail_.size()] = count;
  }
  const std::size_t kept = std::min(longest_tail, window.size());
  tail_.assign(window.end() - static_cast<std::ptrdiff_t>(kept), window.end());
  return lost;
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
  const std::vector<std::size_t> lost = timing_ == "auto" ? lost_by_ticks(stamps) : std::vector<std::size_t>{};
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    const bool very_first = i == 0 && samples_ == 0;
    const double before = i == 0 ? last_ : stamps[i - 1], step = stamps[i] - before;
    if (step < 0.0)
      throw Error(Error::Kind::bad_data,
                  say("{}: the clock runs backwards at {}: mend the stamps, or say rate=... to take the samples "
                      "as evenly spaced",
                      Name{label_}, Name{say_instant(before)}));
    const double count = lost.empty() ? std::round(step / interval_) : 1.0 + static_cast<double>(lost[i]);
    if (timing_ == "auto" && !very_first) {
      if (lost.empty() &&
          !(count >= 1.0 && count < most_lost && std::abs(step - count * interval_) <= keeps_to_interval * interval_))
        throw Error(Error::Kind::bad_data,
                    say("{}: the stamps do not keep to {} at {}, and a recording too large for memory cannot be "
                        "sorted by them: say timing=even or rate=... to take the samples as evenly spaced",
                        Name{label_}, Name{say_seconds(interval_)}, Name{say_instant(stamps[i])}));
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

Clocked EvenStream::clocked() const {
  const double stamped = last_ > first_ ? (static_cast<double>(samples_) - 1.0) / (last_ - first_) : 0.0;
  return {rate(), first_, last_, given_, stamped, lost_, gaps_, first_gap_};
}

Findings findings_of(const Clocked& clocked, const std::string& label) {
  using Severity = Finding::Severity;
  Findings findings;
  if (clocked.given > 0.0 && clocked.stamped > 0.0 && std::abs(clocked.given / clocked.stamped - 1.0) > rate_differs)
    findings.push_back({Severity::warning,
                        "rate_differs_from_file",
                        {{"rate", clocked.given, "Hz"}, {"stamped", clocked.stamped, "Hz"}},
                        label});
  if (clocked.gaps > 0)
    findings.push_back({Severity::info,
                        "gaps_kept_as_missing",
                        {{"lost", clocked.lost}},
                        label,
                        {clocked.gaps, clocked.first_gap, {}}});
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
    working = in_background([&] {
      parallel_for(2 * channels.size(), [&](std::size_t i) {
        StreamedChannel& channel = channels[i / 2];
        i % 2 == 0 ? channel.state.push_to_allan(channel.now) : channel.state.push_to_bands(channel.now);
      });
    });
  });
  if (working.valid()) working.get();
  std::vector<ChannelNoise> results(channels.size());
  parallel_for(channels.size(), [&](std::size_t i) {
    channels[i].state.clock = channels[i].clock.clocked();
    channels[i].state.close();
    results[i] = channels[i].state.noise(settings);
  });
  return results;
}

}  // namespace tumble::allan_noise
