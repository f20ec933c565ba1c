#include <fmt/format.h>

#include "tumble/station/executive/turn.hpp"

namespace tumble::executive {
namespace {

bool is_poll(const PendingRequest& request) { return request.purpose == Purpose::poll; }

/// Whether the safe list waits for what the device says of itself.
bool is_awaited_by_safe_list(const Turn& turn, std::size_t device) {
  if (is_active(turn.state.phase)) return false;
  for (std::size_t i = 0; i < turn.state.safe.size(); ++i) {
    const auto& command = turn.station().safe[i];
    if (command.device == device && command.confirm && !turn.state.safe[i].confirmed) return true;
  }
  return false;
}

/// What reads the state of a device: all of its axes, and every fifth time its state and its alarms.
std::vector<ControllerRequest> polls_of(const Turn& turn, std::size_t device) {
  const auto& station = turn.station();
  const auto& setup = station.devices[device];
  std::vector<ControllerRequest> polls;
  if (setup.can(ControllerVerb::read)) {
    for (const auto& axis : station.axes)
      if (axis.device == device) polls.push_back({ControllerVerb::read, {}, axis.number});
    if (polls.empty()) polls.push_back({ControllerVerb::read});
  }
  for (auto& poll : polls_of_set_points(turn, device)) polls.push_back(std::move(poll));
  const bool often = polls.empty() || is_awaited_by_safe_list(turn, device);
  if (!often && turn.state.devices[device].turn % 5 != 0) return polls;
  for (const ControllerVerb verb : {ControllerVerb::state, ControllerVerb::alarm})
    if (setup.can(verb)) polls.push_back({verb});
  return polls;
}

/// The words by which a device says that it has stopped by itself.
bool reports_fault(const std::string& key, const std::string& word) {
  static const std::vector<std::string> good{"", "0", "no", "none", "false", "off", "ok", "clear"};
  if (key == "fault" || key == "alarm") return !has_word(good, word);
  return key == "state" && (word == "fault" || word == "alarm" || word == "limit");
}

void take_words(Turn& turn, std::size_t device, const ControllerReply& reply) {
  const auto& name = turn.station().devices[device].name;
  for (const auto& [key, word] : reply.words) {
    turn.state.channels[name + "." + key] = {word, turn.now()};
    if (reports_fault(key, word) && is_active(turn.state.phase) && turn.state.phase != RunPhase::preparing)
      begin_safe(turn, RunPhase::stopping, RunEnding::stopped,
                 say("{} reports {} '{}'{}", Name{name}, Name{key}, word,
                     reply.text.empty() ? Sentence() : say(": {}", reply.text)));
  }
}

/// The serial number that a device states must be the one of the station file.
void check_identity(Turn& turn, std::size_t device, const ControllerReply& reply) {
  const auto& setup = turn.station().devices[device];
  if (setup.identity.empty()) return;
  std::string said = reply.text;
  for (const auto& [key, word] : reply.words) said += " " + word;
  if (said.find(setup.identity) == std::string::npos)
    turn.state.failures[setup.name] =
        say("{} identifies itself as '{}', which does not contain '{}'", Name{setup.name}, said, setup.identity);
}

void take_refusal(Turn& turn, std::size_t device, const PendingRequest& request, const Sentence& text) {
  const auto& name = turn.station().devices[device].name;
  const Sentence refused = say("{} refuses {}: {}", Name{name}, Name{tumble::name(request.request.verb)}, text);
  turn.note(EventKind::refused, refused);
  auto& progress = turn.state.devices[device];
  if (request.purpose == Purpose::safe) return take_safe_reply(turn, request.safe, true);
  if (is_poll(request) || request.purpose == Purpose::verify) {
    if (++progress.refusals >= 3 && is_active(turn.state.phase))
      begin_safe(turn, RunPhase::stopping, RunEnding::stopped, say("{} refuses to be read: {}", Name{name}, text));
    return;
  }
  turn.state.failures[name] = refused;
}

void take_good_reply(Turn& turn, std::size_t device, const PendingRequest& request, const ControllerReply& reply) {
  auto& progress = turn.state.devices[device];
  progress.refusals = 0;
  take_reading(turn, device, request.request.axis, reply);
  take_set_point(turn, device, request.request.axis, reply);
  expect_set_point(turn, device, request.request);
  if (request.request.verb == ControllerVerb::identify) check_identity(turn, device, reply);
  if (request.purpose == Purpose::safe) {
    take_safe_reply(turn, request.safe, false);
    const bool by_state =
        turn.station().safe[request.safe].confirm && turn.station().devices[device].can(ControllerVerb::state);
    if (by_state) progress.waiting.push_front({{ControllerVerb::state}});
  }
  if (request.request.verb == ControllerVerb::stop)
    for (std::size_t i = 0; i < turn.station().axes.size(); ++i)
      if (turn.station().axes[i].device == device) turn.state.axes[i].at_rest = 0;
  take_words(turn, device, reply);
}

/// Nobody knows whether the device has carried the request out: it is read before anything is sent again.
void take_timeout(Turn& turn, std::size_t device) {
  auto& progress = turn.state.devices[device];
  const auto& setup = turn.station().devices[device];
  PendingRequest request = *progress.asked;
  progress.asked.reset();
  const ControllerVerb verb = request.request.verb;
  turn.note(EventKind::timeout,
            say("{} did not answer {} in {:.3g} s", Name{setup.name}, Name{name(verb)}, time_to_answer(setup, verb)));
  if (is_poll(request)) return;
  if (request.purpose == Purpose::safe) return take_safe_reply(turn, request.safe, true);
  const PendingRequest verify{
      {setup.can(ControllerVerb::read) ? ControllerVerb::read : ControllerVerb::state, {}, request.request.axis},
      Purpose::verify};
  if (request.purpose == Purpose::verify) {
    progress.waiting.push_front(request);
  } else if (std::ranges::find(setup.once, verb) != setup.once.end()) {
    turn.state.failures[setup.name] =
        say("{} did not answer {}, which is never sent twice: look at the device", Name{setup.name}, Name{name(verb)});
  } else if (request.sent >= most_sends || !(setup.can(ControllerVerb::read) || setup.can(ControllerVerb::state))) {
    turn.state.failures[setup.name] = say("{} did not answer {}", Name{setup.name}, Name{name(verb)});
  } else {
    progress.waiting.push_front(request);
    progress.waiting.push_front(verify);
  }
}

/// A link that is silent may still carry commands, so the safe list is sent on it too; one that is cut cannot.
void lose(Turn& turn, std::size_t device, const Sentence& reason, bool cut) {
  auto& progress = turn.state.devices[device];
  if (progress.lost && (progress.cut || !cut)) return;
  if (!progress.lost) progress.lost_at = turn.now();
  progress.lost = true;
  progress.cut = cut;
  progress.waiting.clear();
  progress.asked.reset();
  const Sentence text = say("the link to {} is lost: {}", Name{turn.station().devices[device].name}, reason);
  turn.note(EventKind::link, text);
  for (std::size_t i = 0; i < turn.state.safe.size(); ++i)
    if (turn.station().safe[i].device == device && !turn.state.safe[i].confirmed) turn.state.safe[i].sent = false;
  if (is_active(turn.state.phase)) begin_safe(turn, RunPhase::stopping, RunEnding::stopped, text);
}

bool can_be_polled(const StationDevice& device) {
  return device.can(ControllerVerb::read) || device.can(ControllerVerb::state);
}

/// A request that takes long is awaited until its own deadline.
double lost_time(const Turn& turn, std::size_t device) {
  const auto& setup = turn.station().devices[device];
  const auto& progress = turn.state.devices[device];
  const double silence = progress.heard + std::max(3.0 * setup.poll, setup.lost_after);
  const bool slow = progress.asked && setup.timeouts.contains(progress.asked->request.verb);
  return slow ? std::max(silence, progress.due) : silence;
}

/// What waits for its row of the journal lets readings pass, and nothing else.
std::deque<PendingRequest>::iterator next_to_send(Turn& turn, std::deque<PendingRequest>& waiting) {
  if (waiting.empty() || !waits_for_row(turn, waiting.front())) return waiting.begin();
  if (!turn.state.held_since) turn.state.held_since = turn.now();
  return std::find_if(waiting.begin(), waiting.end(), is_poll);
}

void send(Turn& turn, std::size_t device, PendingRequest request) {
  auto& progress = turn.state.devices[device];
  const auto& setup = turn.station().devices[device];
  ++request.sent;
  progress.due = turn.now() + time_to_answer(setup, request.request.verb);
  turn.act(Ask{setup.name, request.request, progress.due, request.purpose == Purpose::safe});
  progress.asked = std::move(request);
}

}  // namespace

double time_to_answer(const StationDevice& device, ControllerVerb verb) {
  const auto found = device.timeouts.find(verb);
  return found == device.timeouts.end() ? device.timeout : found->second;
}

std::size_t device_of(const Turn& turn, const std::string& name) {
  const auto& devices = turn.station().devices;
  const auto found = std::find_if(devices.begin(), devices.end(), [&](const auto& one) { return one.name == name; });
  return static_cast<std::size_t>(found - devices.begin());
}

void ask(Turn& turn, std::size_t device, const PendingRequest& request) {
  auto& waiting = turn.state.devices[device].waiting;
  waiting.insert(std::find_if(waiting.begin(), waiting.end(), is_poll), request);
}

bool outstanding(const Turn& turn, Purpose purpose) {
  const auto is = [purpose](const PendingRequest& request) { return request.purpose == purpose; };
  return std::any_of(turn.state.devices.begin(), turn.state.devices.end(), [&](const DeviceProgress& device) {
    return (device.asked && is(*device.asked)) || std::any_of(device.waiting.begin(), device.waiting.end(), is);
  });
}

void drop_requests(Turn& turn) {
  for (auto& device : turn.state.devices) {
    std::erase_if(device.waiting, [](const PendingRequest& request) { return !is_poll(request); });
    if (device.asked && !is_poll(*device.asked)) device.asked->purpose = Purpose::poll;  // its reply changes nothing
    device.set_points.clear();
  }
  turn.state.failures.clear();
}

void take_reply(Turn& turn, const DeviceReply& event) {
  const std::size_t device = device_of(turn, event.device);
  if (device == turn.state.devices.size())
    return turn.note(EventKind::refused, say("a reply of an unknown device {}", Name{event.device}));
  auto& progress = turn.state.devices[device];
  const auto& reply = event.reply;
  if (!reply.problem.empty())
    return turn.note(EventKind::reply, say("{}: not an answer: {}", Name{event.device}, reply.problem));
  if (reply.verb == ControllerVerb::notice) {
    turn.note(EventKind::notice, say("{}: {}", Name{event.device}, reply.text));
    return take_words(turn, device, reply);
  }
  if (progress.cut) return;
  if (!progress.asked || progress.asked->request.verb != reply.verb)
    return turn.note(EventKind::reply,
                     say("{}: a reply to {}, which is not awaited", Name{event.device}, Name{name(reply.verb)}));
  const PendingRequest request = *progress.asked;
  progress.asked.reset();
  progress.heard = turn.now();
  if (progress.lost) turn.note(EventKind::link, say("{} answers again", Name{event.device}));
  progress.lost = false;
  if (reply.refused)
    take_refusal(turn, device, request, reply.text);
  else
    take_good_reply(turn, device, request, reply);
}

void take_lost(Turn& turn, const LinkLost& lost) {
  const std::size_t device = device_of(turn, lost.device);
  if (device < turn.state.devices.size()) lose(turn, device, lost.reason, true);
}

void take_up(Turn& turn, const LinkUp& up) {
  const std::size_t device = device_of(turn, up.device);
  if (device == turn.state.devices.size() || !turn.state.devices[device].lost) return;
  auto& progress = turn.state.devices[device];
  progress.lost = progress.cut = false;
  progress.heard = progress.next_poll = turn.now();
  turn.note(EventKind::link, say("the link to {} is up again; the run does not go on by itself", Name{up.device}));
}

void check_timeouts(Turn& turn) {
  if (turn.state.phase == RunPhase::idle) return;
  for (std::size_t i = 0; i < turn.state.devices.size(); ++i) {
    auto& progress = turn.state.devices[i];
    if (progress.cut) continue;
    if (progress.asked && turn.reached(progress.due)) take_timeout(turn, i);
    check_set_points(turn, i);
    const auto& setup = turn.station().devices[i];
    if (!progress.lost && can_be_polled(setup) && turn.reached(lost_time(turn, i)))
      lose(turn, i, say("nothing was heard for {:.3g} s", turn.now() - progress.heard), false);
  }
}

void forgive(Turn& turn, double overslept) {
  turn.note(EventKind::late, say("nobody looked at the rig for {:.3g} s: this program was stopped, or the machine was "
                                 "busy; that time is no silence of the devices",
                                 overslept));
  for (auto& device : turn.state.devices) {
    device.heard += overslept, device.due += overslept;
    for (auto& one : device.set_points) one.due += overslept;
  }
  for (auto& [name, channel] : turn.state.channels) channel.time += overslept;
  for (auto& command : turn.state.safe) command.sent_at += overslept;  // what was read before it stays before it
  for (auto& stream : turn.state.streams) stream.due += overslept;
  for (auto& axis : turn.state.axes) {
    axis.turned_at.clear();  // what was read before is stamped late, and gives no rate with what is read now
    axis.watch.strange.reset();
    axis.watch.too_fast.reset();
    axis.watch.nearest_at += overslept;
  }
  turn.state.settle_by += overslept;
}

void send_waiting(Turn& turn) {
  for (std::size_t i = 0; i < turn.state.devices.size(); ++i) {
    auto& progress = turn.state.devices[i];
    auto& waiting = progress.waiting;
    if (progress.cut) continue;
    if (can_be_polled(turn.station().devices[i]) && turn.reached(progress.next_poll)) {
      if (std::none_of(waiting.begin(), waiting.end(), is_poll))
        for (auto& poll : polls_of(turn, i)) waiting.push_back({std::move(poll)});
      ++progress.turn;
      progress.next_poll = turn.now() + turn.station().devices[i].poll;
      turn.reached(progress.next_poll);
    }
    while (!progress.asked) {
      const auto next = next_to_send(turn, waiting);
      if (next == waiting.end()) break;
      PendingRequest request = std::move(*next);
      waiting.erase(next);
      if (request.sent == 0 || !has_effect(turn, i, request.request)) send(turn, i, std::move(request));
    }
    if (progress.asked) turn.reached(progress.due);
    for (const auto& one : progress.set_points) turn.reached(one.due);
    if (!progress.lost && can_be_polled(turn.station().devices[i])) turn.reached(lost_time(turn, i));
  }
}

}  // namespace tumble::executive
