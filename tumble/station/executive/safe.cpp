
#include <cmath>

#include "tumble/station/executive/turn.hpp"

namespace tumble::executive {
namespace {

void queue_safe(Turn& turn, std::size_t index) {
  const auto& command = turn.station().safe[index];
  auto& progress = turn.state.safe[index];
  auto& waiting = turn.state.devices[command.device].waiting;
  const auto place = std::find_if(waiting.begin(), waiting.end(),
                                  [](const PendingRequest& one) { return one.purpose != Purpose::safe; });
  waiting.insert(place, {command.request, Purpose::safe, 0, index});
  progress.sent = true;
  progress.sent_at = turn.now();
  progress.again.reset();
  for (std::size_t i = 0; i < turn.station().axes.size(); ++i)
    if (turn.station().axes[i].device == command.device) turn.state.axes[i].at_rest = 0;
}

bool is_resolved(const SafeProgress& progress) { return progress.confirmed || progress.overdue; }

/// Sends what is due: all commands that wait for none before them, at once.
void send_due(Turn& turn) {
  bool before = true;  // all before are resolved
  for (std::size_t i = 0; i < turn.state.safe.size(); ++i) {
    const auto& command = turn.station().safe[i];
    auto& progress = turn.state.safe[i];
    if (!progress.due && (!command.wait || before)) {
      progress.due = true;
      progress.since = turn.now();
    }
    const auto& device = turn.state.devices[command.device];
    const bool again = progress.sent && progress.again && device.heard > *progress.again;
    if (progress.due && !is_resolved(progress) && !device.cut && (!progress.sent || again)) queue_safe(turn, i);
    before = before && is_resolved(progress);
  }
}

/// `stop` is confirmed by reading that the axes stand, not by its reply.
bool stands_still(const Turn& turn, const SafeCommand& command, const SafeProgress& progress) {
  bool is_axis = false;
  for (std::size_t i = 0; i < turn.station().axes.size(); ++i) {
    const auto& axis = turn.station().axes[i];
    if (axis.device != command.device || axis.number != command.request.axis) continue;
    if (axis.kind != StationAxis::Kind::angle) continue;
    is_axis = true;
    if (turn.state.axes[i].at_rest < readings_at_rest) return false;
  }
  return is_axis || progress.replied;
}

/// Whether the set point that is read back is the one of the command.
bool reads_back(const Turn& turn, const SafeCommand& command, const SafeProgress& progress) {
  const auto& setup = turn.station().devices[command.device];
  const auto found = turn.state.channels.find(setup.name + ".set_point");
  if (found == turn.state.channels.end() || found->second.time <= progress.sent_at) return false;
  const auto* read = std::get_if<double>(&found->second.value);
  return read && std::abs(*read - command.request.values.at("temperature")) <= setup.set_point_step;
}

bool is_confirmed(const Turn& turn, const SafeCommand& command, const SafeProgress& progress) {
  const auto& setup = turn.station().devices[command.device];
  if (!progress.sent) return false;
  if (command.request.verb == ControllerVerb::set_temperature && setup.set_point_verb)
    return progress.replied && reads_back(turn, command, progress);
  if (command.confirm)
    return evaluate(*command.confirm, [&](const std::string& channel) -> ChannelReading {
             const auto found = turn.state.channels.find(channel);
             if (found == turn.state.channels.end() || found->second.time <= progress.sent_at) return {};
             return found->second.value;
           }) == Holds::yes;
  return command.request.verb == ControllerVerb::stop ? stands_still(turn, command, progress) : progress.replied;
}

void check_command(Turn& turn, std::size_t index) {
  const auto& command = turn.station().safe[index];
  const auto& setup = turn.station().devices[command.device];
  const auto& device = turn.state.devices[command.device];
  auto& progress = turn.state.safe[index];
  if (!progress.due || is_resolved(progress)) return;
  if (is_confirmed(turn, command, progress)) {
    progress.confirmed = true;
    turn.note(EventKind::safe, say("{}: {} is confirmed {:.3g} s after the decision", Name{setup.name},
                                   Name{name(command.request.verb)}, turn.now() - turn.state.decided));
  } else if (device.lost && setup.stops_by_itself && command.request.verb == ControllerVerb::stop &&
             turn.reached(device.lost_at + *setup.stops_by_itself)) {
    progress.confirmed = true;
    turn.note(EventKind::safe, say("{}: no link; it has stopped by itself as its maker states", Name{setup.name}));
  } else if (turn.reached(progress.since + command.within)) {
    progress.overdue = true;
    turn.note(EventKind::safe, say("{}: {} is not confirmed after {:.3g} s", Name{setup.name},
                                   Name{name(command.request.verb)}, command.within));
  }
}

/// What of the safe list is not confirmed, and what a person has to do.
Sentence words_of_failure(const Turn& turn) {
  std::vector<Sentence> all;
  for (std::size_t i = 0; i < turn.state.safe.size(); ++i) {
    if (!turn.state.safe[i].overdue) continue;
    const auto& command = turn.station().safe[i];
    const auto& setup = turn.station().devices[command.device];
    const Name device{setup.name}, verb{name(command.request.verb)};
    const Sentence lost(turn.state.devices[command.device].lost ? ", and the link is lost" : "");
    const Sentence advice = command.words.empty()
                                ? say("Press the emergency stop of {}, and look whether it stands still.", device)
                                : say("{}", Name{command.words});
    all.push_back(say("{}: '{}' was not confirmed within {:.3g} s{}. {}", device, verb, command.within, lost, advice));
  }
  return in_a_row(all, " ");
}

void finish_safe(Turn& turn) {
  auto& state = turn.state;
  const bool failed = std::any_of(state.safe.begin(), state.safe.end(), [](const auto& one) { return one.overdue; });
  const RunEnding ending = failed ? RunEnding::faulted : state.ending;
  const Sentence text =
      failed ? say("THE RIG IS NOT SAFE. {} Reason of the stop: {}", words_of_failure(turn), state.reason)
             : state.reason;
  if (!failed)
    turn.note(EventKind::safe,
              say("the safe list is confirmed {:.3g} s after the decision", turn.now() - state.decided));
  RunRow row;
  row.kind = RunRow::Kind::run_ends;
  row.time = turn.now();
  row.ending = row_ending(ending);
  row.reason = text;
  write_row(turn, std::move(row));
  enter(turn, failed ? RunPhase::faulted : RunPhase::safe);
  turn.act(RunEnd{ending, text});
}

}  // namespace

void begin_safe(Turn& turn, RunPhase phase, RunEnding ending, Sentence reason) {
  auto& state = turn.state;
  if (!may_follow(state.phase, phase))
    return turn.note(EventKind::safe, say("{}: the run is {} already", reason, word_of(state.phase)));
  state.ending = ending;
  state.reason = std::move(reason);
  state.decided = turn.now();
  state.failures.clear();
  for (auto& device : state.devices) {
    device.waiting.clear();
    device.asked.reset();
    device.set_points.clear();
    device.next_poll = turn.now();
    if (state.phase == RunPhase::idle) device.heard = turn.now();
  }
  send_due(turn);  // before anything that writes to the disk
  send_waiting(turn);
  stop_streams(turn);
  close_prompt(turn);
  end_attempt(turn, row_ending(ending), state.reason);
  for (auto& axis : state.axes) {
    axis.ramping = false;
    axis.demand = Demand::none;
  }
  turn.note(EventKind::safe, say("the rig is brought to its safe state: {}", state.reason));
  enter(turn, phase);
}

void advance_safe(Turn& turn) {
  auto& state = turn.state;
  for (std::size_t i = 0; i < state.safe.size(); ++i) check_command(turn, i);
  send_due(turn);
  for (std::size_t i = 0; i < state.safe.size(); ++i) check_command(turn, i);
  if (std::all_of(state.safe.begin(), state.safe.end(), is_resolved)) finish_safe(turn);
}

void take_safe_reply(Turn& turn, std::size_t index, bool refused) {
  auto& progress = turn.state.safe[index];
  progress.replied = progress.replied || !refused;
  if (refused) progress.again = turn.now();
}

}  // namespace tumble::executive
