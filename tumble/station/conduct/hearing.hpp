#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace tumble::conduct {

/// When samples of the instruments came last. The silence of a stream goes on from one segment to the next, since a
/// stream does not stop between two segments of one power-up.
class Hearing {
 public:
  Hearing(std::size_t instruments, double time) : last_(instruments, time) {}  ///< [s]

  void sample(std::size_t i, double time) { last_[i] = time; }  ///< [s]
  /// A segment of this power-up is recorded from `time` [s] on.
  void records(int power_up, double time);
  /// A stream was started or stopped: whether all run is known when the next segment is recorded.
  void switched() { power_up_.reset(); }
  /// The instrument has failed: nothing is expected of it any more.
  void give_up(std::size_t i);
  double silence(std::size_t i, double now) const;  ///< [s] while it should have run
  /// In words what did not come until the end of a segment; empty: all came. Given: rate [Hz], 0: unknown.
  std::string missing(std::size_t i, double rate, double now) const;

 private:
  std::vector<double> last_;     ///< [s] by instrument
  std::optional<int> power_up_;  ///< that was recorded last
  double since_ = 0.0;           ///< [s] since when all streams should run
  double begin_ = 0.0;           ///< [s] of the segment
};

}  // namespace tumble::conduct
