#pragma once

#include <set>
#include <string>

#include "tumble/station/executive.hpp"
#include "tumble/station/recorder_stream.hpp"

/// The channels of instruments as the executive gets them: "slot.channel".
namespace tumble::conduct {

/// Channels that interlocks and settle rules look at.
std::set<std::string> watched_channels(const Station& station);

/// Adds the last value [SI] of each channel that a stream has delivered.
///
/// Given     only  these channels; null: all
void add_values(const std::string& slot, const InstrumentRecorder& stream, const std::set<std::string>* only,
                ChannelValues& values);

}  // namespace tumble::conduct
