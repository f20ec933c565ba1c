#include "tumble/rehearsal/rehearse.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <utility>

#include "tumble/rehearsal/made_station.hpp"
#include "tumble/rehearsal/virtual_bench.hpp"
#include "tumble/rehearsal/virtual_stream.hpp"
#include "tumble/station/run_folder.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

namespace fs = std::filesystem;

constexpr int most_repeats = 3;  ///< of one question, after which nobody would try again

/// The station of the run: that of the user, whose run has no folder yet, so that a refused one leaves nothing; or one
/// made for the plan, with its frames beside it.
Station station_of(const Rehearsal& rehearsal) {
  if (rehearsal.station) return *rehearsal.station;
  Station station = station_for(rehearsal.plan);
  if (!rehearsal.resume) make_run_folder(rehearsal.folder, rehearsal.plan, station);
  station.file = (fs::path(rehearsal.folder) / "station.toml").string();
  try {
    write_in_run(rehearsal.folder, std::string(made_frames_name), frames_for(rehearsal.plan));
  } catch (const Error& error) {
    if (!rehearsal.resume) forget_run(rehearsal.folder);
    throw not_begun(error, rehearsal.resume);
  }
  return station;
}

std::unique_ptr<Recorder> store_of_rehearsal(const Rehearsal& rehearsal, Disk& disk) {
  RecorderOptions options;
  options.resume = rehearsal.resume;
  options.commit_bytes = std::size_t{1} << 22;  // it comes faster than a disk synchronises
  try {
    return std::make_unique<Recorder>(rehearsal.folder, disk, options);
  } catch (const Error& error) {
    if (!rehearsal.resume) forget_run(rehearsal.folder);
    throw not_begun(error, rehearsal.resume);
  }
}

std::map<std::string, std::string> units_of(const Rehearsal& rehearsal, const Station& station) {
  if (!rehearsal.units.empty()) return rehearsal.units;
  std::map<std::string, std::string> units;
  const std::string serial = rehearsal.plan.instrument_serial.empty() ? "rehearsed" : rehearsal.plan.instrument_serial;
  for (const StationInstrument& instrument : station.instruments)
    units[instrument.slot] = station.instruments.size() > 1 ? serial + "-" + instrument.slot : serial;
  return units;
}

/// Time goes on only when the disk has kept up, because a rehearsal is faster than any disk, and as `pace` says.
Wires held_back(Wires wires, Recorder& recorder, const std::function<void(double)>& pace) {
  constexpr std::uint64_t ahead = std::uint64_t{1} << 24;  // bytes
  auto wait = [inner = wires.wait, now = wires.now, &recorder, &pace,
               written = std::uint64_t{0}](double until) mutable {
    if (pace) pace(now());
    if (const std::uint64_t bytes = recorder.load().bytes; bytes > written + ahead) {
      recorder.flush();
      written = bytes;
    }
    return inner(until);
  };
  wires.wait = wait;
  return wires;
}

using Answers = std::vector<decltype(RunEvent::what)>;

/// Who answers where nobody is there: with the standard answer, and "stop" where one segment fails again and again.
void answer_by_standard(RunCompany& company, Answers& answers) {
  company.ask = [&answers, asked = std::map<std::string, int>{}](const Prompt& prompt) mutable {
    const bool again = !prompt.failed_segment.empty() && ++asked[prompt.failed_segment] > most_repeats;
    answers.push_back(PromptAnswer{prompt.id, again ? "stop" : prompt.standard, "rehearsed"});
  };
  company.orders = [&answers] { return std::exchange(answers, {}); };
}

std::unique_ptr<LiveEstimates> live_estimates_of(const Rehearsal& rehearsal, const Course& course) {
  if (course.until.empty()) return nullptr;
  auto estimates = std::make_unique<LiveEstimates>(estimator_of(rehearsal.plan), LiveEstimatesOptions{.beside = false});
  if (rehearsal.resume) estimates->load(rehearsal.folder);
  return estimates;
}

/// Carries the plan out on the virtual bench, from where the run stands.
RunEnd carried_out(const Rehearsal& rehearsal, const Station& station, const StationParts& parts,
                   const std::shared_ptr<const Course>& course, VirtualBench& bench, RunCompany company, Disk& disk) {
  const auto rows = rehearsal.resume ? journal_of(rehearsal.folder) : std::vector<RunRow>{};
  const double before = rehearsal.resume ? end_of(rehearsal.folder) + 1.0 : 0.0;
  if (rehearsal.resume && rehearsal.desk) remember_run(*rehearsal.desk, rehearsal.folder);
  if (std::ranges::find(rows, RunRow::Kind::power_up, &RunRow::kind) != rows.end()) {
    bench.put(mounted_for(rehearsal.plan, station));
    bench.power(true);
  }
  const auto estimates = live_estimates_of(rehearsal, *course);
  if (estimates) company.estimates = estimates.get();
  const std::unique_ptr<Recorder> store = store_of_rehearsal(rehearsal, disk);
  Recorder& recorder = *store;
  note_facts(recorder, rehearsal.plan, *course, "rehearsed");
  note_played(recorder, "rehearsed", rehearsal.seed);
  if (rehearsal.desk)
    company = at_desk(*rehearsal.desk, rehearsal.folder,
                      facts_of(rehearsal.plan.title, *course, "rehearsed", "rehearsed"), rehearsal.speed, company);
  const Wires wires = held_back(shifted(bench.wires(), before), recorder, rehearsal.pace);
  return carry_out(rehearsal.resume ? resume_state(course, rows) : start_state(course), parts, wires, recorder,
                   company);
}

}  // namespace

Rehearsed rehearse(const Rehearsal& rehearsal, const Progress& progress) {
  Station station = station_of(rehearsal);
  const StationParts parts = parts_of(station);
  const auto units = units_of(rehearsal, station);
  if (auto problems = check_station(rehearsal.plan, station, {.units = units, .rehearsed = true}); !problems.empty()) {
    if (!rehearsal.station && !rehearsal.resume) fs::remove_all(rehearsal.folder);
    throw Error(Error::Kind::bad_input, std::move(problems));
  }
  const auto course = course_of(rehearsal.plan, station, units);
  VirtualBench bench(rehearsal.plan, station, parts, rehearsal.seed,
                     timed_faults(rehearsal.faults, rehearsal.seed, random_faults_until(rehearsal.plan)));
  if (rehearsal.station && !rehearsal.resume) make_run_folder(rehearsal.folder, rehearsal.plan, station);

  RunCompany company = rehearsal.company;
  Answers answers;
  if (!company.ask) answer_by_standard(company, answers);
  company.by_hand = [&](const std::map<std::string, double>& axes) { bench.put(axes); };

  Rehearsed rehearsed;
  Disk disk;
  rehearsed.end =
      carried_out(rehearsal, station, parts, course, bench, company, rehearsal.disk ? *rehearsal.disk : disk);
  rehearsed.simulated = bench.now();
  rehearsed.axes = bench.readings();
  try {
    rehearsed.recordings = seal(rehearsal.folder, disk, rehearsal.recording, progress);
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_data || rehearsed.end.ending == RunEnding::complete)
      throw;  // it ended too early
  }
  return rehearsed;
}

}  // namespace tumble
