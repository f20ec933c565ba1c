#include "tumble/core/marks.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/departures/entries/edits.hpp"
#include "tumble/departures/entries/entries.hpp"

namespace tumble::entries {
namespace {

std::vector<std::string> marked(const Plan&, const Recordings& recordings) {
  return std::ranges::any_of(recordings, [](const Recording& r) { return r.marks.size() > 1; })
             ? std::vector<std::string>{""}
             : std::vector<std::string>{};
}

/// Half a second: a person who presses a key, or a program that polls a controller twice a second.
double covered_delay(const Plan&, const Recordings&, const std::string&) { return 0.5; }

void mark_late(const Plan&, Recordings& recordings, const Happening& what) {
  for (Recording& recording : recordings)
    for (std::size_t m = 1; m < recording.marks.size(); ++m) recording.marks[m].begin += what.size;
}

/// The samples from `begin` to `end` [s] of a channel, with their stamps.
Channel cut(const Channel& channel, double begin, double end) {
  Channel part = channel;
  part.values.clear();
  auto stamps = std::make_shared<std::vector<double>>();
  double start = begin;
  for (std::size_t i = 0; i < channel.values.size(); ++i) {
    const double time = channel.time(i);
    if (!(begin <= time && time < end)) continue;
    if (part.values.empty()) start = time;
    part.values.push_back(channel.values[i]);
    stamps->push_back(time);
  }
  part.timeline = channel.timeline.uniform() ? Timeline{start, channel.timeline.rate, nullptr}
                                             : Timeline{start, 0.0, std::move(stamps)};
  return part;
}

Recording cut(const Recording& recording, double begin, double end) {
  Recording part = recording;
  part.channels.clear();
  for (const Channel& channel : recording.channels) part.channels.push_back(cut(channel, begin, end));
  part.marks.clear();
  for (std::size_t m = 0; m < recording.marks.size(); ++m) {
    Mark mark = recording.marks[m];
    if (mark.begin >= end || end_of_mark(recording, m) <= begin) continue;
    mark.begin = std::max(mark.begin, begin);
    part.marks.push_back(mark);
  }
  return part;
}

/// Recordings whose power-up has several segments: the middle of one that is not the first or the last.
std::vector<std::string> divisible(const Plan&, const Recordings& recordings) {
  return recordings.size() == 1 && recordings.front().marks.size() > 3 ? std::vector<std::string>{""}
                                                                       : std::vector<std::string>{};
}

/// In the middle of a segment that is drawn; both files have the same clock.
void split(const Plan&, Recordings& recordings, const Happening& what) {
  const Recording whole = recordings.front();
  const auto inner = static_cast<double>(whole.marks.size() - 2);
  const auto m = 1 + std::min(whole.marks.size() - 3, static_cast<std::size_t>(what.random.uniform(0) * inner));
  const double middle = 0.5 * (whole.marks[m].begin + whole.marks[m + 1].begin);
  constexpr double ever = std::numeric_limits<double>::infinity();
  recordings = {cut(whole, -ever, middle), cut(whole, middle, ever)};
}

bool joinable(const Recording& first, const Recording& second) {
  return std::ranges::equal(first.channels, second.channels, {}, &Channel::name, &Channel::name);
}

std::vector<std::string> several(const Plan&, const Recordings& recordings) {
  return recordings.size() > 1 && joinable(recordings[0], recordings[1]) ? std::vector<std::string>{""}
                                                                         : std::vector<std::string>{};
}

/// The second file goes on behind the first one, a minute later on its clock.
void join(const Plan&, Recordings& recordings, const Happening&) {
  Recording& first = recordings[0];
  const Recording& second = recordings[1];
  double last = 0.0, begin = std::numeric_limits<double>::infinity();
  for (const Channel& channel : first.channels)
    if (!channel.values.empty()) last = std::max(last, channel.time(channel.values.size() - 1));
  for (const Channel& channel : second.channels)
    if (!channel.values.empty()) begin = std::min(begin, channel.time(0));
  const double later = last + 60.0 - begin;
  for (std::size_t c = 0; c < first.channels.size(); ++c) {
    Channel& channel = first.channels[c];
    const Channel& next = second.channels[c];
    auto stamps = std::make_shared<std::vector<double>>();
    for (std::size_t i = 0; i < channel.values.size(); ++i) stamps->push_back(channel.time(i));
    for (std::size_t i = 0; i < next.values.size(); ++i) stamps->push_back(next.time(i) + later);
    channel.values.insert(channel.values.end(), next.values.begin(), next.values.end());
    if (!stamps->empty()) channel.timeline = {stamps->front(), 0.0, std::move(stamps)};
  }
  for (Mark mark : second.marks) {
    mark.begin += later;
    mark.end += later;
    first.marks.push_back(mark);
  }
  recordings.erase(recordings.begin() + 1);
}

}  // namespace

std::vector<Departure> of_marks() {
  return {{.name = "marks_late",
           .summary = "each mark but the first is set after its segment has begun",
           .targets = marked,
           .told_by = {"segments_end_in_next", "turn_early", "turn_late", "segment_still_changes",
                       "segments_begin_unsettled", "moves_between_positions", "power_ups_end_in_next",
                       "levels_cut_to_even_turning", "vibration_not_throughout", "tone_not_throughout",
                       "tone_of_another_segment"},
           .unit = "s",
           .covered = covered_delay,
           .record = mark_late},
          {.name = "recording_split",
           .summary = "the test is in two files, divided in the middle of a segment",
           .targets = divisible,
           .told_by = {"segment_duration", "gaps_between_files", "segment_not_recorded", "not_recorded"},
           .record = split},
          {.name = "recordings_joined",
           .summary = "two files of the test are joined to one, with a pause between them",
           .targets = several,
           .told_by = {"gap", "segment_duration", "segment_not_scheduled"},
           .record = join}};
}

}  // namespace tumble::entries
