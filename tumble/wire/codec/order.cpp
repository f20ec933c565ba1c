#include "tumble/wire/codec/order.hpp"

#include <algorithm>
#include <utility>

namespace tumble::codec {

namespace {

constexpr std::size_t most_waiting = 16;     ///< frames
constexpr std::uint64_t longest_reach = 64;  ///< numbers by which a frame may be behind
constexpr std::uint64_t long_round = 1024;   ///< frames: a counter that goes back in it has not gone round
constexpr std::uint64_t at_the_begin = 4;    ///< frames before the first one that may come behind it

/// Frames after which the counter shows the same number.
std::uint64_t round_of(const CounterReading& reading, std::uint64_t step) {
  return step == 0 ? reading.modulus : std::max<std::uint64_t>(reading.modulus / step, 1);
}

/// Numbers by which a frame may be behind. Of a short round a small part: a loss of almost a round shows the same
/// numbers as a frame that is late.
std::uint64_t reach_of(const CounterReading& reading, std::uint64_t round) {
  return reading.may_wait ? std::min(longest_reach, round / 16) : 0;
}

/// Frames that the counter shows as missing, from which on it may have begun again instead.
std::uint64_t most_lost_of(std::uint64_t round) {
  return round < long_round ? round / 2 : std::min<std::uint64_t>(round / 16, std::uint64_t{1} << 20);
}

std::uint64_t advance_of(const CounterReading& now, std::uint64_t before) {
  return (now.value + now.modulus - before) % now.modulus;
}

void note_incident(FrameIncident& incident, std::uint64_t offset) {
  if (incident.count++ == 0) incident.first = offset;
}

}  // namespace

std::uint64_t FrameOrder::step_of(const CounterReading& reading, std::uint64_t advance) {
  if (reading.step > 0) return reading.step;
  if (advance == 0 && slot_of(highest_).hash == reading.hash) return step_;
  if (advance == step_seen_ && (step_ == 0 || advance < step_)) step_ = advance;
  step_seen_ = advance;
  return step_;
}

void FrameOrder::begin(const CounterReading& reading) {
  counter_ = reading.value;
  recent_.fill({});
  first_ = highest_ + 1;
}

FrameOrder::Arrival FrameOrder::add(StreamFrame& frame, const CounterReading& reading, FrameCounts& counts,
                                    const Release& release) {
  if (const auto arrival = judge_unproven(reading, counts, release)) return *arrival;
  if (!counter_) {
    drain(0, release);
    begin(reading);
    put(frame, first_, reading, release);
    return Arrival::in_order;
  }
  const std::uint64_t advance = advance_of(reading, *counter_);
  const std::uint64_t step = step_of(reading, advance), round = round_of(reading, step);
  reach_ = reach_of(reading, round);
  const bool on_grid = step > 0 && advance % step == 0;
  const std::uint64_t back = on_grid && advance > 0 ? round - advance / step : 0;
  if (const auto arrival = look_back(frame, reading, back, counts, release)) return *arrival;
  std::uint64_t lost = reading.lost_by_bytes;
  if (step > 0 && (advance > 0 || lost + 1 >= round)) {
    lost = (advance == 0 ? round : std::max<std::uint64_t>(advance / step, 1)) - 1;
    if (const std::uint64_t by_bytes = reading.lost_by_bytes; by_bytes > lost + round / 2)
      lost += (by_bytes - lost + round / 2) / round * round;
  }
  const bool far = reach_ > 0 && lost >= most_lost_of(round) && reading.lost_by_bytes < lost / 2;
  if (far) {
    unproven_ = {frame, reading, lost, round >= long_round};
    return Arrival::unproven;
  }
  counter_ = reading.value;
  put(frame, highest_ + 1 + static_cast<std::int64_t>(lost), reading, release);
  return Arrival::in_order;
}

/// A frame again, one that was missing, or one before the first of all; nothing where it is another.
std::optional<FrameOrder::Arrival> FrameOrder::look_back(StreamFrame& frame, const CounterReading& reading,
                                                         std::uint64_t back, FrameCounts& counts,
                                                         const Release& release) {
  if (back > reach_) return {};
  if (back == 0 && reading.value != *counter_) return {};
  const std::int64_t number = highest_ - static_cast<std::int64_t>(back);
  if (const Numbered& same = slot_of(number); number >= first_ && same.number == number) {
    const std::uint64_t round = round_of(reading, reading.step > 0 ? reading.step : step_);
    if (same.hash != reading.hash || reading.lost_by_bytes + 1 >= round) return {};
    note_incident(counts.repeated, frame.offset);
    return Arrival::repeated;
  }
  if (number > released_) {
    note_incident(counts.exchanged, frame.offset);
    put(frame, number, reading, release);
    return Arrival::late;
  }
  if (number >= first_ || back > at_the_begin || highest_ - first_ >= static_cast<std::int64_t>(at_the_begin))
    return {};
  note_incident(counts.too_late, frame.offset);
  return Arrival::repeated;
}

/// The counter has begun again where this frame continues from the one that waits.
std::optional<FrameOrder::Arrival> FrameOrder::judge_unproven(const CounterReading& reading, FrameCounts& counts,
                                                              const Release& release) {
  if (!unproven_) return {};
  const std::uint64_t step = std::max<std::uint64_t>(reading.step > 0 ? reading.step : step_, 1);
  const std::uint64_t advance = advance_of(reading, unproven_->reading.value);
  if (advance == 0 && reading.hash == unproven_->reading.hash) {
    note_incident(counts.repeated, unproven_->frame.offset);
    return Arrival::repeated;
  }
  if (advance == 0 || advance / step > reach_ + 1) {
    give_up_unproven(counts);
    return {};
  }
  Unproven proven = *std::exchange(unproven_, std::nullopt);
  drain(0, release);
  released_ = highest_;
  if (!proven.anew) highest_ += static_cast<std::int64_t>(proven.lost);
  begin(proven.reading);
  highest_ = first_;
  slot_of(first_) = {first_, proven.reading.hash};
  const std::uint64_t lost = static_cast<std::uint64_t>(first_ - released_ - 1);
  released_ = first_;
  release({proven.frame, lost, proven.anew, true});
  return {};
}

void FrameOrder::give_up_unproven(FrameCounts& counts) {
  if (unproven_) note_incident(counts.too_late, unproven_->frame.offset);
  unproven_.reset();
}

void FrameOrder::put(StreamFrame& frame, std::int64_t number, const CounterReading& reading, const Release& release) {
  highest_ = std::max(highest_, number);
  slot_of(number) = {number, reading.hash};
  if (held_.empty() && number == released_ + 1) {
    released_ = number;
    return release({frame});
  }
  held_.emplace(number, frame);
  drain(std::min<std::size_t>(most_waiting, reach_), release);
}

void FrameOrder::add_uncounted(StreamFrame& frame, std::uint64_t lost_by_bytes, const Release& release) {
  if (held_.empty() && !unproven_) return release({frame, lost_by_bytes});
  held_.emplace(highest_, frame);
}

/// Releases what continues the order, and what waits where more than `most` do.
void FrameOrder::drain(std::size_t most, const Release& release) {
  while (!held_.empty() && (held_.begin()->first <= released_ + 1 || held_.size() > most)) {
    const auto first = held_.begin();
    for (const auto& [number, other] : held_) first->second.complete = std::min(first->second.complete, other.complete);
    const std::int64_t lost = std::max<std::int64_t>(first->first - released_ - 1, 0);
    released_ = std::max(released_, first->first);
    release({first->second, static_cast<std::uint64_t>(lost)});
    held_.erase(first);
  }
}

void FrameOrder::finish(FrameCounts& counts, const Release& release) {
  drain(0, release);
  give_up_unproven(counts);
}

void FrameOrder::begin_again(FrameCounts& counts) {
  counter_.reset();
  recent_.fill({});
  give_up_unproven(counts);
}

}  // namespace tumble::codec
