#include "tumble/station/talk_to.hpp"

#include <algorithm>

#include "tumble/station/conduct/device_line.hpp"
#include "tumble/station/conduct/stream_line.hpp"

namespace tumble {
namespace {

/// Verbs that move nothing.
constexpr ControllerVerb harmless[] = {ControllerVerb::identify, ControllerVerb::state, ControllerVerb::read};

/// The first whole answer of the device, or why there is none.
ControllerReply answer_of(conduct::DeviceLine& line, std::size_t wire, const ControllerRequest& request,
                          const Wires& wires, double timeout) {
  ControllerReply reply;
  reply.verb = request.verb;
  reply.problem = say("no answer within {:g} s", timeout);
  const double until = wires.now() + timeout;
  auto replies = line.ask(request, wires.now());
  for (;;) {
    for (auto& one : replies) {
      if (one.verb == request.verb && one.problem.empty()) return one;
      if (!one.problem.empty()) reply.problem = one.problem;
    }
    replies.clear();
    if (wires.now() >= until) return reply;
    for (const LinkEvent& event : wires.wait(std::min(until, line.next()))) {
      if (event.link != wire) continue;
      if (event.kind == LinkEvent::Kind::lost) {
        reply.problem = event.reason;
        return reply;
      }
      for (auto& one : line.receive(event.bytes, event.time)) replies.push_back(std::move(one));
    }
    for (auto& one : line.at(wires.now())) replies.push_back(std::move(one));
  }
}

/// An instrument that is listened to.
struct Listening {
  FrameStream stream;
  conduct::StreamLine line;
  bool started = false;  ///< by us
};

void listen(std::vector<Listening>& all, std::size_t devices, const Wires& wires, double until) {
  while (wires.now() < until) {
    double due = until;
    for (const Listening& one : all) due = std::min(due, one.line.next());
    for (const LinkEvent& event : wires.wait(due)) {
      const std::size_t i = event.link - devices;
      if (event.kind != LinkEvent::Kind::bytes || event.link < devices || i >= all.size()) continue;
      const auto before = all[i].stream.counts().channel_frames;
      all[i].stream.feed(event.bytes, [](const StreamFrame&) {});
      all[i].line.receive(event.bytes, all[i].stream.counts().channel_frames > before, event.time);
    }
    for (Listening& one : all) one.line.at(wires.now());
  }
}

}  // namespace

std::vector<DeviceAnswer> talk_to(const Station& station, const StationParts& parts, const Wires& wires) {
  std::vector<DeviceAnswer> answers;
  for (std::size_t d = 0; d < station.devices.size(); ++d) {
    const StationDevice& device = station.devices[d];
    conduct::DeviceLine line(parts.controllers[d], [&](std::string_view bytes) { wires.send(d, bytes); });
    for (const ControllerVerb verb : harmless) {
      if (!device.can(verb)) continue;
      const double begin = wires.now();
      const auto timeout = device.timeouts.find(verb);
      auto reply = answer_of(line, d, {.verb = verb}, wires,
                             timeout == device.timeouts.end() ? std::max(1.0, device.timeout) : timeout->second);
      answers.push_back({device.name, verb, std::move(reply), wires.now() - begin});
    }
  }
  return answers;
}

std::vector<FrameCounts> listen_to(const Station& station, const StationParts& parts, const Wires& wires,
                                   double seconds) {
  std::vector<Listening> all;
  all.reserve(parts.streams.size());
  const std::size_t devices = station.devices.size();
  for (std::size_t i = 0; i < parts.streams.size(); ++i)
    all.push_back({FrameStream(parts.streams[i].codec),
                   conduct::StreamLine(
                       parts.streams[i].codec.link,
                       [&wires, wire = devices + i](std::string_view bytes) { wires.send(wire, bytes); }, seconds)});
  listen(all, devices, wires, wires.now() + seconds);
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].started = station.instruments[i].start && all[i].stream.counts().good == 0;
    if (all[i].started) all[i].line.start(wires.now());
  }
  const auto is_awaited = [](const Listening& one) { return one.started && one.stream.counts().good == 0; };
  for (const double until = wires.now() + 3.0 * seconds; wires.now() < until && std::ranges::any_of(all, is_awaited);)
    listen(all, devices, wires, std::min(until, wires.now() + 0.1 * seconds));
  std::vector<FrameCounts> counts;
  counts.reserve(all.size());
  for (Listening& one : all) {
    if (one.started) one.line.stop();
    counts.push_back(one.stream.counts());
  }
  return counts;
}

}  // namespace tumble
