#pragma once

#include <cstdint>
#include <deque>

namespace tumble::conduct {

/// Rows of the journal on their way to the disk. What moves the rig waits for them, and the supervision does not.
class RowWait {
 public:
  /// `longest` [s of the station's clock] that the disk may take.
  explicit RowWait(double longest) : longest_(longest) {}

  /// A row with this number of the store; 0: it was not taken, and never will be.
  void wrote(std::uint64_t sequence);
  /// Takes note of the rows that are on the disk at `now` [s]. Returned: rows have come to it since the last call.
  bool look(std::uint64_t on_disk, double now);
  bool waits() const { return !rows_.empty(); }
  std::uint64_t stored() const { return stored_; }
  /// The disk takes too long. Time in which nobody looked is no evidence: this process had to wait itself.
  bool is_overdue() const { return waits() && looks_ > 0 && waited_ >= longest_; }

 private:
  double longest_;
  std::deque<std::uint64_t> rows_;
  std::uint64_t stored_ = 0;
  int looks_ = 0;         ///< since the disk has done something
  double waited_ = 0.0;   ///< [s]
  double looked_ = -1.0;  ///< [s] the last look
};

}  // namespace tumble::conduct
