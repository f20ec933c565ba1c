#include "tumble/rehearsal/virtual_bench.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <optional>
#include <queue>
#include <utility>

#include "tumble/rehearsal/virtual_device.hpp"
#include "tumble/rehearsal/virtual_rig.hpp"
#include "tumble/rehearsal/virtual_speech.hpp"
#include "tumble/rehearsal/virtual_stream.hpp"
#include "tumble/rehearsal/virtual_switch.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace virtual_bench {  // named, since Inner has them as members

constexpr double never = std::numeric_limits<double>::infinity();
constexpr double on_the_way = 0.001;   ///< [s] of a message
constexpr double stream_every = 0.05;  ///< [s] of frames that arrive together

/// A controller, with what stands between its axes and those of the rig.
struct Controlled {
  const Controller& controller;
  ControllerDevice protocol;
  VirtualDevice device;
  std::map<int, StationAxis> axes;  ///< by the controller's number
  LinkFaults faults;
};

struct Streaming {
  std::size_t wire = 0;
  VirtualStream stream;
  LinkFaults faults;
  VirtualSwitch commands;
};

/// A value of the controller as that of the rig, or back.
double converted(const StationAxis& axis, std::string_view name, double value, bool to_rig) {
  if (name == "position" || name == "temperature" || name == "set_point")
    return to_rig ? axis.sign * value + axis.offset : axis.sign * (value - axis.offset);
  return name == "rate" || name == "amplitude" ? value * axis.sign : value;
}

/// `rate.2` is that of axis 2, `rate` that of `asked`.
void convert(std::map<std::string, double>& values, const std::map<int, StationAxis>& axes, int asked, bool to_rig) {
  for (auto& [name, value] : values) {
    const auto point = name.find('.');
    const auto axis = axes.find(point == std::string::npos ? asked : std::atoi(name.c_str() + point + 1));
    if (axis != axes.end()) value = converted(axis->second, std::string_view(name).substr(0, point), value, to_rig);
  }
}

std::vector<Motion> random_motions(const Schedule& schedule) {
  std::vector<Motion> motions;
  for (const Segment& segment : schedule)
    for (const auto& [axis, motion] : segment.axes)
      if (motion.kind == Motion::Kind::random) motions.push_back(motion);
  return motions;
}

struct Arrival {
  LinkEvent event;
  std::uint64_t order = 0;
  bool operator>(const Arrival& other) const {
    return event.time != other.event.time ? event.time > other.event.time : order > other.order;
  }
};

std::string name_of_link(const StationInstrument& instrument) {
  return instrument.slot.empty() ? "instrument" : instrument.slot;
}

}  // namespace virtual_bench

using namespace virtual_bench;

struct VirtualBench::Inner {
  VirtualRig rig;
  std::vector<Controlled> controlled;
  std::vector<Streaming> streaming;
  std::vector<bool> up;  ///< by wire
  RigFaults faults;
  VirtualStream spare;  ///< faults of an instrument act on the first stream, or on this one
  std::priority_queue<Arrival, std::vector<Arrival>, std::greater<>> arrivals;
  std::uint64_t order = 0;
  double now = 0.0, next_stream = stream_every;
  std::uint64_t streamed = 1;  ///< portions, of which the next is due then
  int power_up = 0;            ///< that the instruments are in; 0: they are off
  bool commanded = false;      ///< a stream is started by commands
  bool faulty;                 ///< frames are handed on one by one, since each may be hit

  Inner(const Plan& plan, std::uint64_t seed, const std::vector<VirtualFault>& timed)
      : rig(plan, seed),
        faults(timed),
        spare(read_frames(frames_for(plan), "frames"), plan.sample_rate),
        faulty(!timed.empty()) {}

  VirtualStream& stream() { return streaming.empty() ? spare : streaming.front().stream; }

  void arrive(std::size_t wire, double time, std::string bytes) {
    arrivals.push({{LinkEvent::Kind::bytes, wire, time, std::move(bytes), {}}, order++});
  }

  void deliver(std::size_t wire, LinkFaults& link, const std::string& bytes) {
    for (TimedBytes& message : link.pass(now, bytes)) arrive(wire, message.time + on_the_way, std::move(message.bytes));
  }

