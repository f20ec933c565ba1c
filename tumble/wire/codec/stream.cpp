#include <algorithm>
#include <cmath>

#include "tumble/wire/codec/content.hpp"
#include "tumble/wire/codec/line.hpp"
#include "tumble/wire/codec/number.hpp"
#include "tumble/wire/codec/order.hpp"
#include "tumble/wire/frames.hpp"

namespace tumble {

namespace {

constexpr unsigned char may_begin = 1, may_stand_between = 2;

/// Frames beside garbage that are not used where nothing but a counter shows them: of garbage 4^-4 counts as far.
constexpr std::size_t unproven_frames = 3;

/// Every byte with which a frame of the layout may begin, and the end of a line, which may stand between frames.
void note_first_bytes(const FrameLayout& layout, std::vector<unsigned char>& first) {
  const unsigned byte = layout.sync.empty() ? 0 : static_cast<unsigned char>(layout.sync[0]);
  const unsigned mask = layout.sync.empty() ? 0 : static_cast<unsigned char>(layout.sync_mask[0]);
  for (unsigned value = 0; value < 256; ++value)
    if (((value ^ byte) & mask) == 0 && (!layout.text || codec::is_of_line(static_cast<unsigned char>(value))))
      first[value] |= may_begin;
  if (layout.text) first['\r'] |= may_stand_between, first['\n'] |= may_stand_between;
}

void note(FrameIncident& incident, std::uint64_t offset) {
  if (incident.count++ == 0) incident.first = offset;
}

}  // namespace

struct FrameStream::Order {
  codec::FrameOrder frames;
};

FrameStream::FrameStream(const FrameCodec& codec)
    : codec_(&codec), first_(256), carries_(codec.frames.size()), order_(std::make_unique<Order>()) {
  for (std::size_t i = 0; i < codec.frames.size(); ++i) {
    const FrameLayout& layout = codec.frames[i];
    note_first_bytes(layout, first_);
    carries_[i] = !layout.fields.empty();
    counted_ = counted_ || layout.counter.has_value();
  }
  for (const char byte : codec.between) first_[static_cast<unsigned char>(byte)] |= may_stand_between;
  frame_.content.values.resize(codec.channels.size());
  frame_.content.present.resize(codec.channels.size());
  counts_.by_layout.resize(codec.frames.size());
  for (const FrameLayout& layout : codec.frames) counts_.not_good.emplace_back(layout.statuses.size());
}

FrameStream::FrameStream(FrameStream&& other) noexcept = default;
FrameStream& FrameStream::operator=(FrameStream&& other) noexcept = default;
FrameStream::~FrameStream() = default;

void FrameStream::feed(std::string_view bytes, const FrameSink& sink) {
  counts_.bytes += bytes.size();
  pending_ += bytes;
  work(false, sink);
}

void FrameStream::finish(const FrameSink& sink) {
  const std::size_t rest = pending_.size();
  const std::uint64_t begin = base_, good = counts_.good;
  // A frame that is found by its counter may have waited for those behind it.
  const bool cut = rest > 0 && begin == expected_ && candidate_at(0, true).state != State::good;
  if (cut) accounted_ = begin + rest;
  work(true, sink);
  if (cut && counts_.good == good)
    counts_.cut = rest;
  else if (cut)
    note(counts_.damaged, begin);
  flush(sink);
}

void FrameStream::flush(const FrameSink& sink) {
  order_->frames.finish(counts_,
                        [&](const codec::FrameOrder::Released& one) { hand_out(one.frame, one.lost, one.anew, sink); });
}

void FrameStream::begin_again() {
  answers_ = true;
  order_->frames.begin_again(counts_);
}

bool FrameStream::holds() const { return order_->frames.holds(); }

FrameStream::Candidate FrameStream::candidate_at(std::size_t at, bool last) const {
  const std::string_view rest = std::string_view(pending_).substr(at);
  Candidate found;
  for (std::size_t i = 0; i < codec_->frames.size(); ++i) {
    const FrameLayout& layout = codec_->frames[i];
    if (layout.counter && layout.counter->lock > 0) {
      if (const Candidate counted = counted_at(i, at, last); counted.state != State::none) return counted;
      continue;
    }
    if (!codec::begins(layout, rest) || (layout.text && !may_begin_line(layout, at))) continue;
    const auto length =
        rest.size() < layout.sync.size() ? std::optional<std::size_t>(0) : codec::length_of(layout, rest);
    if (!length) continue;
    // Bytes without a checksum count if another frame follows them, or nothing.
    const bool certain = !layout.checks.empty() || layout.text;
    const std::size_t needed = *length + (certain ? 0 : 1);
    if ((*length == 0 || rest.size() < needed) && !last) return {State::waits, i, 0};
    if (*length == 0 || rest.size() < *length) continue;
    const bool followed = certain || rest.size() == *length || first_[static_cast<unsigned char>(rest[*length])] != 0;
    if (followed && codec::sound(layout, rest.substr(0, *length))) return {State::good, i, *length};
    if (found.state == State::none) found = {State::damaged, i, *length};
  }
  return found;
}

/// Frames from `at` on that are found by their counter alone.
struct CountedRun {
  const FrameLayout& layout;
  std::string_view bytes;
  bool last;  ///< no more bytes follow

