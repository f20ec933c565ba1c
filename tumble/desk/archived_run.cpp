#include "tumble/desk/archived_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "tumble/core/instant.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/formats/confinement.hpp"
#include "tumble/recorder/recorder_read.hpp"
#include "tumble/station/station_file.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"
#include "tumble/version.hpp"

namespace tumble {
namespace {

namespace fs = std::filesystem;

using Facts = std::map<std::string, std::string>;

std::string fact(const Facts& facts, const std::string& name) {
  const auto found = facts.find(name);
  return found == facts.end() ? std::string() : found->second;
}

/// UTC of a time of the store, where its clock was compared with that of the wall; else seconds since the begin.
std::string when_of(double time, double clock_time, const std::string& clock_text) {
  constexpr double nanosecond = 1e9;
  const auto wall = parse_iso_time(clock_text);
  if (!wall) return fmt::format("{:.3f} s after the begin", time);
  return iso_second(*wall + static_cast<std::int64_t>(std::llround((time - clock_time) * nanosecond)));
}

/// Events, steps of the journal and the end of a run, in their order.
struct Story {
  struct Step {
    double time;
    ArchivedEvent event;
  };
  std::vector<Step> steps;
  Facts facts, units, sealed;  ///< units and sealed: by slot
  double clock_time = 0.0, last = 0.0;
  std::string clock_text, ending;
};

void take_event(const StoreEvent& event, Story& story) {
  if (event.kind == EventKind::clock && story.clock_text.empty())
    story.clock_text = event.text, story.clock_time = event.time;
  if (event.kind == EventKind::end) story.ending = event.text;
  const std::string who = event.who.empty() ? "station" : event.who;
  story.steps.push_back({event.time, {{}, who, std::string(name(event.kind)), event.text, {}, event.json}});
}

/// What a row says of an attempt; empty: it is about none.
const char* step_of(RunRow::Kind kind) {
  switch (kind) {
    case RunRow::Kind::segment_begins:
      return "begins";
    case RunRow::Kind::records:
      return "records";
    case RunRow::Kind::pauses:
      return "pauses";
    case RunRow::Kind::segment_ends:
      return "ends";
    default:
      return "";
  }
}

void take_row(double time, const RunRow& row, Story& story) {
  if (const std::string step = step_of(row.kind); !step.empty()) {
    const bool finished = row.kind == RunRow::Kind::segment_ends && row.ending == RunRow::Ending::complete;
    story.steps.push_back({time,
                           {{},
                            "station",
                            "segment",
                            fmt::format("{}, power-up {}, attempt {}: {}{}", row.label, row.run, row.attempt, step,
                                        finished ? ", finished" : ""),
                            row.reason,
                            {}}});
  }
  if (row.kind != RunRow::Kind::records && row.kind != RunRow::Kind::pauses)
    story.steps.push_back({time, {{}, "station", "journal", row.label, {}, text_of(row)}});
}

Story story_of(const std::string& run) {
  Story story;
  const auto content = visit_store(run, [&](const StoreItem& item) {
    story.last = std::max(story.last, item.time);
    if (item.event) take_event(*item.event, story);
    if (item.journal) take_row(item.time, *item.journal, story);
  });
  story.facts = content.facts, story.units = content.units, story.sealed = content.sealed;
  for (auto& step : story.steps) step.event.when = when_of(step.time, story.clock_time, story.clock_text);
  return story;
}

/// The sealed recording of a slot, with the bytes that it had when it was sealed.
std::string sealed_file(const std::string& run, const Facts& facts, const std::string& slot,
                        const std::string& sha256) {
  const std::string target = fact(facts, "target"), tail = slot.empty() ? "" : "-" + slot;
  std::vector<fs::path> places{fs::path(run) / ("recording" + tail + ".h5")};
  for (const fs::path& from :
       {fs::path(target), fs::path(run) / target, fs::path(run).replace_extension(".h5"), fs::path(run) += ".h5"})
    if (!target.empty() || from.has_stem())
      places.push_back(from.parent_path() / (from.stem().string() + tail + from.extension().string()));
  for (const auto& place : places) {
    std::error_code absent;
    if (may_be_named(place) && fs::is_regular_file(place, absent) && sha256_of_file(place.string()) == sha256)
      return place.string();
  }
  throw Error(Error::Kind::bad_file,
              say("the recording of the run '{0}' that was sealed is not there any more, or has changed; `tumble "
                  "seal {0}` makes it again",
                  Name{run}));
}

/// Equipment in the text of a station, whose other files need not be there any more.
void read_equipment(const std::string& text, const std::string& file, RunDeposit& deposit) {
  try {
    for (const auto& one : read_station(text, file).equipment) {
      EquipmentDeposit equipment;
      equipment.name = one.name, equipment.serial = one.serial;
      equipment.certificate = one.certificate, equipment.due = one.due;
      deposit.equipment.push_back(std::move(equipment));
    }
  } catch (const Error&) {
    return;  // a declaration beside the station is not there any more: the text itself is archived
  }
}

RunDeposit run_of(const Story& story) {
  RunDeposit run;
  run.title = fact(story.facts, "title");
  run.plan_sha256 = fact(story.facts, "plan_sha256"), run.station_sha256 = fact(story.facts, "station_sha256");
  run.station = fact(story.facts, "station"), run.who = fact(story.facts, "operator");
  run.program_version = version;
  if (!story.clock_text.empty()) {
    run.started = when_of(0.0, story.clock_time, story.clock_text);
    run.ended = when_of(story.last, story.clock_time, story.clock_text);
  }
  run.ending = story.ending.empty() ? "interrupted" : story.ending;
  for (const auto& step : story.steps) run.events.push_back(step.event);
  return run;
}

/// The sealed recordings, each with the slot of its unit.
std::vector<FileDeposit> recordings_of(const std::string& run, const Story& story, std::string& identity) {
  std::vector<FileDeposit> recordings;
  for (const auto& [slot, sha256] : story.sealed) {
    const std::string path = sealed_file(run, story.facts, slot, sha256);
    identity += sha256;
    recordings.push_back({.path = path, .name = fs::path(path).filename().string(), .role = "recording", .slot = slot});
  }
  if (recordings.empty())
    throw Error(Error::Kind::bad_file, say("the run '{0}' is not sealed: `tumble seal {0}`", Name{run}));
  return recordings;
}

}  // namespace

bool is_run_folder(const std::string& folder) { return fs::exists(fs::path(folder) / live_store_name); }

Deposit deposit_of_run(const std::string& run_folder) {
  const fs::path normal = fs::path(run_folder).lexically_normal();
  const std::string folder = (normal.has_filename() ? normal : normal.parent_path()).string();
  const Story story = story_of(folder);
  RunDeposit run = run_of(story);
  std::string identity = run.plan_sha256 + run.station_sha256 + run.ending + fmt::format("{}", story.last);
  const auto recordings = recordings_of(folder, story, identity);
  run.id = first_digits(sha256_of(identity), 16);
  const std::string plan = (fs::path(folder) / "plan.toml").string();
  const std::string station = (fs::path(folder) / "station.toml").string();
  const std::string model = fs::exists(plan) ? load_plan(plan, {}).instrument_model : "";
  for (const auto& [slot, serial] : story.units)
    run.units.push_back({slot, {model.empty() ? "unknown" : model, serial}});
  Deposit deposit;
  for (FileDeposit recording : recordings) {
    recording.run = run.id;
    for (const auto& [slot, unit] : run.units)
      if (slot == recording.slot || run.units.size() == 1) recording.unit = unit, recording.slot = slot;
    deposit.files.push_back(recording);
  }
  for (const auto& path : {plan, station})
    if (fs::exists(path))
      deposit.files.push_back({.path = path,
                               .name = fs::path(path).filename().string(),
                               .role = fs::path(path).stem().string(),
                               .run = run.id});
  const std::string original = fact(story.facts, "station_file");
  if (fs::exists(station)) read_equipment(read_text_file(station), original.empty() ? station : original, run);
  deposit.runs.push_back(std::move(run));
  return deposit;
}

}  // namespace tumble
