#pragma once

#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "tumble/core/recording.hpp"
#include "tumble/station/recorder.hpp"

namespace tumble::recorder {

/// Finds in the journal which attempt at each segment counts, and when it recorded.
class JournalReader {
 public:
  void add(const JournalRow& row);
  /// The last finished attempt at each segment of each power-up, in order of time.
  std::vector<Mark> marks() const;
  /// Marks of what counts, and of the attempt that records at this moment, up to `now` [s].
  std::vector<Mark> marks_so_far(double now) const;

 private:
  struct Attempt {
    std::vector<std::pair<double, double>> spans;  ///< [s] recorded
    bool recording = false;
  };
  struct Segment {
    std::map<int, Attempt> attempts;
    std::vector<std::pair<double, double>> counted;
  };
  using Key = std::tuple<int, std::size_t, std::string>;  ///< power-up, index and label
  std::map<Key, Segment> segments_;
  std::optional<std::pair<Key, int>> recording_;  ///< the attempt that records; one that was interrupted does not
};

}  // namespace tumble::recorder
