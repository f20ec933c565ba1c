#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/recording.hpp"
#include "tumble/formats/topics/clock.hpp"
#include "tumble/formats/topics/topic.hpp"

namespace tumble::topics {

/// Facts about the samples of a topic that are known after all of them were read.
struct Overview {
  std::size_t count = 0;         ///< [1] samples
  ClockSummary clocks;           ///< of a log with two clocks, as are the next three
  ClockChoice choice;            ///< how the times follow from the stamps
  std::int64_t first = 0;        ///< [ns] of the first sample, by the chosen clock
  std::size_t sorted = 0;        ///< places where a message was earlier than the one before it in the file
  std::optional<Timeline> even;  ///< where the samples are evenly spaced
  std::size_t unreadable = 0;
  bool values_seen = false;        ///< the values of all samples were there, not the stamps alone
  std::size_t infinite = 0;        ///< values, which are taken as missing
  std::vector<char> measured;      ///< of each column
  std::string frame, other_frame;  ///< of the first message, and of one that has another
};

/// Overviews of samples that are still to be seen.
std::vector<Overview> overviews_of(const std::vector<Topic>& topics);
/// Adds all but stamps [s] and values [as written].
void note(std::span<const Stretch* const> stretches, std::vector<Overview>& overviews);

/// Sets the zero of time. Where a log has two clocks, 0 s is the first sample of all topics, from which the even clocks
/// then count. Its time [ns]; 0 for another log, whose clock remains.
std::int64_t set_epoch(const Log& log, std::vector<Overview>& overviews);

/// [s] after the epoch.
inline double seconds_after(std::int64_t epoch, std::int64_t time) {
  return static_cast<double>(difference(time, epoch)) / 1e9;
}

/// Whether a column is a channel: some message measures it.
inline bool is_channel(const Topic& topic, const Overview& overview, std::size_t column) {
  return !topic.may_lack || (overview.count > 0 && overview.measured[column]);
}

/// "3 samples of sensor_gyro:0 are infinite and read as missing"
Finding infinite_samples(const Topic& topic, std::size_t count);

/// Everything but samples and timelines: channels, meta and findings. Throws Error::bad_file where nothing was read.
/// Given: epoch [ns], of set_epoch(); clock_findings, of choose_clock().
Recording frame_of(const Log& log, const std::vector<Overview>& overviews, std::int64_t epoch, const Played& played,
                   const Findings& clock_findings);

}  // namespace tumble::topics
