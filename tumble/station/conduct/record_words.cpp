#include "tumble/station/conduct/record_words.hpp"

#include <fmt/format.h>

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

std::string words_of(const RecordSwitch& record, std::size_t segments) {
  return fmt::format("segment {} of {} '{}'{}", record.segment + 1, segments, record.label,
                     record.attempt > 1 ? fmt::format(", attempt {}", record.attempt) : "");
}

}  // namespace tumble::conduct
