#pragma once

#include <optional>
#include <vector>

#include "tumble/core/recording.hpp"
#include "tumble/formats/file/even_clock.hpp"
#include "tumble/formats/ros/clock.hpp"
#include "tumble/formats/ros/samples.hpp"

namespace tumble::ros {

/// Facts about a stream that are known after all of it was read.
struct Overview {
  ClockSummary clocks;
  ClockChoice choice;
  std::int64_t first = 0;        ///< [ns] of the first sample, by the chosen clock
  std::optional<Timeline> even;  ///< where the samples are evenly spaced; 0 s is the first
  std::size_t sorted = 0;        ///< places where a message was earlier than the one before it in the file
  std::size_t unreadable = 0;
  std::size_t infinite = 0;        ///< values, which are taken as missing
  std::vector<char> measured;      ///< of each column
  std::string frame, other_frame;  ///< header.frame_id of the first message, and of one that has another
};

/// Everything but the samples: channels with their timelines (those without even spacing still lack stamps), meta and
/// findings. Channels that no message measures are not there. Throws Error::bad_file where nothing was read.
/// Given: clock_findings, of choose_clock().
Recording frame_of(const Log& log, const std::vector<Stream>& streams, const std::vector<Overview>& overviews,
                   const ScanReport& report, const Findings& clock_findings);

/// [ns] the first sample of all streams, which is 0 s of the recording.
std::int64_t epoch_of(const std::vector<Overview>& overviews);

/// [s] after the epoch.
inline double seconds_after(std::int64_t epoch, std::int64_t time) {
  return static_cast<double>(difference(time, epoch)) / 1e9;
}

}  // namespace tumble::ros
