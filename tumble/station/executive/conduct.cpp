
#include "tumble/station/executive/turn.hpp"

namespace tumble::executive {
namespace {

using Power = ExecutiveState::Power;

bool several_runs(const Turn& turn) {
  const auto& schedule = turn.course.schedule;
  return std::any_of(schedule.begin(), schedule.end(),
                     [&](const Segment& one) { return one.run != schedule.front().run; });
}

/// What is not known yet of axes and interlocks, in words; empty: all is.
Sentence unknown_yet(const Turn& turn) {
  for (std::size_t i = 0; i < turn.state.axes.size(); ++i) {
    const auto& axis = turn.station().axes[i];
    if (turn.station().devices[axis.device].can(ControllerVerb::read) && turn.state.axes[i].read_at < 0.0)
      return say("{} has not been read", Name{axis.name});
  }
  for (const auto& interlock : turn.station().interlocks) {
    const auto observe = [&](const std::string& channel) { return reading_of(turn, channel, interlock.stale); };
    if (evaluate(interlock.require, observe) == Holds::unknown)
      return say("nothing is known of '{}'", interlock.require.text);
  }
  return {};
}

/// Where a supply switches the unit: off, time without power, on, warm-up. With `only_off` it is switched off.
void advance_supply(Turn& turn, std::size_t supply, bool only_off) {
  auto& state = turn.state;
  const auto& power = turn.station().power;
  const auto verb = [&](ControllerVerb one) { ask(turn, supply, {{one}, Purpose::power}); };
  if (state.power == Power::idle) {
    state.failures.clear();
    const bool off_first = several_runs(turn);
    verb(off_first ? ControllerVerb::off : ControllerVerb::start);
    forget_streams(turn);
    state.power = off_first ? Power::off : Power::on;
    return;
  }
  if (!state.failures.empty())
    return begin_safe(turn, RunPhase::stopping, RunEnding::failed, state.failures.begin()->second);
  if (only_off || outstanding(turn, Purpose::power)) return;
  if (state.power == Power::off) {
    state.power = Power::wait;
    state.power_until = turn.now() + power.off_time;
  }
  if (state.power == Power::wait && turn.reached(state.power_until)) {
    verb(ControllerVerb::start);
    state.power = Power::on;
    return;
  }
  if (state.power == Power::on) {
    state.power = Power::warm;
    state.power_until = turn.now() + power.warm_up;
    start_streams(turn);
  }
  if (state.power == Power::warm && turn.reached(state.power_until)) power_up_row(turn);
}

}  // namespace

void power_up_row(Turn& turn) {
  RunRow row;
  row.kind = RunRow::Kind::power_up;
  row.time = turn.now();
  row.segment = turn.state.segment;
  row.run = turn.segment().run;
  row.label = turn.segment().label;
  turn.state.powered_run = row.run;
  turn.state.power = Power::idle;
  write_row(turn, std::move(row));
}

void start(Turn& turn) {
  auto& state = turn.state;
  enter(turn, RunPhase::preparing);
  for (std::size_t i = 0; i < state.devices.size(); ++i) {
    const auto& setup = turn.station().devices[i];
    state.devices[i].heard = state.devices[i].next_poll = turn.now();
    for (const auto& verb : setup.prepare) ask(turn, i, {{verb}, Purpose::prepare});
    if (state.devices[i].lost)
      return begin_safe(turn, RunPhase::stopping, RunEnding::error, say("there is no link to {}", Name{setup.name}));
  }
  const bool on_from_the_start = !turn.station().power.device && !state.resumed;
  if (on_from_the_start || state.powered_run != 0) start_streams(turn);
}

void advance_preparing(Turn& turn) {
  auto& state = turn.state;
  if (!state.failures.empty())
    return begin_safe(turn, RunPhase::stopping, RunEnding::error, state.failures.begin()->second);
  const auto unknown = unknown_yet(turn);
  const bool streams = streams_run(turn);
  if (!is_active(state.phase)) return;  // no unit is left
  if (!outstanding(turn, Purpose::prepare) && unknown.empty() && streams) return enter(turn, RunPhase::ready);
  if (turn.reached(state.entered + turn.course.prepare_deadline))
    begin_safe(turn, RunPhase::stopping, RunEnding::error,
               unknown.empty() ? Sentence("the devices were not ready in time") : unknown);
}

void begin_finishing(Turn& turn) {
  enter(turn, RunPhase::finishing);
  drop_requests(turn);
  rest_axes(turn, Purpose::finish);
  stop_streams(turn);
  for (std::size_t i = 0; i < turn.state.devices.size(); ++i)
    for (const auto& verb : turn.station().devices[i].finish) ask(turn, i, {{verb}, Purpose::finish});
}

void advance_finishing(Turn& turn) {
  auto& state = turn.state;
  if (!state.failures.empty())
    return begin_safe(turn, RunPhase::stopping, RunEnding::failed, state.failures.begin()->second);
  if (!outstanding(turn, Purpose::finish) && all_at_rest(turn)) {
    RunRow row;
    row.kind = RunRow::Kind::run_ends;
    row.time = turn.now();
    row.ending = RunRow::Ending::complete;
    write_row(turn, std::move(row));
    enter(turn, RunPhase::complete);
    return turn.act(RunEnd{RunEnding::complete, "the plan has been carried out"});
  }
  if (turn.reached(state.entered + rest_deadline))
    begin_safe(turn, RunPhase::stopping, RunEnding::failed, "the axes did not come to rest at the end");
}

void begin_pause(Turn& turn) {
  auto& state = turn.state;
  state.pause_wanted = false;
  state.power = Power::idle;
  close_prompt(turn);
  end_attempt(turn, RunRow::Ending::paused, "");
  enter(turn, RunPhase::pausing);
  drop_requests(turn);
  rest_axes(turn, Purpose::rest);
}

void advance_pausing(Turn& turn) {
  auto& state = turn.state;
  if (!state.failures.empty())
    return begin_safe(turn, RunPhase::stopping, RunEnding::failed, state.failures.begin()->second);
  if (!outstanding(turn, Purpose::rest) && all_at_rest(turn)) return enter(turn, RunPhase::paused);
  if (turn.reached(state.entered + rest_deadline))
    begin_safe(turn, RunPhase::stopping, RunEnding::failed, "the axes did not come to rest");
}

bool begins_power_up(const Turn& turn) {
  const auto& schedule = turn.course.schedule;
  const std::size_t segment = turn.state.segment;
  const bool first = segment == 0 || schedule[segment - 1].run != schedule[segment].run;
  return first && turn.station().power.device && several_runs(turn);
}

bool may_move(Turn& turn) {
  const auto& supply = turn.station().power.device;
  const bool on_from_the_start = !supply && turn.state.powered_run == 0 && !turn.state.resumed;
  if (!several_runs(turn) || on_from_the_start) return power_is_right(turn);
  if (!supply || turn.state.powered_run == turn.segment().run) return true;
  if (turn.state.power != Power::off) turn.state.power = Power::idle;
  advance_supply(turn, *supply, true);
  return is_active(turn.state.phase) && turn.state.power == Power::off && !outstanding(turn, Purpose::power);
}

bool power_is_right(Turn& turn) {
  auto& state = turn.state;
  if (state.powered_run == turn.segment().run) return true;
  if (turn.station().power.device) {
    advance_supply(turn, *turn.station().power.device, false);
  } else if (state.powered_run == 0 && !state.resumed) {
    power_up_row(turn);  // the person who started the run has switched it on
  } else if (!state.prompt) {
    open_prompt(turn, OpenPrompt::About::power,
                say("Switch the instrument off, wait {:.3g} s, and switch it on: power-up {}",
                    turn.station().power.off_time, turn.segment().run),
                {"done", "stop"});
  }
  return state.powered_run == turn.segment().run;
}

}  // namespace tumble::executive
