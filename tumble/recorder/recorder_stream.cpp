#include "tumble/recorder/recorder_stream.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/recorder/live_store/sample_clock.hpp"

namespace tumble {

namespace {

constexpr std::size_t most_arrivals = 4096;  ///< pieces whose time is known

}  // namespace

void LiveNoise::add(double time, double value) {
  if (std::isnan(value)) return;
  const double step = value - mean_;
  mean_ += step / static_cast<double>(++count_);
  squares_ += step * (value - mean_);
  if (!running_) span_end_ = time + tau_, running_ = true;
  if (time >= span_end_) {
    const double mean = span_sum_ / static_cast<double>(in_span_);
    if (last_holds_) pair_squares_ += (mean - last_mean_) * (mean - last_mean_), ++pairs_;
    last_mean_ = mean;
    last_holds_ = time < span_end_ + tau_;  // else a span without samples lies between
    span_end_ += tau_ * std::floor((time - span_end_) / tau_ + 1.0);
    span_sum_ = 0.0;
    in_span_ = 0;
  }
  span_sum_ += value;
  ++in_span_;
}

double LiveNoise::sd() const {
  return count_ > 1 ? std::sqrt(squares_ / static_cast<double>(count_ - 1)) : std::nan("");
}

double LiveNoise::allan() const {
  return pairs_ > 0 ? std::sqrt(0.5 * pair_squares_ / static_cast<double>(pairs_)) : std::nan("");
}

InstrumentRecorder::InstrumentRecorder(Recorder& recorder, const FrameCodec& codec, StoreLink link, LiveEstimates* live)
    : recorder_(recorder),
      codec_(codec),
      live_(live),
      description_(std::move(link)),
      link_(recorder.add_link(description_)),
      stream_(codec) {
  for (const FrameChannel& channel : codec.channels) shown_.push_back({channel, LiveNoise()});
}

void InstrumentRecorder::sent(double time, std::string_view bytes) {
  recorder_.raw(link_, StoreDirection::sent, time, bytes);
  stream_.begin_again();
}

bool InstrumentRecorder::receive(double time, std::string_view bytes) {
  const Recorder::Whole whole(recorder_);
  if (recorder_.raw(link_, StoreDirection::received, time, bytes) == 0) return false;
  arrivals_.emplace_back(stream_.counts().bytes + bytes.size(), time);
  stream_.feed(bytes, [&](const StreamFrame& frame) { take(frame); });
  if (!stream_.holds() || arrivals_.size() > most_arrivals)
    arrivals_.erase(arrivals_.begin(), arrivals_.end() - static_cast<std::ptrdiff_t>(std::min<std::size_t>(
                                                             arrivals_.size(), stream_.holds() ? most_arrivals : 1)));
  return !recorder_.failure();
}

/// A frame that waited for others is as old as its bytes.
double InstrumentRecorder::arrival_of(const StreamFrame& frame) const {
  const auto piece = std::ranges::lower_bound(arrivals_, frame.complete, {}, &std::pair<std::uint64_t, double>::first);
  return piece == arrivals_.end() ? arrivals_.back().second : piece->second;
}

void InstrumentRecorder::finish() {
  if (arrivals_.empty()) return;
  stream_.flush([&](const StreamFrame& frame) { take(frame); });
}

void InstrumentRecorder::begin_noise() {
  for (Shown& shown : shown_) shown.noise = LiveNoise();
}

void InstrumentRecorder::begin_bar() {
  for (Shown& shown : shown_) shown.low = shown.high = std::nan("");
}

void InstrumentRecorder::restart() {
  finish();
  arrivals_.clear();
  link_ = recorder_.add_link(description_);
  stream_ = FrameStream(codec_);
  streams_.clear();
  running_ = false;
}

/// Channels that come together are a stream; a frame whose channels change by its counter belongs to several.
std::size_t InstrumentRecorder::stream_of(const FrameContent& content) {
  const auto [place, is_new] = streams_.try_emplace(content.present, 0);
  if (!is_new) return place->second;
  StoreStream stream{codec_.title.empty() ? codec_.name : codec_.title, description_.slot, {}, codec_.rate, link_};
  for (std::size_t i = 0; i < content.present.size(); ++i)
    if (content.present[i]) stream.channels.push_back(codec_.channels[i]);
  place->second = recorder_.add_stream(stream);
  if (live_) live_->link(link_, description_), live_->stream(place->second, stream);
  return place->second;
}

void InstrumentRecorder::take(const StreamFrame& frame) {
  const double time = arrival_of(frame);
  const std::size_t stream = stream_of(frame.content);
  values_.clear();
  for (std::size_t i = 0; i < shown_.size(); ++i) {
    if (!frame.content.present[i]) continue;
    const double value = frame.content.values[i];
    values_.push_back(value);
    shown_[i].noise.add(time, value);
    shown_[i].last = value;
    shown_[i].low = std::fmin(shown_[i].low, value);
    shown_[i].high = std::fmax(shown_[i].high, value);
    shown_[i].seen = shown_[i].seen || !std::isnan(value);
  }
  const StoreSample sample{time, frame.time, frame.restarts * live_store::numbers_of_a_stretch + frame.sequence,
                           values_};
  recorder_.sample(stream, sample);
  if (live_) live_->sample(stream, sample);
  if (!running_) first_ = frame.sequence, first_time_ = time, running_ = true;
  last_ = frame.sequence;
  last_time_ = time;
}

double InstrumentRecorder::rate() const {
  if (codec_.rate > 0.0) return codec_.rate;
  const double span = last_time_ - first_time_;
  return span > 0.5 && last_ > first_ ? static_cast<double>(last_ - first_) / span : 0.0;
}

}  // namespace tumble
