#include "tumble/station/executive/turn.hpp"
#include "tumble/units/unit.hpp"

namespace tumble::executive {
namespace {

using Status = SegmentProgress::Status;

SegmentProgress& progress_of(Turn& turn) { return turn.state.segments[turn.state.segment]; }

const StoppingRule* rule_of(const Turn& turn) {
  const auto found = turn.course.until.find(turn.segment().label);
  return found == turn.course.until.end() ? nullptr : &found->second;
}

RunRow row_of(Turn& turn, RunRow::Kind kind) {
  RunRow row;
  row.kind = kind;
  row.time = turn.now();
  row.segment = turn.state.segment;
  row.run = turn.segment().run;
  row.attempt = progress_of(turn).attempts;
  row.label = turn.segment().label;
  if (const auto* rule = rule_of(turn)) row.rule = rule->text, row.at_least = rule->at_least;
  return row;
}

/// What the most careful of the segment's axes says about failed attempts.
const StationAxis* strictest_axis(const Turn& turn) {
  const StationAxis* strictest = nullptr;
  for (const auto& axis : turn.station().axes) {
    if (!turn.segment().axes.contains(axis.name)) continue;
    if (!strictest || axis.retries < strictest->retries) strictest = &axis;
  }
  return strictest;
}

/// The axes that a person has to move for this segment, in words; their values are noted when they are done.
Sentence by_hand_words(const Turn& turn) {
  const Unit degree = Unit::parse("deg");
  const auto motions = motions_before_recording(turn);
  std::vector<Sentence> all;
  for (const auto& axis : turn.station().by_hand) {
    const auto found = motions.find(axis);
    if (found == motions.end()) continue;
    const auto known = turn.state.by_hand.find(axis);
    if (known != turn.state.by_hand.end() && known->second == found->second.value) continue;
    all.push_back(say("{} to {} deg", Name{axis}, Name{format_in(found->second.value, degree)}));
  }
  return in_a_row(all, ", ");
}

void record(Turn& turn, bool on) {
  if (turn.state.recording == on) return;
  turn.state.recording = on;
  turn.act(RecordSwitch{on, turn.state.segment, turn.segment().label, turn.segment().run, progress_of(turn).attempts});
}

void advance_moving(Turn& turn) {
  auto& state = turn.state;
  if (state.prompt) return;
  continue_ramps(turn);
  if (!state.motions_sent) {
    if (const auto text = by_hand_words(turn); !text.empty())
      return open_prompt(turn, OpenPrompt::About::by_hand,
                         say("Segment '{}': turn the instrument by hand: {}", turn.segment().label, text),
                         {"done", "stop"});
    send_motions(turn);
    state.settle_by = turn.now() + settle_timeout(turn);
    return;
  }
  if (!state.failures.empty()) return attempt_failed(turn, state.failures.begin()->second);
  if (outstanding(turn, Purpose::motion) || has_open_set_points(turn)) {
    if (!state.held_since && turn.reached(state.settle_by))
      attempt_failed(turn, "the commands of the motion were not carried out in time");
    return;
  }
  enter(turn, RunPhase::settling);
  restart_settling(turn);
}

void advance_settling(Turn& turn) {
  continue_ramps(turn);
  if (!turn.state.failures.empty()) return attempt_failed(turn, turn.state.failures.begin()->second);
  if (all_settled(turn)) return enter(turn, RunPhase::dwelling);
  if (turn.reached(turn.state.settle_by)) attempt_failed(turn, why_not_settled(turn));
}

void begin_recording(Turn& turn) {
  enter(turn, RunPhase::recording);
  turn.state.recording_began = turn.now();
  turn.state.rule_reached.reset();
  turn.state.good_enough.clear();
  begin_means(turn);
  record(turn, true);
  begin_ramps(turn);
}

void advance_dwelling(Turn& turn) {
  const auto outside = left_tolerance(turn, 1);
  if (!outside.empty()) {
    turn.note(EventKind::settle, say("{}: the dwell time begins again", outside));
    if (++turn.state.restarts > most_restarts) return attempt_failed(turn, say("{} again and again", outside));
    enter(turn, RunPhase::settling);
    return restart_settling(turn);
  }
  if (turn.reached(turn.state.entered + soak_time(turn)) && power_is_right(turn) && streams_run(turn))
    begin_recording(turn);
}

/// Whether the stopping rule is met for all units that are still in the run.
bool rule_is_met(Turn& turn) {
  const auto* rule = rule_of(turn);
  auto& state = turn.state;
  if (!rule || state.good_enough.empty()) return false;
  for (const auto& unit : turn.course.units) {
    if (std::find(state.units_out.begin(), state.units_out.end(), unit.slot) != state.units_out.end()) continue;
    const auto found = state.good_enough.find(unit.slot);
    if (found == state.good_enough.end() || !found->second) return false;
  }
  if (!turn.reached(state.recording_began + rule->at_least)) return false;
  state.rule_reached = turn.now() - state.recording_began;
  return true;
}

void advance_recording(Turn& turn) {
  auto& state = turn.state;
  if (!state.failures.empty()) return attempt_failed(turn, state.failures.begin()->second);
  if (const auto outside = left_tolerance(turn, readings_outside); !outside.empty())
    return attempt_failed(turn, outside);
  continue_ramps(turn);
  if (!rule_is_met(turn) && !turn.reached(state.recording_began + turn.segment().duration)) return;
  end_attempt(turn, RunRow::Ending::complete, "");
  end_ramps(turn);
  progress_of(turn).status = Status::complete;
  state.failed_attempts = 0;
  enter(turn, RunPhase::between);
}

}  // namespace

void next_segment(Turn& turn) {
  auto& state = turn.state;
  if (state.pause_wanted) return begin_pause(turn);
  const auto open = std::find_if(state.segments.begin(), state.segments.end(),
                                 [](const SegmentProgress& one) { return one.status == Status::open; });
  if (open == state.segments.end()) return begin_finishing(turn);
  state.segment = static_cast<std::size_t>(open - state.segments.begin());
  if (const auto* hold = broken_hold(turn)) {
    turn.note(EventKind::hold, say("{}", Name{hold->require.text}));
    state.after_hold = state.phase;
    enter(turn, RunPhase::holding);
    return rest_axes(turn, Purpose::rest);
  }
  if (may_move(turn)) begin_attempt(turn);
}

void begin_attempt(Turn& turn) {
  auto& state = turn.state;
  drop_requests(turn);
  ++progress_of(turn).attempts;
  state.attempt_open = true;
  state.motions_sent = false;
  state.restarts = 0;
  if (state.power != ExecutiveState::Power::off) state.power = ExecutiveState::Power::idle;
  auto row = row_of(turn, RunRow::Kind::segment_begins);
  write_row(turn, std::move(row));
  enter(turn, RunPhase::moving);
}

void end_attempt(Turn& turn, RunRow::Ending ending, const Sentence& reason) {
  auto& state = turn.state;
  if (!state.attempt_open) return;
  record(turn, false);
  state.attempt_open = false;
  if (ending != RunRow::Ending::complete && begins_power_up(turn)) state.powered_run = 0;
  auto row = row_of(turn, RunRow::Kind::segment_ends);
  row.ending = ending;
  row.reason = reason;
  row.demanded = demanded(turn);
  row.achieved = achieved(turn);
  row.reached = state.rule_reached;
  write_row(turn, std::move(row));
}

void attempt_failed(Turn& turn, Sentence reason) {
  auto& state = turn.state;
  end_attempt(turn, RunRow::Ending::failed, reason);
  turn.note(EventKind::attempt,
            say("segment '{}', attempt {} failed: {}", turn.segment().label, progress_of(turn).attempts, reason));
  drop_requests(turn);
  ++state.failed_attempts;
  const auto* axis = strictest_axis(turn);
  if (state.failed_attempts <= (axis ? axis->retries : 0)) return begin_attempt(turn);
  const auto action = axis ? axis->on_failure : OnFailure::ask;
  if (action == OnFailure::stop) return begin_safe(turn, RunPhase::stopping, RunEnding::failed, std::move(reason));
  if (action == OnFailure::skip) {
    progress_of(turn).status = Status::skipped;
    state.failed_attempts = 0;
    turn.note(EventKind::skip, say("segment '{}' is skipped", turn.segment().label));
    return enter(turn, RunPhase::between);
  }
  state.after_hold = RunPhase::moving;
  enter(turn, RunPhase::holding);
  open_prompt(turn, OpenPrompt::About::failure, say("Segment '{}': {}", turn.segment().label, reason),
              {"repeat", "skip", "stop"});
}

void advance_segment(Turn& turn) {
  switch (turn.state.phase) {
    case RunPhase::moving:
      return advance_moving(turn);
    case RunPhase::settling:
      return advance_settling(turn);
    case RunPhase::dwelling:
      return advance_dwelling(turn);
    case RunPhase::recording:
      return advance_recording(turn);
    default:
      return;
  }
}

void take_estimate(Turn& turn, const EstimateNow& estimate) {
  if (turn.state.phase != RunPhase::recording) return;
  const auto* rule = rule_of(turn);
  if (rule && rule->parameter == estimate.parameter)
    turn.state.good_enough[estimate.slot] = estimate.sd >= 0.0 && estimate.sd <= rule->sd;
}

}  // namespace tumble::executive
