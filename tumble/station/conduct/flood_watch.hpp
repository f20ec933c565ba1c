#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "tumble/station/station_file.hpp"
#include "tumble/wire/controller.hpp"
#include "tumble/wire/frames.hpp"

namespace tumble::conduct {

/// [byte/s] that a controller may deliver: an answer of the longest kind to each question of a poll, and 64 kB more that
/// nobody asked for, which is five times what a line of 115 200 baud carries: a controller that reports by itself is
/// heard.
double explained_rate(const Station& station, std::size_t device, const Controller& controller);
/// [byte/s] that a stream may deliver: ten times its declared rate, and 256 kB more; 16 MB where no rate is declared.
double explained_rate(const StationInstrument& instrument, const FrameCodec& codec);

/// What arrives at a link, against what explains it. More than that for a second is a flood, of which only the latest
/// bytes are taken: those of before are late.
class FloodWatch {
 public:
  explicit FloodWatch(double rate) : rate_(rate) {}  ///< [byte/s] that is explained

  /// What is taken of bytes that have arrived at `time` [s].
  std::string_view take(std::string_view bytes, double time);
  /// Nobody looked for so long [s]: what came in that time comes now.
  void overslept(double seconds) { level_ -= rate_ * seconds; }
  bool floods() const { return floods_; }  ///< since the begin
  std::uint64_t dropped() const { return dropped_; }
  double rate() const { return rate_; }

 private:
  double rate_;
  double level_ = 0.0;  ///< [byte] that nothing explains; negative: that may come
  double time_ = 0.0;   ///< [s] the last bytes
  bool begun_ = false, floods_ = false;
  std::uint64_t dropped_ = 0;
};

/// How many words about one link are worth a line of the journal: the first of a second.
class WordLimit {
 public:
  bool allows(double time);  ///< [s]
  /// How many were not allowed, once a second has passed without one that was told.
  std::uint64_t take_untold(double time);

 private:
  double second_ = -1.0;
  int count_ = 0;
  std::uint64_t untold_ = 0;
};

}  // namespace tumble::conduct
