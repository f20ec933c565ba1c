#pragma once

#include <optional>
#include <string>

namespace tumble::conduct {

/// Since when samples of the instruments are expected. The silence of a stream goes on from one segment to the next,
/// since a stream does not stop between two segments of one power-up.
class Hearing {
 public:
  /// A segment of this power-up is recorded from `time` [s] on.
  void records(int power_up, double time);
  /// A stream was started or stopped: whether all run is known when the next segment is recorded.
  void switched() { power_up_.reset(); }
  /// [s] without a sample while a stream should have run, the last one of which came at `heard` [s].
  double silence(double heard, double now) const;
  /// In words what did not come until the end of a segment; empty: all came. Given: rate [Hz], 0: unknown.
  Sentence missing(double heard, double rate, double now) const;

 private:
  std::optional<int> power_up_;  ///< that was recorded last
  double since_ = 0.0;           ///< [s] since when all streams should run
  double begin_ = 0.0;           ///< [s] of the segment
};

}  // namespace tumble::conduct
