#include "tumble/desk/run_plan.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <utility>

#include "tumble/recorder/disk.hpp"
#include "tumble/station/guard.hpp"
#include "tumble/station/lease.hpp"
#include "tumble/station/link_wires.hpp"
#include "tumble/station/run_folder.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr double longest_commit = 5.0;  ///< [s of the wall] of a disk that moves the rig by its rows

/// The folder of a takeover: a run may be taken over more than once.
std::string takeover_folder_in(const std::string& run) {
  std::string folder = run + "/takeover";
  for (int n = 2; std::filesystem::exists(folder); ++n) folder = fmt::format("{}/takeover-{}", run, n);
  return folder;
}

constexpr double guard_patience =
    15.0;  ///< [s] without a look at the rig: a busy computer, or a short stop, takes less

/// The process that stops the rig where this one cannot.
std::unique_ptr<RigGuard> guard_of(const PlannedRunAtStation& run, const Station& station, const StationParts& parts,
                                   LinkWires& links) {
  std::vector<int> descriptors;
  for (std::size_t wire = 0; wire < station.devices.size(); ++wire) descriptors.push_back(links.descriptor(wire));
  auto guard =
      std::make_unique<RigGuard>(run.folder, guard_orders_of(station, parts, run.speed), descriptors, guard_patience);
  links.tell_changes([guard = guard.get(), devices = station.devices.size()](std::size_t wire, int descriptor) {
    if (wire < devices) guard->link_changed(wire, descriptor);
  });
  return guard;
}

/// The guards of runs that have ended without a word have sent the first of their commands, and are not needed any
/// more.
void relieve_guards(const PlannedRunAtStation& run, const Lease& lease) {
  for (const LeaseHolder& left : lease.left_behind()) relieve_guard(left.run);
  if (run.resume) relieve_guard(run.folder);
}

/// A run that was killed may have left the rig in motion: the safe list is carried out before anything else.
void make_safe(const std::shared_ptr<const Course>& course, const StationParts& parts, const Wires& wires,
               const std::string& run, double speed, RigGuard& guard) {
  const std::string folder = takeover_folder_in(run);
  make_run_folder(folder, {}, {});
  guard.arm();
  Disk disk;
  Recorder recorder(folder, disk);
  RunCompany company;
  company.longest_commit = longest_commit * std::max(1.0, speed);
  company.looked = [&guard] { return guard.looked(); };
  company.orders = [] { return std::vector<decltype(RunEvent::what)>{RunOrder{RunOrder::Kind::stop, "takeover"}}; };
  const RunEnd end = carry_out(start_state(course), parts, wires, recorder, company);
  if (end.ending == RunEnding::faulted)
    throw Error(Error::Kind::bad_file,
                say("a run before this one was killed, and the rig cannot be brought to its safe state: {}", end.text));
  guard.disarm();  // a long recording is read before the run goes on
}

/// The estimate so far, where a stopping rule or a person wants it.
std::unique_ptr<LiveEstimates> estimates_of(const PlannedRunAtStation& run, const Course& course) {
  constexpr std::size_t most_for_people = std::size_t{1} << 27;  // bytes of samples
  if (course.until.empty() && !run.show_estimates) return nullptr;
  LiveEstimatesOptions options;
  options.most_bytes = course.until.empty() ? most_for_people : 0;
  auto estimates = std::make_unique<LiveEstimates>(estimator_of(run.plan), options);
  if (run.resume) estimates->load(run.folder);
  return estimates;
}

/// Other programs need their time however fast the clock of a virtual rig goes: what is waited for them is in time of
/// the wall.
void wait_in_wall_time(Station& station, double speed) {
  for (StationDevice& device : station.devices) {
    device.timeout *= speed;
    device.lost_after *= speed;
    for (auto& [verb, timeout] : device.timeouts) timeout *= speed;
  }
  for (StationInstrument& instrument : station.instruments) {
    instrument.lost_after = silence_of(instrument) * speed;
    instrument.start_within *= speed;
    instrument.answer_within *= speed;
  }
  for (SafeCommand& command : station.safe) command.within *= speed;
  for (StationInterlock& interlock : station.interlocks) interlock.stale *= speed;
}

