#include "tumble/station/run_plan.hpp"

#include <utility>

#include "tumble/station/disk.hpp"
#include "tumble/station/lease.hpp"
#include "tumble/station/link_wires.hpp"
#include "tumble/station/run_folder.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// A run that was killed may have left the rig in motion: the safe list is carried out before anything else.
void make_safe(const std::shared_ptr<const Course>& course, const StationParts& parts, const Wires& wires,
               const std::string& folder) {
  make_run_folder(folder, {}, {});
  Disk disk;
  Recorder recorder(folder, disk);
  RunCompany company;
  company.orders = [] { return std::vector<decltype(RunEvent::what)>{RunOrder{RunOrder::Kind::stop, "takeover"}}; };
  const RunEnd end = carry_out(start_state(course), parts, wires, recorder, company);
  if (end.ending == RunEnding::faulted)
    throw Error(Error::Kind::bad_file,
                "a run before this one was killed, and the rig cannot be brought to its safe state: " + end.text);
}

/// Other programs need their time however fast the clock of a virtual rig goes: what is waited for them is in time of
/// the wall.
void wait_in_wall_time(Station& station, double speed) {
  for (StationDevice& device : station.devices) {
    device.timeout *= speed;
    device.lost_after *= speed;
    for (auto& [verb, timeout] : device.timeouts) timeout *= speed;
  }
  for (StationInstrument& instrument : station.instruments) instrument.lost_after = silence_of(instrument) * speed;
  for (SafeCommand& command : station.safe) command.within *= speed;
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
  const double begin = run.clock();
  const auto clock = [&run, before, begin] { return before + run.speed * (run.clock() - begin); };
  Lease lease(station, run.folder);
  LinkWires links(station, clock, run.speed);
  const Wires wires = links.wires();
  if (!run.resume) make_run_folder(run.folder, run.plan, station);
  if (!lease.left_behind().empty()) make_safe(course, parts, wires, run.folder + "/takeover");
  Disk disk;
  RecorderOptions options;
  options.resume = run.resume;
  Recorder recorder(run.folder, disk, options);
  note_facts(recorder, run.plan, *course, run.who);
  if (!run.started.empty()) recorder.event({clock(), "clock", {}, run.started, {}});
  if (!run.accept_expired.empty())
    recorder.event({clock(), "accepted", run.who, "equipment out of calibration: " + run.accept_expired, {}});
  const RunEnd end =
      carry_out(run.resume ? resume_state(course, rows) : start_state(course), parts, wires, recorder, run.company);
  if (end.ending != RunEnding::faulted) lease.end();
  return end;
}

}  // namespace tumble
