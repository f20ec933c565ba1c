#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string_view>

#include "tumble/wire/frames.hpp"

namespace tumble::codec {

/// Reading of the counter of one frame.
struct CounterReading {
  std::uint64_t value = 0, modulus = 256;
  std::uint64_t step = 1;           ///< 0: as the stream shows
  std::uint64_t lost_by_bytes = 0;  ///< frames that fit into the bytes before it that belong to no frame
  std::uint64_t hash = 0;           ///< of its bytes
  bool may_wait = true;             ///< false: such frames come in the order in which they were sent
};

/// Frames in the order of their counter, however a network delivers them.
///
/// A frame that is missing may still be on its way: up to 16 frames behind it wait until it has come. A frame with the
/// number of another and the same bytes is that one again. A counter that goes ahead by a sixteenth of its round or a
/// million frames (of a round below 1024 frames: by half of it) has begun again, which the next frame must confirm:
/// else one frame came too late. How many frames are missing there, a counter of few bits shows; one of many bits does
/// not.
class FrameOrder {
 public:
  enum class Arrival { in_order, late, repeated, unproven };
  struct Released {
    StreamFrame& frame;
    std::uint64_t lost = 0;  ///< frames before it
    bool anew = false;       ///< the counter has begun again, and nobody knows how many are missing
    bool is_news = false;    ///< add() has called it unproven
  };
  using Release = std::function<void(const Released&)>;

  /// A frame, of which a copy is kept where it has to wait. `counts`: what is refused, repeated or late.
  Arrival add(StreamFrame& frame, const CounterReading& reading, FrameCounts& counts, const Release& release);
  /// A frame that has no counter keeps its place behind those that came before it.
  void add_uncounted(StreamFrame& frame, std::uint64_t lost_by_bytes, const Release& release);
  /// All that wait. They wait for nothing any more.
  void finish(FrameCounts& counts, const Release& release);
  /// The counter may begin anew with the next frame, which is no loss.
  void begin_again(FrameCounts& counts);
  const std::optional<std::uint64_t>& counter() const { return counter_; }  ///< of the frame with the highest number
  bool holds() const { return !held_.empty() || unproven_; }

 private:
  struct Numbered {
    std::int64_t number = -1;
    std::uint64_t hash = 0;
  };
  struct Unproven {
    StreamFrame frame;
    CounterReading reading;
    std::uint64_t lost = 0;
    bool anew = false;
  };

  std::optional<Arrival> judge_unproven(const CounterReading& reading, FrameCounts& counts, const Release& release);
  std::optional<Arrival> look_back(StreamFrame& frame, const CounterReading& reading, std::uint64_t back,
                                   FrameCounts& counts, const Release& release);
  std::uint64_t step_of(const CounterReading& reading, std::uint64_t advance);
  void begin(const CounterReading& reading);
  Numbered& slot_of(std::int64_t number) { return recent_[static_cast<std::size_t>(number) % recent_.size()]; }
  void put(StreamFrame& frame, std::int64_t number, const CounterReading& reading, const Release& release);
  void drain(std::size_t most, const Release& release);
  void give_up_unproven(FrameCounts& counts);

  std::optional<std::uint64_t> counter_;  ///< of the frame with the highest number
  std::uint64_t step_ = 0, step_seen_ = 0;
  /// Numbers of frames: of the first since the begin, the highest, and the last one that was released.
  std::int64_t first_ = 0, highest_ = -1, released_ = -1;
  std::uint64_t reach_ = 0;                        ///< numbers by which a frame may be behind
  std::multimap<std::int64_t, StreamFrame> held_;  ///< by number
  std::array<Numbered, 128> recent_ = {};          ///< by number modulo their count
  std::optional<Unproven> unproven_;
};

}  // namespace tumble::codec
