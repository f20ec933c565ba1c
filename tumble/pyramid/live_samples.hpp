#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/units/unit.hpp"

namespace tumble {

/// Name of the samples of a run in its folder, while it goes on.
inline constexpr std::string_view live_samples_name = "live.samples";

/// The samples of a run, appended to a file for those who look at the run while it goes on. The file is a view and no
/// record: it may end before the run does. A thread of its own writes it, and whoever gives samples never waits for the
/// disk. No function throws; where nothing can be written, nothing is.
class LiveSamples {
 public:
  struct Channel {
    std::string name, slot;
    Unit unit;
    double factor = 1.0;  ///< [1] by which the values given are multiplied
  };

  /// Opens the file, or goes on with it. Its writing stops below `least_room` [byte] of the file system.
  explicit LiveSamples(const std::string& path, std::uint64_t least_room = std::uint64_t{1} << 30);
  LiveSamples(const LiveSamples&) = delete;
  LiveSamples& operator=(const LiveSamples&) = delete;
  ~LiveSamples();

  /// The number of a channel; that of an earlier one of this slot and name.
  std::size_t add(const Channel& channel);
  /// A value [SI] at `time` [s], which is not before that of the last one; what is not finite is missing.
  void sample(std::size_t channel, double time, double value);
  /// A segment begins to be recorded, and pauses, at `time` [s].
  void begin_mark(const std::string& label, int run, double time);
  void end_mark(double time);  ///< [s]
  /// A fact about the recording: "instrument", "target" (the file that the run becomes, from its folder).
  void fact(const std::string& name, const std::string& value);
  /// Whether it still writes.
  bool goes_on() const;

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

}  // namespace tumble
