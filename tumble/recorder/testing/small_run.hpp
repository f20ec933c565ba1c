#pragma once

#include <map>
#include <string>
#include <vector>

#include "tumble/recorder/recorder.hpp"
#include "tumble/recorder/recorder_read.hpp"

namespace tumble {

/// For tests: what was given to a recorder, by sequence number.
struct GivenItem {
  StoreItem::Kind kind = StoreItem::Kind::raw;
  double time = 0.0;
  std::string bytes;           ///< raw bytes, or the text of an event, or the segment of a row of the journal
  std::vector<double> values;  ///< of a sample

  friend bool operator==(const GivenItem&, const GivenItem&) = default;
};
using GivenItems = std::map<std::uint64_t, GivenItem>;

/// For tests: an item of a store in the same form.
inline GivenItem given(const StoreItem& item) {
  GivenItem result{item.kind, item.time, std::string(item.bytes), {}};
  result.values.assign(item.sample.values.begin(), item.sample.values.end());
  if (item.event) result.bytes = item.event->text;
  if (item.journal) result.bytes = item.journal->label;
  return result;
}

/// For tests: the items of a store.
inline GivenItems items_of_store(const std::string& folder) {
  GivenItems items;
  visit_store(folder, [&](const StoreItem& item) { items.emplace(item.sequence, given(item)); });
  return items;
}

/// For tests: step `k` of a run, the same for every run: raw bytes, a sample of three channels, and now and then an
/// event and a row of the journal.
inline void add_step(Recorder& recorder, int k, GivenItems& items) {
  const double time = 0.01 * k;
  const auto note = [&](std::uint64_t sequence, GivenItem item) {
    if (sequence != 0) items.emplace(sequence, std::move(item));
  };
  const std::string bytes(static_cast<std::size_t>(20 + 37 * k % 90), static_cast<char>('a' + k % 26));
  note(recorder.raw(0, StoreDirection::received, time, bytes), {StoreItem::Kind::raw, time, bytes, {}});
  const std::vector<double> values{1.0 / (k + 3), -0.1 * k, 1e-9 * k * k};
  const StoreSample sample{time, 0.001 * k, static_cast<std::uint64_t>(k), values};
  note(recorder.sample(0, sample), {StoreItem::Kind::sample, time, {}, values});
  if (k % 7 == 3)
    note(recorder.event({time, EventKind::notice, "test", say("event {}", k), {}}),
         {StoreItem::Kind::event, time, "event " + std::to_string(k), {}});
  if (k % 11 == 5)
    note(recorder.journal(time, {.label = "position " + std::to_string(k)}),
         {StoreItem::Kind::journal, time, "position " + std::to_string(k), {}});
}

/// For tests: one link and one stream of three channels.
inline void begin_run(Recorder& recorder) {
  recorder.add_link({"tcp:127.0.0.1:9", {}, {}, {}, {}});
  const auto channel = [](const char* name, const char* unit) { return FrameChannel{name, Unit::parse(unit), false}; };
  recorder.add_stream(
      {"test", {}, {channel("gyro", "deg/h"), channel("acc", "g"), channel("temperature", "degC")}, 100.0, 0});
}

}  // namespace tumble
