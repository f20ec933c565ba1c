#pragma once

#include <cstdint>
#include <string>

#include "tumble/core/finding.hpp"

namespace tumble::topics {

/// a - b [ns], without overflow for times that damage has moved anywhere.
inline std::int64_t difference(std::int64_t a, std::int64_t b) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b));
}

/// Stamps of the two clocks of a stream: header.stamp, which the driver of the instrument writes, and the time of the
/// recorder. All times [ns].
struct ClockSummary {
  std::size_t count = 0;
  std::size_t zeros = 0;             ///< header.stamp is zero
  std::size_t backward = 0;          ///< recorded before the one before
  std::size_t stamped_backward = 0;  ///< header.stamp before that of the one before
  std::int64_t first_stamp = 0, second_stamp = 0, last_stamp = 0, first_received = 0, last_received = 0;

  void add(std::int64_t stamp, std::int64_t received);
  /// Whether the messages do not stand in the order of time by either clock, and have to be sorted.
  bool out_of_order() const { return backward > 0 && (stamped_backward > 0 || first_stamp == last_stamp); }
  /// Whether a first stamp of zero is the begin of the clock, as the others continue from there.
  bool begins_at_zero() const;
};

/// Clock that is used: time = stamp + offset, or the time of the recorder.
struct ClockChoice {
  bool header = true;
  std::int64_t offset = 0;  ///< [ns]

  /// [ns]
  std::int64_t time(std::int64_t stamp, std::int64_t received) const {
    return header ? difference(stamp, difference(0, offset)) : received;
  }
};

/// header.stamp, unless it is zero, stands still, or runs at another rate than the recorder, which a finding says.
/// Where it counts from another zero (the start of the instrument), the recorder's first time replaces that zero.
ClockChoice choose_clock(const ClockSummary& summary, const std::string& topic, Findings& findings);

/// "1403636579.758555392 s (2014-06-24 19:02:59.758555392 UTC)". Given: time [ns] since 1970.
std::string epoch_text(std::int64_t time);

}  // namespace tumble::topics