  using State = FrameStream::State;

  std::size_t available() const { return bytes.size() / static_cast<std::size_t>(layout.length); }

  std::uint64_t counter(std::size_t k) const {
    const std::size_t at =
        k * static_cast<std::size_t>(layout.length) + static_cast<std::size_t>(layout.counter->number.at);
    return codec::natural_of(layout.counter->number, reinterpret_cast<const unsigned char*>(bytes.data()) + at) %
           layout.counter->modulus;
  }

  bool follows(std::uint64_t now, std::uint64_t before) const {
    return now == (before + layout.counter->step) % layout.counter->modulus;
  }

  /// Whether as many frames as the lock needs count from the k-th on; `at_end` where the stream ends before.
  State counts_from(std::size_t k, State at_end) const {
    const std::size_t end = k + static_cast<std::size_t>(layout.counter->lock);
    for (std::size_t i = k + 1; i < end; ++i) {
      if (i >= available()) return last ? at_end : State::waits;
      if (!follows(counter(i), counter(i - 1))) return State::none;
    }
    return State::good;
  }

  /// Whether the first frame, which counts on from the one before it, is no garbage that happens to: the next ones
  /// count on as well, or one is lost or damaged and those behind it lie as before.
  State is_confirmed() const {
    for (std::size_t i = 1; i <= unproven_frames; ++i) {
      if (i >= available()) return last ? State::good : State::waits;
      if (follows(counter(i), counter(i - 1))) continue;
      for (const std::size_t k : {i, i + 1})
        if (const State state = counts_from(k, State::good); state != State::none) return state;
      return State::none;
    }
    return State::good;
  }
};

FrameStream::Candidate FrameStream::counted_at(std::size_t frame, std::size_t at, bool last) const {
  const FrameLayout& layout = codec_->frames[frame];
  const CountedRun run{layout, std::string_view(pending_).substr(at), last};
  if (run.available() == 0) return {last ? State::none : State::waits, frame, 0};
  const bool counts_on =
      order_->frames.counter() && base_ + at == expected_ && run.follows(run.counter(0), *order_->frames.counter());
  return {counts_on ? run.is_confirmed() : run.counts_from(0, State::none), frame,
          static_cast<std::size_t>(layout.length)};
}

/// Garbage before a frame that is found by its counter alone may count as well: the first ones behind it are not used.
bool FrameStream::is_unproven(std::size_t at, const Candidate& found) {
  const auto& counter = codec_->frames[found.frame].counter;
  if (!counter || counter->lock == 0 || bad_bytes_ <= found.length) return false;
  const std::uint64_t offset = base_ + at;
  if (offset > proven_) proven_ = offset + unproven_frames * found.length;
  return offset != proven_;
}

/// Whether a line may begin here: anywhere if it has a head, else behind a frame or the end of a line. The begin of the
/// stream may lie in the middle of a line, which only a checksum would show.
bool FrameStream::may_begin_line(const FrameLayout& layout, std::size_t at) const {
  if (!layout.sync.empty()) return true;
  if (base_ + at == 0) return !layout.checks.empty();
  if (counts_.good > 0 && base_ + at == expected_) return true;
  return (at > 0 ? pending_[at - 1] : before_) == layout.end.back();
}

void FrameStream::skip(std::size_t at) {
  const std::uint64_t offset = base_ + at;
  if (!in_run_ && (first_[static_cast<unsigned char>(pending_[at])] & may_stand_between) != 0) {
    if (expected_ == offset) ++expected_;
    return;
  }
  if (answers_) return;
  ++bad_bytes_;
  if (offset < accounted_) return;
  ++counts_.skipped_bytes;
  if (!in_run_) note(counts_.skipped, offset);
  in_run_ = true;
}

void FrameStream::work(bool last, const FrameSink& sink) {
  std::size_t at = 0;
  while (at < pending_.size()) {
    if ((first_[static_cast<unsigned char>(pending_[at])] & may_begin) == 0) {
      skip(at++);
      continue;
    }
    const Candidate found = candidate_at(at, last);
    if (found.state == State::waits) break;
    if (found.state == State::good && !is_unproven(at, found)) {
      accept(at, found, sink);
      at += found.length;
      continue;
    }
    if (found.state == State::damaged && base_ + at == expected_ && expected_ >= accounted_) {
      note(counts_.damaged, expected_);
      accounted_ = expected_ += found.length;
      in_run_ = false;
    }
    skip(at++);
  }
  if (at > 0) before_ = pending_[at - 1];
  pending_.erase(0, at);
  base_ += at;
}

void FrameStream::accept(std::size_t at, const Candidate& found, const FrameSink& sink) {
  const std::string_view bytes = std::string_view(pending_).substr(at, found.length);
  ++counts_.good;
  ++counts_.by_layout[found.frame];
  counts_.good_bytes += found.length;
  expected_ = accounted_ = base_ + at + found.length;
  in_run_ = answers_ = false;
  if (!carries_[found.frame]) return;
  const FrameLayout& layout = codec_->frames[found.frame];
  codec::read_content(*codec_, found.frame, bytes, frame_.content);
  const std::uint64_t by_bytes = counts_.channel_frames > 0 ? (bad_bytes_ + found.length - 1) / found.length : 0;
  bad_bytes_ = 0;
  frame_.offset = base_ + at;
  frame_.complete = expected_;
  const auto release = [&](const codec::FrameOrder::Released& one) {
    if (one.is_news) take_note(one.frame);
    hand_out(one.frame, one.lost, one.anew, sink);
  };
  if (!layout.counter || !frame_.content.counter) {
    take_note(frame_);
    return order_->frames.add_uncounted(frame_, by_bytes, release);
  }
  const codec::CounterReading reading{*frame_.content.counter,
                                      layout.counter->modulus,
                                      layout.counter->step,
                                      by_bytes,
                                      std::hash<std::string_view>{}(bytes),
                                      layout.counter->lock == 0};
  const auto arrival = order_->frames.add(frame_, reading, counts_, release);
  if (arrival == codec::FrameOrder::Arrival::in_order || arrival == codec::FrameOrder::Arrival::late) take_note(frame_);
}

/// Counts a frame that is used.
void FrameStream::take_note(const StreamFrame& frame) {
  const FrameContent& content = frame.content;
  ++counts_.channel_frames;
  if (!main_) main_ = content.frame;
  for (std::size_t i = 0; content.not_good >> i != 0; ++i)
    if (content.not_good >> i & 1u) note(counts_.not_good[content.frame][i], frame.offset);
  if (content.unreadable == 0) return;
  note(counts_.unreadable, frame.offset);
  counts_.unreadable.count += static_cast<std::uint64_t>(content.unreadable) - 1;
}

void FrameStream::hand_out(StreamFrame& frame, std::uint64_t lost, bool anew, const FrameSink& sink) {
  const bool has_counter = codec_->frames[frame.content.frame].counter.has_value();
  if (lost > 0 && has_counter) {
    note(counts_.gaps, frame.offset);
    counts_.lost += lost;
  }
  if (anew) {
    note(counts_.restarts, frame.offset);
    ++restarts_;
  }
  const bool counts = counted_ ? has_counter : !main_ || *main_ == frame.content.frame;
  if (begun_ && counts) sequence_ += 1 + lost;
  begun_ = true;
  frame.sequence = sequence_;
  frame.restarts = restarts_;
  unwrap_time(frame);
  sink(frame);
}

void FrameStream::unwrap_time(StreamFrame& frame) {
  frame.time.reset();
  if (frame.content.time) {
    const double now = *frame.content.time;
    const double wrap = frame.content.wrap;
    if (clock_.running && wrap > 0.0) {
      if (now < clock_.last - 0.5 * wrap) clock_.wraps += wrap;
      if (now > clock_.last + 0.5 * wrap && clock_.wraps > 0.0) clock_.wraps -= wrap;
    }
    clock_.running = true;
    clock_.last = now;
  }
  if (clock_.running) frame.time = clock_.last + clock_.wraps;
}

}  // namespace tumble
