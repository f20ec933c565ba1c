#pragma once

#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "tumble/core/recording.hpp"
#include "tumble/station/recorder.hpp"

namespace tumble::recorder {

/// Which attempt at each segment counts, and when it recorded.
class JournalReader {
 public:
  void add(const JournalRow& row);
  /// The last finished attempt at each segment of each power-up, in order of time.
  std::vector<Mark> marks() const;

 private:
  struct Attempt {
    std::vector<std::pair<double, double>> spans;  ///< [s] recorded
    bool recording = false;
  };
  struct Segment {
    std::map<int, Attempt> attempts;
    std::vector<std::pair<double, double>> counted;
  };
  std::map<std::tuple<int, std::size_t, std::string>, Segment> segments_;  ///< by power-up, index and label
};

}  // namespace tumble::recorder
