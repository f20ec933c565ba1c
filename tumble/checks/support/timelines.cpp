#include "tumble/checks/support/timelines.hpp"

#include <algorithm>

namespace tumble::support {

std::vector<StampedTimeline> stamped_timelines(const Recording& recording) {
  std::vector<StampedTimeline> timelines;
  for (const Channel& channel : recording.channels) {
    if (channel.timeline.uniform()) continue;
    const auto known = std::find_if(timelines.begin(), timelines.end(), [&](const StampedTimeline& timeline) {
      return timeline.channel->timeline.stamps == channel.timeline.stamps;
    });
    if (known == timelines.end())
      timelines.push_back({&channel, channel.name});
    else
      known->where += ", " + channel.name;
  }
  const bool all_share = std::none_of(recording.channels.begin(), recording.channels.end(),
                                      [](const Channel& channel) { return channel.timeline.uniform(); });
  if (timelines.size() == 1 && all_share) timelines[0].where.clear();
  return timelines;
}

}  // namespace tumble::support
