#include <algorithm>
#include <cmath>

#include "tumble/wire/codec/content.hpp"
#include "tumble/wire/codec/number.hpp"
#include "tumble/wire/frames.hpp"

namespace tumble {

namespace {

constexpr unsigned char may_begin = 1, may_stand_between = 2;

/// Every byte that a byte with `mask` fixed may be.
void note_first_bytes(unsigned char byte, unsigned char mask, std::vector<unsigned char>& first) {
  for (unsigned value = 0; value < 256; ++value)
    if (((value ^ byte) & mask) == 0) first[value] |= may_begin;
}

void note(FrameIncident& incident, std::uint64_t offset) {
  if (incident.count++ == 0) incident.first = offset;
}

}  // namespace

FrameStream::FrameStream(const FrameCodec& codec) : codec_(&codec), first_(256), carries_(codec.frames.size()) {
  for (std::size_t i = 0; i < codec.frames.size(); ++i) {
    const FrameLayout& layout = codec.frames[i];
    note_first_bytes(static_cast<unsigned char>(layout.sync[0]), static_cast<unsigned char>(layout.sync_mask[0]),
                     first_);
    carries_[i] = !layout.fields.empty();
    counted_ = counted_ || layout.counter.has_value();
  }
  for (const char byte : codec.between) first_[static_cast<unsigned char>(byte)] |= may_stand_between;
  frame_.content.values.resize(codec.channels.size());
  frame_.content.present.resize(codec.channels.size());
  counts_.by_layout.resize(codec.frames.size());
  for (const FrameLayout& layout : codec.frames) counts_.not_good.emplace_back(layout.statuses.size());
}

void FrameStream::feed(std::string_view bytes, const FrameSink& sink) {
  counts_.bytes += bytes.size();
  pending_ += bytes;
  work(false, sink);
}

void FrameStream::finish(const FrameSink& sink) {
  const std::size_t rest = pending_.size();
  const std::uint64_t begin = base_, good = counts_.good;
  const bool cut = rest > 0 && begin == expected_;
  if (cut) accounted_ = begin + rest;
  work(true, sink);
  if (cut && counts_.good == good)
    counts_.cut = rest;
  else if (cut)
    note(counts_.damaged, begin);
}

FrameStream::Candidate FrameStream::candidate_at(std::size_t at, bool last) const {
  using State = Candidate::State;
  const std::string_view rest = std::string_view(pending_).substr(at);
  Candidate found;
  for (std::size_t i = 0; i < codec_->frames.size(); ++i) {
    const FrameLayout& layout = codec_->frames[i];
    if (!codec::begins(layout, rest)) continue;
    const auto length =
        rest.size() < layout.sync.size() ? std::optional<std::size_t>(0) : codec::length_of(layout, rest);
    if (!length) continue;
    // A frame without a checksum counts if another one follows it, or nothing.
    const std::size_t needed = *length + (layout.checks.empty() ? 1 : 0);
    if ((*length == 0 || rest.size() < needed) && !last) return {State::waits, i, 0};
    if (*length == 0 || rest.size() < *length) continue;
    const bool followed =
        !layout.checks.empty() || rest.size() == *length || first_[static_cast<unsigned char>(rest[*length])] != 0;
    if (followed && codec::sound(layout, rest.substr(0, *length))) return {State::good, i, *length};
    if (found.state == State::none) found = {State::damaged, i, *length};
  }
  return found;
}

void FrameStream::skip(std::size_t at) {
  const std::uint64_t offset = base_ + at;
  if (!in_run_ && (first_[static_cast<unsigned char>(pending_[at])] & may_stand_between) != 0) {
    if (expected_ == offset) ++expected_;
    return;
  }
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
    if (found.state == Candidate::State::waits) break;
    if (found.state == Candidate::State::good) {
      accept(at, found, sink);
      at += found.length;
      continue;
    }
    if (found.state == Candidate::State::damaged && base_ + at == expected_ && expected_ >= accounted_) {
      note(counts_.damaged, expected_);
      accounted_ = expected_ += found.length;
      in_run_ = false;
    }
    skip(at++);
  }
  pending_.erase(0, at);
  base_ += at;
}

void FrameStream::accept(std::size_t at, const Candidate& found, const FrameSink& sink) {
  const std::string_view bytes = std::string_view(pending_).substr(at, found.length);
  ++counts_.good;
  ++counts_.by_layout[found.frame];
  counts_.good_bytes += found.length;
  expected_ = accounted_ = base_ + at + found.length;
  in_run_ = false;
  if (!carries_[found.frame]) return;
  const FrameLayout& layout = codec_->frames[found.frame];
  codec::read_content(*codec_, found.frame, bytes, frame_.content);
  const bool begun = counts_.channel_frames > 0;
  const std::uint64_t by_bytes = begun ? (bad_bytes_ + found.length - 1) / found.length : 0;
  bad_bytes_ = 0;
  const auto lost = lost_before(bytes, by_bytes);
  frame_.offset = base_ + at;
  if (!lost) return note(counts_.repeated, frame_.offset);
  if (*lost > 0 && layout.counter) {
    note(counts_.gaps, frame_.offset);
    counts_.lost += *lost;
  }
  ++counts_.channel_frames;
  for (std::size_t i = 0; frame_.content.not_good >> i != 0; ++i)
    if (frame_.content.not_good >> i & 1u) note(counts_.not_good[found.frame][i], frame_.offset);
  if (!main_) main_ = found.frame;
  if (begun && (counted_ ? layout.counter.has_value() : *main_ == found.frame)) frame_.sequence += 1 + *lost;
  unwrap_time();
  sink(frame_);
}

std::optional<std::uint64_t> FrameStream::lost_before(std::string_view bytes, std::uint64_t lost_by_bytes) {
  const FrameLayout& layout = codec_->frames[frame_.content.frame];
  if (!layout.counter || !frame_.content.counter) return lost_by_bytes;
  const std::uint64_t modulus = layout.counter->modulus, now = *frame_.content.counter;
  const auto before = counter_;
  counter_ = now;
  const bool same = before && *before == now && last_bytes_ == bytes;
  last_bytes_ = bytes;
  if (same) return std::nullopt;
  if (!before) return 0;
  const std::uint64_t advance = (now + modulus - *before) % modulus;
  std::uint64_t step = layout.counter->step;
  if (step == 0) {
    if (advance == step_seen_ && (step_ == 0 || advance < step_)) step_ = advance;
    step_seen_ = advance;
    step = step_;
  }
  if (step == 0) return lost_by_bytes;
  const std::uint64_t round = std::max<std::uint64_t>(modulus / step, 1);  // frames after which the counter is the same
  if (advance == 0 && lost_by_bytes + 1 < round) return lost_by_bytes;     // a counter that stands
  std::uint64_t lost = (advance == 0 ? round : std::max<std::uint64_t>(advance / step, 1)) - 1;
  if (lost_by_bytes > lost + round / 2) lost += (lost_by_bytes - lost + round / 2) / round * round;
  return lost;
}

void FrameStream::unwrap_time() {
  frame_.time.reset();
  if (frame_.content.time) {
    const double now = *frame_.content.time;
    const double wrap = frame_.content.wrap;
    if (clock_.running && wrap > 0.0) {
      if (now < clock_.last - 0.5 * wrap) clock_.wraps += wrap;
      if (now > clock_.last + 0.5 * wrap && clock_.wraps > 0.0) clock_.wraps -= wrap;
    }
    clock_.running = true;
    clock_.last = now;
  }
  if (clock_.running) frame_.time = clock_.last + clock_.wraps;
}

}  // namespace tumble
