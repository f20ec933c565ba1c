#include "tumble/station/conduct/channel_values.hpp"

#include <utility>

namespace tumble::conduct {

std::set<std::string> watched_channels(const Station& station) {
  std::set<std::string> watched;
  for (const StationInterlock& interlock : station.interlocks)
    for (const auto& term : interlock.require.terms) watched.insert(term.channel);
  for (const StationAxis& axis : station.axes)
    if (!axis.settle.channel.empty()) watched.insert(axis.settle.channel);
  return watched;
}

void add_values(const std::string& slot, const InstrumentRecorder& stream, const std::set<std::string>* only,
                ChannelValues& values) {
  for (const auto& shown : stream.shown()) {
    if (!shown.seen) continue;
    std::string channel = slot + "." + shown.channel.name;
    if (!only || only->contains(channel)) values.values.insert_or_assign(std::move(channel), shown.last);
  }
}

}  // namespace tumble::conduct
