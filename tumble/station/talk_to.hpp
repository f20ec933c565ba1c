#pragma once

#include <string>
#include <vector>

#include "tumble/station/carry_out.hpp"

namespace tumble {

/// Answer of one device of a station to a question.
struct DeviceAnswer {
  std::string device;
  ControllerVerb verb{};
  ControllerReply reply;  ///< without an answer its problem says so
  double after = 0.0;     ///< [s]
};

/// Speaks to every device, and moves none: who it is, what it reads, in which state it is.
std::vector<DeviceAnswer> talk_to(const Station& station, const StationParts& parts, const Wires& wires);

/// Bytes that each instrument has sent within `seconds` [s]: good frames and others, in the order of the station. Those
/// without a frame that commands start are started, listened to for up to three times as long, and stopped.
std::vector<FrameCounts> listen_to(const Station& station, const StationParts& parts, const Wires& wires,
                                   double seconds);

}  // namespace tumble