  /// All that the instruments have sent until now.
  void stream_on() {
    note_power();
    for (const VirtualSamples& samples : rig.samples(now))
      for (Streaming& one : streaming) {
        if (!one.commands.streams()) continue;
        if (!faulty) {
          std::string together;
          one.stream.append_frames(samples, together);
          if (!together.empty()) arrive(one.wire, now, std::move(together));
          continue;
        }
        for (TimedBytes& frame : one.stream.frames_of(samples))
          for (TimedBytes& message : one.faults.pass(frame.time, frame.bytes))
            arrive(one.wire, std::max(now, message.time), std::move(message.bytes));
      }
  }

  /// What was told to an instrument before it was switched on is forgotten.
  void note_power() {
    const int is = rig.power_up();
    if (is != 0 && is != power_up)
      for (Streaming& one : streaming) one.commands.power_on();
    power_up = is;
  }

  void look_at_links() {
    const auto look = [&](std::size_t wire, const LinkFaults& link) {
      const bool is_up = link.is_up(now);
      if (is_up == up[wire]) return;
      up[wire] = is_up;
      arrivals.push(
          {{is_up ? LinkEvent::Kind::up : LinkEvent::Kind::lost, wire, now, {}, "the other side closed it"}, order++});
    };
    for (std::size_t d = 0; d < controlled.size(); ++d) look(d, controlled[d].faults);
    for (const Streaming& one : streaming) look(one.wire, one.faults);
  }

  /// What the device does about a request, axis by axis, and says.
  ControllerReply reply_to(Controlled& one, const ControllerRequest& request) {
    const auto single = axis_by_axis(one.controller, request);
    ControllerReply reply{request.verb};
    for (const ControllerRequest& each : single) {
      const auto axis = static_cast<std::size_t>(each.axis - 1);
      if (single.size() > 1 && (axis >= one.device.axes.size() || one.device.axes[axis].empty())) continue;
      ControllerReply part = answer(rig, now, one.device, each);
      part.refused |= reply.refused;
      if (part.text.empty())
        part.text = reply.text;
      else if (!reply.text.empty())
        part.text = say("{}; {}", reply.text, part.text);
      reply = std::move(part);
    }
    reply.verb = request.verb;
    return reply;
  }

  /// What an instrument is told: it hears it while it has power.
  void receive_by_instrument(std::size_t wire, std::string_view bytes) {
    const auto one = std::ranges::find(streaming, wire, &Streaming::wire);
    if (one == streaming.end() || rig.power_up() == 0) return;
    stream_on();  // what it has sent before
    note_power();
    if (const std::string answer = one->commands.receive(bytes); !answer.empty()) deliver(wire, one->faults, answer);
  }

  void receive(std::size_t wire, std::string_view bytes) {
    if (commanded) stream_on();  // before the power may change
    Controlled& one = controlled[wire];
    for (ControllerRequest request : one.protocol.feed(bytes)) {
      convert(request.values, one.axes, request.axis, true);
      ControllerReply reply = reply_to(one, request);
      convert(reply.values, one.axes, reply.axis, false);
      one.protocol.answer(in_words_of(one.controller, std::move(reply)));
    }
    if (const std::string output = one.protocol.output(); !output.empty()) deliver(wire, one.faults, output);
  }
};

double random_faults_until(const Plan& plan) {
  double until = 86400.0;
  for (const Segment& segment : plan.schedule) until += 2.0 * segment.duration;
  return until;
}

