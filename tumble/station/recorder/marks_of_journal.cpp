#include "tumble/station/recorder/marks_of_journal.hpp"

#include <algorithm>

namespace tumble::recorder {

void JournalReader::add(const JournalRow& row) {
  Segment& segment = segments_[{row.run, row.index, row.segment}];
  Attempt& attempt = segment.attempts[row.attempt];
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

}  // namespace tumble::recorder
