#include "tumble/tasks/marks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tumble {
namespace {

double first_stamp(const Recording& recording) {
  double first = std::numeric_limits<double>::infinity();
  for (const auto& channel : recording.channels)
    if (!channel.values.empty()) first = std::min(first, channel.time(0));
  return first;
}

}  // namespace

void end_marks(const Schedule& schedule, std::vector<Mark>& marks) {
  for (Mark& mark : marks) {
    if (std::isfinite(mark.end)) continue;
    const auto of_label = [&](const Segment& segment) { return segment.label == mark.label; };
    const auto planned = std::ranges::find_if(schedule, of_label);
    const auto other_length = [&](const Segment& segment) {
      return of_label(segment) && segment.duration != planned->duration;
    };
    if (planned != schedule.end() && std::ranges::none_of(schedule, other_length))
      mark.end = mark.begin + planned->duration;
  }
}

void mark_from_schedule(const Plan& plan, const RecordingEntry& entry, Recording& recording) {
  if (!recording.marks.empty()) {
    if (entry.run > 0)
      for (auto& mark : recording.marks) mark.run = entry.run;
    return;
  }
  double begin = first_stamp(recording);
  if (!entry.segment.empty()) {
    const auto planned = std::find_if(plan.schedule.begin(), plan.schedule.end(),
                                      [&](const Segment& segment) { return segment.label == entry.segment; });
    const int run = entry.run > 0 ? entry.run : planned == plan.schedule.end() ? 1 : planned->run;
    recording.marks.push_back({entry.segment, begin, run});
    return;
  }
  for (const auto& segment : plan.schedule) {
    if (entry.run > 0 && segment.run != entry.run) continue;
    recording.marks.push_back({segment.label, begin, segment.run});
    begin += segment.duration;
  }
  if (recording.marks.empty() && entry.run > 0) recording.marks.push_back({"", begin, entry.run});
}

}  // namespace tumble