VirtualBench::VirtualBench(const Plan& plan, const Station& station, const StationParts& parts, std::uint64_t seed,
                           const std::vector<VirtualFault>& faults)
    : inner_(std::make_unique<Inner>(plan, seed, faults)) {
  const auto axes = inner_->rig.axes();
  Problems problems;
  for (std::size_t d = 0; d < station.devices.size(); ++d) {
    const Controller& controller = parts.controllers[d];
    Controlled one{controller, ControllerDevice(controller), {}, {}, LinkFaults(faults, station.devices[d].name, seed)};
    one.device.name = station.devices[d].name;
    one.device.profiles = random_motions(plan.schedule);
    for (const StationAxis& axis : station.axes) {
      if (axis.device != d) continue;
      if (std::ranges::find(axes, axis.name) == axes.end())
        problems.push_back(
            say("the rig of the plan has no axis '{}', which {} drives", axis.name, Name{one.device.name}));
      one.axes.emplace(axis.number, axis);
      if (one.device.axes.size() < static_cast<std::size_t>(axis.number))
        one.device.axes.resize(static_cast<std::size_t>(axis.number));
      one.device.axes[static_cast<std::size_t>(axis.number) - 1] = axis.name;
    }
    if (station.power.device == d) one.device.axes = {"power"};
    inner_->controlled.push_back(std::move(one));
  }
  for (std::size_t i = 0; i < station.instruments.size(); ++i)
    if (!station.instruments[i].frames.empty())
      inner_->streaming.push_back(
          {station.devices.size() + i, VirtualStream(parts.streams[i].codec, plan.sample_rate),
           LinkFaults(faults, name_of_link(station.instruments[i]), seed),
           VirtualSwitch(station.instruments[i].start ? parts.streams[i].codec.link : FrameLink())});
  inner_->commanded = std::ranges::any_of(station.instruments, &StationInstrument::start);
  inner_->up.assign(station.devices.size() + station.instruments.size(), true);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  if (!station.power.device) inner_->rig.power(0.0, true);  // nobody else would switch the unit on
}

VirtualBench::~VirtualBench() = default;
VirtualBench::VirtualBench(VirtualBench&&) noexcept = default;

double VirtualBench::now() const { return inner_->now; }

void VirtualBench::send(std::size_t wire, std::string_view bytes) {
  if (wire >= inner_->up.size() || !inner_->up[wire]) return;
  if (wire < inner_->controlled.size())
    inner_->receive(wire, bytes);
  else
    inner_->receive_by_instrument(wire, bytes);
}

double VirtualBench::next() const {
  const Inner& bench = *inner_;
  const double arrival = bench.arrivals.empty() ? never : bench.arrivals.top().event.time;
  return std::min({arrival, bench.next_stream, std::max(bench.now, bench.faults.next())});
}

std::vector<LinkEvent> VirtualBench::wait(double until) {
  Inner& bench = *inner_;
  for (;;) {
    std::vector<LinkEvent> events;
    while (!bench.arrivals.empty() && bench.arrivals.top().event.time <= bench.now) {
      events.push_back(std::move(const_cast<Arrival&>(bench.arrivals.top()).event));  // its order stays
      bench.arrivals.pop();
    }
    if (!events.empty() || bench.now >= until) return events;
    bench.now = std::min(until, next());
    if (bench.now >= bench.faults.next()) {
      bench.stream_on();
      bench.faults.act(bench.now, bench.rig, bench.stream());
    }
    if (bench.now >= bench.next_stream) {
      bench.next_stream = static_cast<double>(++bench.streamed) * stream_every;
      bench.stream_on();
    }
    bench.look_at_links();
  }
}

void VirtualBench::put(const std::map<std::string, double>& axes) {
  if (inner_->rig.power_up() == 0) return inner_->rig.place(inner_->now, axes);
  Segment by_hand;
  for (const auto& [axis, value] : axes) by_hand.axes[axis] = {.value = value};
  if (const auto why = inner_->rig.carry_out(inner_->now, by_hand); !why.empty())
    throw Error(Error::Kind::bad_input, say("it cannot be put there by hand: {}", Sentence(why.c_str())));
}

void VirtualBench::power(bool on) { inner_->rig.power(inner_->now, on); }

std::map<std::string, AxisReading> VirtualBench::readings() {
  std::map<std::string, AxisReading> readings;
  for (const std::string& axis : inner_->rig.axes()) readings[axis] = inner_->rig.reading(inner_->now, axis);
  return readings;
}

std::map<std::string, double> mounted_for(const Plan& plan, const Station& station) {
  std::map<std::string, double> mounted;
  for (const Segment& segment : plan.schedule)
    for (const auto& [axis, motion] : segment.axes)
      if (std::ranges::find(station.by_hand, axis) != station.by_hand.end()) mounted.emplace(axis, motion.value);
  return mounted;
}

Wires VirtualBench::wires() {
  return {.now = [this] { return now(); },
          .send = [this](std::size_t wire, std::string_view bytes) { send(wire, bytes); },
          .wait = [this](double until) { return wait(until); }};
}

}  // namespace tumble
