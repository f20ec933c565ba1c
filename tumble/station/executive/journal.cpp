#include <set>

#include "tumble/station/executive/turn.hpp"

namespace tumble {
namespace {

bool several_power_ups(const Schedule& schedule) {
  return std::any_of(schedule.begin(), schedule.end(),
                     [&](const Segment& one) { return one.run != schedule.front().run; });
}

/// Power-ups of which every segment counts.
std::set<int> whole_runs(const Schedule& schedule, const std::map<std::size_t, int>& counted) {
  std::set<int> whole;
  for (const auto& segment : schedule) whole.insert(segment.run);
  for (std::size_t i = 0; i < schedule.size(); ++i)
    if (!counted.contains(i)) whole.erase(schedule[i].run);
  return whole;
}

/// Whether the safe list, with which every interrupted run has ended, takes the power from the unit.
bool is_switched_off(const Station& station) {
  return std::any_of(station.safe.begin(), station.safe.end(), [&](const SafeCommand& command) {
    return station.power.device == command.device && command.request.verb != ControllerVerb::stop;
  });
}

}  // namespace

ExecutiveState start_state(std::shared_ptr<const Course> course) {
  ExecutiveState state;
  state.segments.resize(course->schedule.size());
  state.devices.resize(course->station.devices.size());
  state.axes.resize(course->station.axes.size());
  state.interlocks.resize(course->station.interlocks.size());
  state.safe.resize(course->station.safe.size());
  state.streams.resize(course->station.instruments.size());
  state.course = std::move(course);
  return state;
}

ExecutiveState resume_state(std::shared_ptr<const Course> course, const std::vector<RunRow>& journal) {
  ExecutiveState state = start_state(std::move(course));
  const auto& schedule = state.course->schedule;
  const auto counted = counted_attempts(journal);
  const auto whole = whole_runs(schedule, counted);
  const bool repeat_runs = several_power_ups(schedule) || is_switched_off(state.course->station);
  for (const auto& row : journal) {
    if (row.kind == RunRow::Kind::unit_out) state.units_out.push_back(row.label);
    if (row.kind == RunRow::Kind::power_up) {
      state.resumed = true;
      if (!repeat_runs) state.powered_run = row.run;
    }
    if (row.kind != RunRow::Kind::segment_begins || row.segment >= schedule.size()) continue;
    auto& attempts = state.segments[row.segment].attempts;
    attempts = std::max(attempts, row.attempt);
  }
  const auto is_out = [&](const UnitUnderTest& unit) { return executive::has_word(state.units_out, unit.slot); };
  if (std::ranges::all_of(state.course->units, is_out)) state.units_out.clear();  // a person has seen to them
  for (const auto& [segment, attempt] : counted)
    if (segment < schedule.size() && (!repeat_runs || whole.contains(schedule[segment].run)))
      state.segments[segment].status = SegmentProgress::Status::complete;
  return state;
}

namespace executive {

void write_row(Turn& turn, RunRow row) {
  ++turn.state.rows;
  turn.act(JournalEntry{std::move(row)});
}

bool waits_for_row(const Turn& turn, const PendingRequest& request) {
  const auto& state = turn.state;
  if (!state.awaits_rows || state.rows_stored >= state.rows) return false;
  return request.purpose == Purpose::motion || request.purpose == Purpose::power ||
         request.purpose == Purpose::prepare || request.purpose == Purpose::finish;
}

/// The disk is not the rig: what it took is no time that the axes had.
void take_stored(Turn& turn, const RowsStored& stored) {
  auto& state = turn.state;
  state.rows_stored = std::max(state.rows_stored, stored.rows);
  if (state.rows_stored < state.rows || !state.held_since) return;
  state.settle_by += turn.now() - *state.held_since;
  state.held_since.reset();
}

}  // namespace executive
}  // namespace tumble
