#include "tumble/station/conduct/record_words.hpp"

namespace tumble::conduct {

RunRow row_of(const RecordSwitch& record, double time) {
  RunRow row;
  row.kind = record.on ? RunRow::Kind::records : RunRow::Kind::pauses;
  row.time = time;
  row.segment = record.segment;
  row.run = record.run;
  row.attempt = record.attempt;
  row.label = record.label;
  return row;
}

Sentence words_of(const RecordSwitch& record, std::size_t segments) {
  const Sentence attempt = record.attempt > 1 ? say(", attempt {}", record.attempt) : Sentence();
  return say("segment {} of {} '{}'{}", record.segment + 1, segments, record.label, attempt);
}

}  // namespace tumble::conduct
