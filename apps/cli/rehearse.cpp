#include "tumble/rehearsal/rehearse.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <thread>

#include "archive_options.hpp"
#include "run_display.hpp"
#include "tumble/desk/archived_run.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/tasks/departed.hpp"
#include "tumble/units/error.hpp"
#include "verbs.hpp"
#include "wall_clock.hpp"

namespace tumble::cli {
namespace {

struct RehearseArguments {
  std::string plan, output, station, faults, speed;
  std::uint64_t seed = 1;
  std::vector<std::string> sets, departures;
  ArchiveOptions archive;
};

/// "1 h 15 min", "12 min 3 s"
std::string duration(double seconds) {
  const long whole = std::lround(seconds);
  if (whole >= an_hour) return fmt::format("{} h {} min", whole / an_hour, whole % an_hour / 60);
  return whole >= 60 ? fmt::format("{} min {} s", whole / 60, whole % 60) : fmt::format("{} s", whole);
}

Rehearsal rehearsal_of(const RehearseArguments& arguments) {
  Rehearsal rehearsal;
  rehearsal.recording =
      arguments.output.empty() ? std::filesystem::path(arguments.plan).stem().string() + ".h5" : arguments.output;
  check_output("-o", rehearsal.recording, {arguments.plan}, {".h5"});
  rehearsal.folder = std::filesystem::path(rehearsal.recording).replace_extension().string();
  rehearsal.plan = tumble::load_plan(arguments.plan, parse_sets(arguments.sets));
  rehearsal.seed = arguments.seed;
  if (!arguments.station.empty()) rehearsal.station = load_station(arguments.station);
  if (!arguments.faults.empty()) rehearsal.faults = read_faults(read_text_file(arguments.faults), arguments.faults);
  if (!arguments.speed.empty()) rehearsal.speed = speed_of(arguments.speed);
  return rehearsal;
}

/// The plan as it is carried out with the departures; absent: there are no departures.
std::optional<DepartedPlan> depart_from_plan(const RehearseArguments& arguments, Plan& plan) {
  if (arguments.departures.empty()) return std::nullopt;
  auto departed = departed_plan(plan, wanted_departures(arguments.departures), arguments.seed);
  plan = departed.carried_out;
  return departed;
}

/// What departures change in the recordings of the rehearsal.
void depart_recordings(const DepartedPlan& departed, const std::vector<SealedRecording>& sealed) {
  for (const SealedRecording& one : sealed) {
    Recordings recordings{read_recording(one.path, {}, {})};
    depart(departed, recordings);
    if (recordings.size() != 1)
      throw Error(Error::Kind::bad_input,
                  "the departure divides the recording, which a rehearsal cannot do: simulate it");
    write_recording(recordings.front(), one.path);
  }
}

int run(const RehearseArguments& arguments, const Terminal& terminal) {
  std::optional<Archive> archive;  // a rehearsal is archived only where --archive asks for it
  if (!arguments.archive.address.empty()) archive = optional_archive(arguments.archive);
  Rehearsal rehearsal = rehearsal_of(arguments);
  const auto departed = depart_from_plan(arguments, rehearsal.plan);
  if (!terminal.quiet)
    rehearsal.company.note = [&terminal](const Note& note, double time) {
      print(note_line(note, time, terminal.language));
    };

  const double begin = wall_time();
  if (rehearsal.speed > 0.0)
    rehearsal.pace = [begin, speed = rehearsal.speed](double simulated) {
      const double early = simulated / speed - (wall_time() - begin);
      if (early > 0.0) std::this_thread::sleep_for(std::chrono::duration<double>(early));
    };
  RunDesk desk;
  rehearsal.desk = &desk;
  Rehearsed rehearsed;
  {
    ProgressLine line(terminal);
    rehearsal.company.show = [progress = line.progress()](const RunView& view) {
      if (!progress) return;
      const double all = view.time + view.left;
      progress(all > 0.0 ? view.time / all : 0.0, fmt::format("{} {}", name(view.phase), view.label));
    };
    rehearsal.company.show_every = rehearsal.speed > 0.0 ? 0.5 * rehearsal.speed : 30.0;
    rehearsed = rehearse(rehearsal, {});
  }
  print_said(terminal, say("\n{}: {}\n{} rehearsed in {:.1f} s\n", Name{arguments.plan},
                           said_ending(rehearsed.end.ending, rehearsed.end.text), Name{duration(rehearsed.simulated)},
                           wall_time() - begin));
  if (departed) depart_recordings(*departed, rehearsed.recordings);
  for (const SealedRecording& sealed : rehearsed.recordings) note(terminal, say("wrote {}", Name{sealed.path}));
  if (archive && !rehearsed.recordings.empty())
    note_deposited(terminal, put_in(*archive, deposit_of_run(rehearsal.folder), act_of(arguments.archive)));
  return rehearsed.end.ending == RunEnding::complete ? 0 : 3;
}

}  // namespace

Verb rehearse_verb() {
  auto arguments = std::make_shared<RehearseArguments>();
  return {"rehearse",
          "Carry out a plan on a virtual rig, over the protocols of the station, as fast as it goes",
          {{"PLAN", &arguments->plan, "plan file (.toml) with [rig], [[schedule]] and [truth]", true},
           {"-o,--output", &arguments->output,
            "recording to write, .h5 (default: <plan>.h5 in this folder); the run is kept in a folder of that name"},
           {"--station", &arguments->station, "station file; without it one is made from the rig of the plan"},
           {"--faults", &arguments->faults, "file of faults that happen during the run"},
           departure_argument(arguments->departures),
           {"--seed", &arguments->seed, "seed of the random numbers"},
           archive_argument(arguments->archive),
           by_argument(arguments->archive),
           {"--speed", &arguments->speed, "seconds of the rig in each second (default: as fast as it goes)"},
           sets_argument(arguments->sets, "value that replaces that of the plan: truth.KEY, rig.KEY; repeatable")},
          "Examples:\n"
          "  tumble rehearse north_finding.toml -o run.h5\n"
          "  tumble rehearse north_finding.toml -o run.h5 --station bench.toml --faults faults.toml --seed 3\n",
          [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