/// The links, and the folder of the run. Where these cannot be had nothing was sent, and nothing is left to be taken
/// over.
std::unique_ptr<LinkWires> begun(const PlannedRunAtStation& run, const Station& station,
                                 const std::function<double()>& clock, Lease& lease) {
  try {
    auto links = std::make_unique<LinkWires>(station, clock, run.speed);
    if (!run.resume) make_run_folder(run.folder, run.plan, station);
    return links;
  } catch (const Error&) {
    if (lease.left_behind().empty()) lease.end();
    throw;
  }
}

/// The store of the run, which takes room before anything is sent.
std::unique_ptr<Recorder> store_of_run(const PlannedRunAtStation& run, Disk& disk, Lease& lease) {
  RecorderOptions options;
  options.resume = run.resume;
  options.view = true;
  try {
    return std::make_unique<Recorder>(run.folder, disk, options);
  } catch (const Error& error) {
    if (lease.left_behind().empty()) {  // else it has the record of a takeover
      lease.end();
      if (!run.resume) forget_run(run.folder);
    }
    throw not_begun(error, run.resume);
  }
}

/// What is known before the first segment, to the store.
void note_beginning(const PlannedRunAtStation& run, const Station& station, const Course& course, double now,
                    Recorder& recorder) {
  note_facts(recorder, run.plan, course, run.who);
  if (!run.rig.empty()) note_played(recorder, run.rig, run.seed);
  if (!run.started.empty()) recorder.event({now, EventKind::clock, {}, say("{}", Name{run.started}), {}});
  if (const auto expired = expired_equipment(station, run.date); !run.accept_expired.empty() && !expired.empty())
    recorder.event(
        {now, EventKind::accepted, run.who, say("{} ({})", in_a_row(expired, "; "), Name{run.accept_expired}), {}});
}

RunCompany company_of(const PlannedRunAtStation& run, const Course& course) {
  RunCompany company = run.company;
  company.show_every *= std::max(1.0, run.speed);  // people look in time of the wall
  company.longest_commit = std::min(company.longest_commit, longest_commit * std::max(1.0, run.speed));
  if (!run.desk) return company;
  return at_desk(*run.desk, run.folder, facts_of(run.plan.title, course, run.who, run.rig), run.speed, company);
}

}  // namespace

RunEnd run_plan(const PlannedRunAtStation& run) {
  Station station = run.station;
  const StationParts parts = parts_of(station);
  StationRequest request;
  request.units = run.units;
  request.date = run.date;
  request.accept_expired = run.accept_expired;
  if (auto problems = check_station(run.plan, station, request); !problems.empty())
    throw Error(Error::Kind::bad_input, std::move(problems));
  if (run.speed > 1.0) wait_in_wall_time(station, run.speed);
  const auto course = course_of(run.plan, station, run.units);
  const auto rows = run.resume ? journal_of(run.folder) : std::vector<RunRow>{};
  // A run that goes on has times after those that it has recorded.
  const double before = run.resume ? end_of(run.folder) + 1.0 : 0.0;
  if (run.resume && run.desk) remember_run(*run.desk, run.folder);
  const double begin = run.clock();
  const auto clock = [&run, before, begin] { return before + run.speed * (run.clock() - begin); };
  Lease lease(station, run.folder);
  relieve_guards(run, lease);
  const std::unique_ptr<LinkWires> links = begun(run, station, clock, lease);
  const Sentence guarded = run.resume ? words_of_guard(run.folder) : Sentence();
  const std::unique_ptr<RigGuard> guard = guard_of(run, station, parts, *links);
  const Wires wires = links->wires();
  if (!lease.left_behind().empty()) make_safe(course, parts, wires, run.folder, run.speed, *guard);
  const auto estimates = estimates_of(run, *course);
  Disk disk;
  const std::unique_ptr<Recorder> store = store_of_run(run, disk, lease);
  Recorder& recorder = *store;
  note_beginning(run, station, *course, clock(), recorder);
  if (!guarded.empty()) recorder.event({clock(), EventKind::guard, {}, guarded, {}});
  RunCompany company = company_of(run, *course);
  if (!guarded.empty() && company.note) company.note({EventKind::guard, guarded}, clock());
  company.looked = [&guard] { return guard->looked(); };
  company.over = [&guard] { guard->dismiss(); };
  company.estimates = estimates.get();
  guard->arm();
  const RunEnd end =
      carry_out(run.resume ? resume_state(course, rows) : start_state(course), parts, wires, recorder, company);
  if (end.ending != RunEnding::faulted) lease.end();
  return end;
}

}  // namespace tumble
