#include "tumble/recorder/live_store/marks_of_journal.hpp"

#include <algorithm>

namespace tumble::live_store {

void JournalReader::add(double time, const RunRow& row) {
  using enum RunRow::Kind;
  if (row.kind != segment_begins && row.kind != segment_ends && row.kind != records && row.kind != pauses) return;
  const Key key{row.run, row.segment, row.label};
  Segment& segment = segments_[key];
  Attempt& attempt = segment.attempts[row.attempt];
  recording_.reset();
  if (row.kind == segment_begins) attempt = {};
  if (row.kind == records) {
    recording_ = {key, row.attempt};
    if (!attempt.recording) attempt.spans.emplace_back(time, time);
    attempt.recording = true;
  }
  if (row.kind == pauses || row.kind == segment_ends) {
    if (attempt.recording) attempt.spans.back().second = time;
    attempt.recording = false;
  }
  if (row.kind == segment_ends && row.ending == RunRow::Ending::complete) segment.counted = attempt.spans;
}

std::vector<Mark> JournalReader::marks() const {
  std::vector<Mark> marks;
  for (const auto& [key, segment] : segments_)
    for (const auto& [begin, end] : segment.counted) marks.push_back({std::get<2>(key), begin, std::get<0>(key), end});
  std::ranges::stable_sort(marks, {}, &Mark::begin);
  return marks;
}

std::vector<Mark> JournalReader::marks_so_far(double now) const {
  if (!recording_) return marks();
  JournalReader so_far = *this;
  Segment& segment = so_far.segments_.at(recording_->first);
  auto& spans = segment.attempts.at(recording_->second).spans;
  spans.back().second = now;
  segment.counted = spans;
  return so_far.marks();
}

}  // namespace tumble::live_store
