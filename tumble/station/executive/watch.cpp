#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tumble/station/executive/turn.hpp"

namespace tumble::executive {
namespace {

/// Nobody has answered: axes come to rest, and the question stays open.
void hold_for_answer(Turn& turn) {
  auto& state = turn.state;
  state.prompt->overdue = true;
  turn.note(EventKind::prompt, say("nobody has answered question {}: the rig is held", state.prompt->prompt.id));
  if (state.phase != RunPhase::holding) {
    const bool moving = in_attempt(state.phase);
    state.after_hold = moving ? RunPhase::moving : state.phase;
    end_attempt(turn, RunRow::Ending::held, "nobody answered");
    enter(turn, RunPhase::holding);
  }
  drop_requests(turn);
  rest_axes(turn, Purpose::rest);
}

void note_by_hand(Turn& turn) {
  for (const auto& [axis, motion] : motions_before_recording(turn))
    if (has_word(turn.station().by_hand, axis)) turn.state.by_hand[axis] = motion.value;
}

/// A condition to hold for is not met any more: what moves comes to rest, and does it anew when it is met again.
void begin_hold(Turn& turn, const StationInterlock& hold) {
  auto& state = turn.state;
  const bool repeat = state.phase == RunPhase::moving || state.phase == RunPhase::recording || is_in_motion(turn);
  state.after_hold = repeat ? RunPhase::moving : RunPhase::settling;
  turn.note(EventKind::hold, say("'{}' is not met", hold.require.text));
  if (repeat) {
    close_prompt(turn);
    end_attempt(turn, RunRow::Ending::held, say("{}", Name{hold.require.text}));
    drop_requests(turn);
    for (auto& axis : state.axes) axis.ramping = false;
  }
  enter(turn, RunPhase::holding);
  rest_axes(turn, Purpose::rest);
}

/// Until when the channels of an interlock are news.
void wake_when_stale(Turn& turn, const StationInterlock& interlock) {
  for (const auto& term : interlock.require.terms)
    if (const auto found = turn.state.channels.find(term.channel); found != turn.state.channels.end())
      turn.reached(found->second.time + interlock.stale);
}

void check_interlock(Turn& turn, std::size_t index, bool more) {
  const auto& interlock = turn.station().interlocks[index];
  auto& progress = turn.state.interlocks[index];
  const bool early = turn.state.phase == RunPhase::preparing;
  const auto observe = [&](const std::string& channel) { return reading_of(turn, channel, interlock.stale); };
  const Holds observed = evaluate(interlock.require, observe);
  if (more && observed == Holds::unknown) return;
  wake_when_stale(turn, interlock);
  const bool met = observed == Holds::yes || (early && observed == Holds::unknown);
  if (met == progress.met) return progress.changing_since.reset();
  if (!progress.changing_since) progress.changing_since = turn.now();
  if (!turn.reached(*progress.changing_since + interlock.debounce)) return;
  progress.changing_since.reset();
  progress.met = met;
  const std::string& condition = interlock.require.text;
  turn.note(EventKind::interlock, met ? say("'{}' is met again", condition) : say("'{}' is not met", condition));
  if (met) return;
  if (interlock.action == StationInterlock::Action::stop)
    begin_safe(turn, RunPhase::stopping, RunEnding::stopped,
               observed == Holds::unknown ? say("'{}' is not met: a channel without news", condition)
                                          : say("'{}' is not met", condition));
}

/// An axis that runs out of its travel, for any reason, is stopped.
void check_travel(Turn& turn) {
  constexpr int readings_beyond = 2;  // one may be a wrong digit on the line
  for (std::size_t i = 0; i < turn.state.axes.size() && is_active(turn.state.phase); ++i)
    if (turn.state.axes[i].beyond >= readings_beyond)
      begin_safe(turn, RunPhase::stopping, RunEnding::stopped,
                 say("{} has left its travel, which the station states as lowest and highest",
                     Name{turn.station().axes[i].name}));
}

}  // namespace

void open_prompt(Turn& turn, OpenPrompt::About about, Sentence text, std::vector<std::string> choices) {
  Prompt prompt{++turn.state.prompts, std::move(text), std::move(choices)};
  prompt.standard = prompt.choices.front();
  prompt.deadline = turn.now() + turn.course.prompt_deadline;
  if (about == OpenPrompt::About::failure) prompt.failed_segment = turn.segment().label;
  turn.state.prompt = OpenPrompt{prompt, about};
  turn.act(std::move(prompt));
}

void close_prompt(Turn& turn) {
  if (!turn.state.prompt) return;
  turn.act(PromptClosed{turn.state.prompt->prompt.id});
  turn.state.prompt.reset();
}

void take_answer(Turn& turn, const PromptAnswer& answer) {
  auto& state = turn.state;
  if (!state.prompt || state.prompt->prompt.id != answer.prompt)
    return turn.note(EventKind::refused, say("{}: question {} is closed", Name{answer.who}, answer.prompt));
  const auto& choices = state.prompt->prompt.choices;
  if (!has_word(choices, answer.choice))
    return turn.note(EventKind::refused, say("{}: '{}' is no answer to question {}; accepted: {}", Name{answer.who},
                                             answer.choice, answer.prompt, fmt::join(choices, ", ")));
  turn.note(EventKind::answer, say("{}: '{}' to question {}", Name{answer.who}, answer.choice, answer.prompt));
  const auto about = state.prompt->about;
  close_prompt(turn);
  if (answer.choice == "stop")
    return begin_safe(turn, RunPhase::stopping, RunEnding::stopped, say("{} has stopped the run", Name{answer.who}));
  if (about == OpenPrompt::About::by_hand) return note_by_hand(turn);
  if (about == OpenPrompt::About::power) {
    forget_streams(turn);
    start_streams(turn);
    return power_up_row(turn);
  }
  state.failed_attempts = 0;
  if (answer.choice == "repeat") return;
  state.segments[state.segment].status = SegmentProgress::Status::skipped;
  state.after_hold = RunPhase::between;
}

void take_order(Turn& turn, const RunOrder& order) {
  auto& state = turn.state;
  const bool pausable = in_attempt(state.phase) || state.phase == RunPhase::holding;
  const bool checkpoint =
      state.phase == RunPhase::preparing || state.phase == RunPhase::ready || state.phase == RunPhase::between;
  using Kind = RunOrder::Kind;
  if (order.kind == Kind::start && state.phase == RunPhase::idle) return start(turn);
  if (order.kind == Kind::pause && pausable) return begin_pause(turn);
  if ((order.kind == Kind::pause || order.kind == Kind::pause_at_checkpoint) && (pausable || checkpoint)) {
    state.pause_wanted = true;
    return;
  }
  if (order.kind == Kind::resume && state.phase == RunPhase::paused) return enter(turn, RunPhase::between);
  if (order.kind == Kind::resume && state.pause_wanted) {
    state.pause_wanted = false;
    return;
  }
  const Sentence who = order.who.empty() ? Sentence("the run") : say("{}", Name{order.who});
  if (order.kind == Kind::abort)
    return begin_safe(turn, RunPhase::aborting, RunEnding::aborted, say("{} has aborted the run", who));
  if (order.kind == Kind::stop)
    return begin_safe(turn, RunPhase::stopping, RunEnding::stopped, say("{} has stopped the run", who));
  turn.note(EventKind::refused, say("this order cannot be carried out while the run is {}", word_of(state.phase)));
}

void take_unit_failed(Turn& turn, const UnitFailed& failed) {
  auto& state = turn.state;
  const auto& units = turn.course.units;
  const bool known =
      std::any_of(units.begin(), units.end(), [&](const auto& unit) { return unit.slot == failed.slot; });
  if (!known || has_word(state.units_out, failed.slot)) return;
  state.units_out.push_back(failed.slot);
  turn.note(EventKind::unit, say("the unit in slot {} drops out: {}", Name{failed.slot}, failed.reason));
  RunRow row;
  row.kind = RunRow::Kind::unit_out;
  row.time = turn.now();
  row.segment = state.segment;
  row.label = failed.slot;
  row.reason = failed.reason;
  if (is_active(state.phase) && (turn.course.all_units || state.units_out.size() == units.size()))
    begin_safe(turn, RunPhase::stopping, RunEnding::failed,
               turn.course.all_units
                   ? say("the plan needs all units, and that in slot {} has failed", Name{failed.slot})
                   : Sentence("no unit is left in the run"));
  write_row(turn, std::move(row));
}

void check_prompt(Turn& turn) {
  auto& prompt = turn.state.prompt;
  if (prompt && !prompt->overdue && turn.reached(prompt->prompt.deadline)) hold_for_answer(turn);
}

void check_interlocks(Turn& turn, bool more) {
  check_travel(turn);
  check_rates(turn);
  if (!is_active(turn.state.phase)) return;
  for (std::size_t i = 0; i < turn.state.interlocks.size(); ++i) {
    check_interlock(turn, i, more);
    if (!is_active(turn.state.phase)) return;
  }
  const auto* hold = broken_hold(turn);
  if (hold && in_attempt(turn.state.phase)) begin_hold(turn, *hold);
}

const StationInterlock* broken_hold(Turn& turn) {
  for (std::size_t i = 0; i < turn.state.interlocks.size(); ++i) {
    const auto& interlock = turn.station().interlocks[i];
    if (interlock.action == StationInterlock::Action::hold && !turn.state.interlocks[i].met) return &interlock;
  }
  return nullptr;
}

void advance_holding(Turn& turn) {
  auto& state = turn.state;
  if (!state.failures.empty())
    return begin_safe(turn, RunPhase::stopping, RunEnding::failed, state.failures.begin()->second);
  const bool overdue = state.prompt && state.prompt->overdue;
  const double since = overdue ? std::max(state.entered, state.prompt->prompt.deadline) : state.entered;
  if ((overdue || broken_hold(turn)) && !all_at_rest(turn) && turn.reached(since + rest_deadline))
    return begin_safe(turn, RunPhase::stopping, RunEnding::failed, "the axes did not come to rest");
  if (state.prompt || broken_hold(turn)) return;
  if (state.pause_wanted) return begin_pause(turn);
  if (state.after_hold == RunPhase::moving) return begin_attempt(turn);
  enter(turn, state.after_hold);
  if (state.after_hold == RunPhase::settling) restart_settling(turn);
}

}  // namespace tumble::executive
