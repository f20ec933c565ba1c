#include <cmath>
#include <type_traits>

#include "tumble/station/executive/turn.hpp"

namespace tumble {
namespace executive {
namespace {

constexpr int most_changes = 100;       ///< of the phase in one step
constexpr double usual_lateness = 1.0;  ///< [s] of a tick

void take(Turn&, const Tick&) {}
void take(Turn& turn, const DeviceReply& event) { take_reply(turn, event); }
void take(Turn& turn, const LinkLost& event) { take_lost(turn, event); }
void take(Turn& turn, const LinkUp& event) { take_up(turn, event); }
void take(Turn& turn, const ChannelValues& event) { take_values(turn, event); }
void take(Turn& turn, const UnitFailed& event) { take_unit_failed(turn, event); }
void take(Turn& turn, const StreamStarted& event) { take_started(turn, event); }
void take(Turn& turn, const EstimateNow& event) { take_estimate(turn, event); }
void take(Turn& turn, const PromptAnswer& event) { take_answer(turn, event); }
void take(Turn& turn, const RunOrder& event) { take_order(turn, event); }
void take(Turn& turn, const StoreFailed& event) {
  begin_safe(turn, RunPhase::stopping, RunEnding::stopped, say("the recording has stopped: {}", event.reason));
}

void take(Turn& turn, const RowsStored& event) { take_stored(turn, event); }
void take(Turn& turn, const MustStop& event) { begin_safe(turn, RunPhase::stopping, RunEnding::stopped, event.reason); }

void advance_phase(Turn& turn) {
  switch (turn.state.phase) {
    case RunPhase::preparing:
      return advance_preparing(turn);
    case RunPhase::ready:
    case RunPhase::between:
      return next_segment(turn);
    case RunPhase::finishing:
      return advance_finishing(turn);
    case RunPhase::holding:
      return advance_holding(turn);
    case RunPhase::pausing:
      return advance_pausing(turn);
    case RunPhase::stopping:
    case RunPhase::aborting:
      return advance_safe(turn);
    default:
      return advance_segment(turn);
  }
}

/// Goes on until nothing follows any more without a new event.
void advance(Turn& turn, bool more) {
  if (!more) check_timeouts(turn);
  check_interlocks(turn, more);
  check_prompt(turn);
  for (int i = 0; i < most_changes; ++i) {
    const RunPhase phase = turn.state.phase;
    const std::size_t done = turn.actions.size();
    advance_phase(turn);
    if (turn.state.phase == phase && turn.actions.size() == done) return;
  }
}

void wake(Turn& turn) {
  if (is_end(turn.state.phase) || !std::isfinite(turn.wake)) return;
  if (turn.state.wake && *turn.state.wake == turn.wake) return;
  turn.state.wake = turn.wake;
  turn.act(WakeAt{turn.wake});
}

}  // namespace
}  // namespace executive

ExecutiveState step(ExecutiveState state, const RunEvent& event, std::vector<RunAction>& actions) {
  state.now = std::max(state.now, event.time);
  const double late = state.wake ? state.now - *state.wake : 0.0;
  if (late >= 0.0) state.wake.reset();
  const auto course = state.course;
  executive::Turn turn{state, *course, actions};
  if (is_end(state.phase)) {
    if (const auto* answer = std::get_if<PromptAnswer>(&event.what)) executive::take_answer(turn, *answer);
    return state;
  }
  if (late > executive::usual_lateness) executive::forgive(turn, late);
  std::visit([&](const auto& what) { executive::take(turn, what); }, event.what);
  if (state.phase != RunPhase::idle) {
    executive::advance(turn, event.more);
    if (!is_end(state.phase)) executive::send_waiting(turn);
  }
  executive::wake(turn);
  return state;
}

}  // namespace tumble
