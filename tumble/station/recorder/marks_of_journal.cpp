#include "tumble/station/recorder/marks_of_journal.hpp"

#include <algorithm>

namespace tumble::recorder {

void JournalReader::add(const JournalRow& row) {
  const Key key{row.run, row.index, row.segment};
  Segment& segment = segments_[key];
  Attempt& attempt = segment.attempts[row.attempt];
  recording_.reset();
  if (row.step == JournalRow::Step::records) recording_ = {key, row.attempt};
  switch (row.step) {
    case JournalRow::Step::begins:
      attempt = {};
      break;
    case JournalRow::Step::records:
      if (!attempt.recording) attempt.spans.emplace_back(row.time, row.time);
      attempt.recording = true;
      break;
    case JournalRow::Step::pauses:
    case JournalRow::Step::ends:
      if (attempt.recording) attempt.spans.back().second = row.time;
      attempt.recording = false;
      break;
  }
  if (row.step == JournalRow::Step::ends && row.finished) segment.counted = attempt.spans;
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

}  // namespace tumble::recorder
