#include "tumble/recorder/recorder_read.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tumble/core/instant.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/recorded_findings.hpp"
#include "tumble/recorder/live_store/read_recordings.hpp"
#include "tumble/recorder/live_store/run_reader.hpp"
#include "tumble/recorder/live_store/slot_reader.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

namespace live_store {

namespace {

/// Facts that belong to the file, and not to what it holds.
bool is_of_the_file(const std::string& fact, const StoreContent& content) {
  return fact == "target" || std::ranges::any_of(content.sealed, [&](const auto& sealed) {
           return fact == std::string(sealed_fact) + (sealed.first.empty() ? "" : "." + sealed.first);
         });
}

Recording recording_of(SlotReader& slot, const RunReader& run, const StoreContent& content, const std::string& name) {
  Recording recording;
  recording.instrument = slot.instrument();
  recording.channels = slot.channels();
  recording.marks = run.marks();
  for (const auto& [fact, value] : content.facts)
    if (!is_of_the_file(fact, content)) recording.meta[fact] = value;
  if (!run.started().empty()) recording.meta[clock_start] = run.started();
  if (!name.empty()) recording.meta["slot"] = name;
  recording.findings = run.findings(content, name);
  for (Finding& finding : slot.findings()) recording.findings.push_back(std::move(finding));
  if (!recording.findings.empty())
    recording.meta[std::string(recorded_findings_key)] = text_of_findings(recording.findings);
  return recording;
}

}  // namespace

StoreReading::StoreReading(const StoreFile& store, const std::string& path, const Progress& progress)
    : store_(store), content_(describe(store)), run_(content_) {
  const auto names = slots_of(content_);
  std::vector<SlotReader> slots;
  for (const std::string& name : names) slots.emplace_back(content_, name);
  report(progress, 0.0, "reading the live store");
  visit(store_, content_, [&](const StoreItem& item) {
    run_.look(item);
    for (SlotReader& slot : slots) slot.look(item);
  });
  run_.finish();
  for (std::size_t i = 0; i < slots.size(); ++i) {
    slots[i].settle();
    if (!slots[i].has_samples()) continue;
    names_.push_back(names[i]);
    slots_.push_back(std::move(slots[i]));
  }
  if (slots_.empty())
    throw Error(Error::Kind::bad_data, say("'{}' holds {} items, but no sample", path, content_.items));
  report(progress, 0.3, "reading the live store");
}

Recording StoreReading::next_of(std::size_t slot) { return recording_of(slots_[slot], run_, content_, names_[slot]); }

void StoreReading::stream(std::size_t slot, std::size_t samples, const BlockSink& sink) {
  SlotReader& reader = slots_[slot];
  const bool at_once = reader.streams();
  reader.rewind();
  bool first = true;
  visit(store_, content_, [&](const StoreItem& item) {
    reader.take(item);
    if (!at_once || reader.waiting() < samples) return;
    sink(next_of(slot));
    first = false;
  });
  if (first || reader.waiting() > 0) sink(next_of(slot));
}

std::vector<StoreRecording> StoreReading::recordings(const Progress& progress) {
  visit(store_, content_, [&](const StoreItem& item) {
    for (SlotReader& slot : slots_) slot.take(item);
  });
  report(progress, 0.9, "reading the live store");
  std::vector<StoreRecording> recordings;
  for (std::size_t i = 0; i < slots_.size(); ++i) recordings.push_back({names_[i], next_of(i)});
  return recordings;
}

}  // namespace live_store

namespace {

StoreContent visit_some(const std::string& run, const std::function<void(const StoreItem&)>& visit, bool events_alone) {
  const std::string path = live_store::path_of_store(run);
  Disk disk;
  const live_store::StoreFile store = live_store::open_store(path, disk);
  try {
    StoreContent content = live_store::describe(store);
    live_store::visit(store, content, visit, events_alone);
    return content;
  } catch (const live_store::Refusal& refusal) {
    live_store::refuse_to_read(path, refusal);
  }
}

}  // namespace

StoreContent visit_store(const std::string& run, const std::function<void(const StoreItem&)>& visit) {
  return visit_some(run, visit, false);
}

StoreContent visit_events(const std::string& run, const std::function<void(const StoreItem&)>& visit) {
  return visit_some(run, visit, true);
}

std::uint64_t write_raw(const std::string& run, const std::string& file) {
  const std::string path = live_store::path_of_store(run);
  Disk disk;
  const live_store::StoreFile store = live_store::open_store(path, disk);
  try {
    StoreContent content = live_store::describe(store);
    for (const StoreLink& link : content.links)
      if (link.name != content.links.front().name)
        throw Error(Error::Kind::bad_data, say("'{}' holds the bytes of several links ({}, {}): a file of raw "
                                               "bytes is that of one",
                                               path, Name{content.links.front().name}, Name{link.name}));
    AtomicFile output(file);
    std::uint64_t written = 0;
    live_store::visit(store, content, [&](const StoreItem& item) {
      if (item.kind != StoreItem::Kind::raw || item.direction != StoreDirection::received) return;
      output.write(item.bytes);
      written += item.bytes.size();
    });
    output.commit();
    return written;
  } catch (const live_store::Refusal& refusal) {
    live_store::refuse_to_read(path, refusal);
  }
}

std::vector<StoreRecording> read_store(const std::string& run, const Progress& progress) {
  const std::string path = live_store::path_of_store(run);
  Disk disk;
  const live_store::StoreFile store = live_store::open_store(path, disk);
  try {
    return live_store::StoreReading(store, path, progress).recordings(progress);
  } catch (const live_store::Refusal& refusal) {
    live_store::refuse_to_read(path, refusal);
  }
}

}  // namespace tumble
