#pragma once

#include <map>
#include <string>
#include <vector>

#include "tumble/station/recorder/sample_clock.hpp"
#include "tumble/station/recorder_read.hpp"

namespace tumble::recorder {

/// The slots that have streams; without any, one without a name.
std::vector<std::string> slots_of(const StoreContent& content);

/// The channels of one slot on their way from a store into a recording: two times through the items.
class SlotReader {
 public:
  /// `slot`: its streams, and those without a slot.
  SlotReader(const StoreContent& content, std::string slot);
  void look(const StoreItem& item);  ///< first time
  void settle();
  /// Whether the samples can be handed out while they are taken: the clocks are even, and known before.
  bool streams() const;
  void take(const StoreItem& item);  ///< second time, and where they are handed out as often as wanted after rewind()
  void rewind();
  bool has_samples() const;
  std::size_t waiting() const;  ///< samples of the channel that has most
  /// The channels that have samples, with those taken since the last time. Unless streams(), after all were taken.
  std::vector<Channel> channels();
  std::string instrument() const;
  /// Suspicious observations: infinite samples, another rate than declared.
  Findings findings() const;

 private:
  struct Signal {
    FrameChannel channel;
    SampleClock clock;
    double declared = 0.0;  ///< [Hz]
    std::optional<std::size_t> link;
    bool one_sequence = true;  ///< its streams count in one sequence
    std::vector<double> values, stamps;
    std::size_t given = 0;                                       ///< samples before `values`
    Occurrences infinite{.count = 0, .first = {}, .worst = {}};  ///< samples that the file has no room for
  };
  std::vector<std::vector<std::size_t>> signals_of_stream_;
  std::vector<Signal> signals_;
  std::string instrument_;
};

}  // namespace tumble::recorder
