#include "tumble/station/recorder_read.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "tumble/core/instant.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/station/recorder/read_recordings.hpp"
#include "tumble/station/recorder/run_reader.hpp"
#include "tumble/station/recorder/slot_reader.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

namespace recorder {

namespace {

/// The slots that have streams; without any, one without a name.
std::vector<std::string> slots_of(const StoreContent& content) {
  std::set<std::string> slots;
  for (const StoreStream& stream : content.streams)
    if (!stream.slot.empty()) slots.insert(stream.slot);
  if (slots.empty()) slots.insert("");
  return {slots.begin(), slots.end()};
}

/// Facts that belong to the file, and not to what it holds.
bool is_of_the_file(const std::string& fact) { return fact == "target" || fact.starts_with("sealed"); }

Recording recording_of(SlotReader& slot, const RunReader& run, const StoreContent& content, const std::string& name) {
  Recording recording;
  recording.instrument = slot.instrument();
  recording.channels = slot.channels();
  recording.marks = run.marks();
  for (const auto& [fact, value] : content.facts)
    if (!is_of_the_file(fact)) recording.meta[fact] = value;
  if (!run.started().empty()) recording.meta[clock_start] = run.started();
  if (!name.empty()) recording.meta["slot"] = name;
  recording.findings = run.findings(content, name);
  for (Finding& finding : slot.findings()) recording.findings.push_back(std::move(finding));
  return recording;
}

}  // namespace

std::vector<StoreRecording> read_recordings(const StoreFile& store, const std::string& path, const Progress& progress) {
  StoreContent content = describe(store);
  RunReader run(content);
  const auto names = slots_of(content);
  std::vector<SlotReader> slots;
  for (const std::string& name : names) slots.emplace_back(content, name);
  report(progress, 0.0, "reading the live store");
  visit(store, content, [&](const StoreItem& item) {
    run.look(item);
    for (SlotReader& slot : slots) slot.look(item);
  });
  run.finish();
  for (SlotReader& slot : slots) slot.settle();
  report(progress, 0.3, "reading the live store");
  visit(store, content, [&](const StoreItem& item) {
    for (SlotReader& slot : slots) slot.take(item);
  });
  std::vector<StoreRecording> recordings;
  for (std::size_t i = 0; i < slots.size(); ++i)
    if (Recording recording = recording_of(slots[i], run, content, names[i]); !recording.channels.empty())
      recordings.push_back({names[i], std::move(recording)});
  if (recordings.empty())
    throw Error(Error::Kind::bad_data, fmt::format("'{}' holds {} items, but no sample", path, content.items));
  return recordings;
}

}  // namespace recorder

StoreContent visit_store(const std::string& run, const std::function<void(const StoreItem&)>& visit) {
  const std::string path = recorder::path_of_store(run);
  Disk disk;
  const recorder::StoreFile store = recorder::open_store(path, disk);
  try {
    StoreContent content = recorder::describe(store);
    recorder::visit(store, content, visit);
    return content;
  } catch (const recorder::Refusal& refusal) {
    recorder::refuse_to_read(path, refusal);
  }
}

std::uint64_t write_raw(const std::string& run, const std::string& file) {
  const std::string path = recorder::path_of_store(run);
  Disk disk;
  const recorder::StoreFile store = recorder::open_store(path, disk);
  try {
    StoreContent content = recorder::describe(store);
    for (const StoreLink& link : content.links)
      if (link.name != content.links.front().name)
        throw Error(Error::Kind::bad_data, fmt::format("'{}' holds the bytes of several links ({}, {}): a file of raw "
                                                       "bytes is that of one",
                                                       path, content.links.front().name, link.name));
    AtomicFile output(file);
    std::uint64_t written = 0;
    recorder::visit(store, content, [&](const StoreItem& item) {
      if (item.kind != StoreItem::Kind::raw || item.direction != StoreDirection::received) return;
      output.write(item.bytes);
      written += item.bytes.size();
    });
    output.commit();
    return written;
  } catch (const recorder::Refusal& refusal) {
    recorder::refuse_to_read(path, refusal);
  }
}

std::vector<StoreRecording> read_store(const std::string& run, const Progress& progress) {
  const std::string path = recorder::path_of_store(run);
  Disk disk;
  const recorder::StoreFile store = recorder::open_store(path, disk);
  try {
    return recorder::read_recordings(store, path, progress);
  } catch (const recorder::Refusal& refusal) {
    recorder::refuse_to_read(path, refusal);
  }
}

}  // namespace tumble
