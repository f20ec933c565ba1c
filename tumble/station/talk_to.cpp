#include "tumble/station/talk_to.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tumble/station/conduct/device_line.hpp"

namespace tumble {
namespace {

/// Verbs that move nothing.
constexpr const char* harmless[] = {"identify", "state", "read"};

/// The first whole answer of the device, or why there is none.
ControllerReply answer_of(conduct::DeviceLine& line, std::size_t wire, const ControllerRequest& request,
                          const Wires& wires, double timeout) {
  ControllerReply reply;
  reply.verb = request.verb;
  reply.problem = fmt::format("no answer within {:g} s", timeout);
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

}  // namespace

std::vector<DeviceAnswer> talk_to(const Station& station, const StationParts& parts, const Wires& wires) {
  std::vector<DeviceAnswer> answers;
  for (std::size_t d = 0; d < station.devices.size(); ++d) {
    const StationDevice& device = station.devices[d];
    conduct::DeviceLine line(parts.controllers[d], [&](std::string_view bytes) { wires.send(d, bytes); });
    for (const char* verb : harmless) {
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
  std::vector<FrameStream> streams;
  streams.reserve(parts.streams.size());
  for (const auto& stream : parts.streams) streams.emplace_back(stream.codec);
  const double until = wires.now() + seconds;
  while (wires.now() < until)
    for (const LinkEvent& event : wires.wait(until)) {
      const std::size_t i = event.link - station.devices.size();
      if (event.kind == LinkEvent::Kind::bytes && event.link >= station.devices.size() && i < streams.size())
        streams[i].feed(event.bytes, [](const StreamFrame&) {});
    }
  std::vector<FrameCounts> counts;
  counts.reserve(streams.size());
  for (const auto& stream : streams) counts.push_back(stream.counts());
  return counts;
}

}  // namespace tumble
