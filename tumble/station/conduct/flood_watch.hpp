#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/station/carry_out.hpp"
#include "tumble/station/link.hpp"
#include "tumble/station/station_file.hpp"
#include "tumble/wire/controller.hpp"
#include "tumble/wire/frames.hpp"

namespace tumble::conduct {

/// [byte/s] that a controller may deliver: an answer of the longest kind to each question of a poll, and 64 kB more
/// that nobody asked for, which is five times what a line of 115 200 baud carries: a controller that reports by itself
/// is heard.
double explained_rate(const Station& station, std::size_t device, const Controller& controller);
/// [byte/s] that a stream may deliver: ten times its declared rate, and 256 kB more; 16 MB where no rate is declared.
double explained_rate(const StationInstrument& instrument, const FrameCodec& codec);

/// Compares the bytes that arrive at a link with the rate that is explained. More than that for a second is a flood, of
/// which only the latest bytes are taken: earlier bytes are late.
class FloodWatch {
 public:
  explicit FloodWatch(double rate) : rate_(rate) {}  ///< [byte/s] that is explained

  /// The part that is taken of bytes which have arrived at `time` [s].
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
  /// How many were not allowed, once a second has passed. `time` [s].
  std::uint64_t take_untold(double time);

 private:
  double second_ = -1.0;
  int count_ = 0;
  std::uint64_t untold_ = 0;
};

/// All wires of a station: its devices, then its instruments.
class Floods {
 public:
  /// Given     longest_look  [s] usual between two looks
  Floods(const Station& station, const StationParts& parts, double longest_look);

  /// The part that is taken of the bytes of an event. `stop` gets once for each wire the reason why its flood ends the
  /// run.
  std::string_view take(const LinkEvent& event, const std::function<void(const Sentence&)>& stop);
  /// Is called after each wait, at `now` [s]: what came while this process was stopped is no flood.
  void looked(double now);
  /// Bytes that are not kept, in words.
  std::vector<Sentence> dropped() const;

 private:
  std::vector<FloodWatch> wires_;
  std::vector<std::string> names_;
  double longest_look_, looked_ = 0.0;  ///< [s]
  bool begun_ = false;
};

}  // namespace tumble::conduct
