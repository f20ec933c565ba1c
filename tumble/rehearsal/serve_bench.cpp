#include "tumble/rehearsal/serve_bench.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "tumble/units/error.hpp"

namespace tumble {
namespace serving {  // named, since Inner has them as members

constexpr double shortest_step = 0.001, longest_step = 0.02;  ///< [s] of the wall between two looks at the bench

/// Where one wire is reached, and who has opened it.
struct Door {
  std::string address;
  std::uint16_t port = 0;           ///< 0: a pseudo-terminal, or no link
  std::optional<std::size_t> link;  ///< that is open
};

}  // namespace serving

using namespace serving;

struct BenchServer::Inner {
  VirtualBench& bench;
  std::function<double()> clock;
  double speed;
  Links links;
  std::vector<Door> doors;
  std::vector<std::string> addresses;

  Inner(VirtualBench& served, std::function<double()> time, double scale)
      : bench(served), clock(time), speed(scale), links(std::move(time)) {}

  void add(const std::string& name, const std::string& link, Problems& problems) {
    Door door;
    try {
      if (!link.empty()) open(door, parse_link(link));
    } catch (const Error& error) {
      for (const auto& problem : error.problems) problems.push_back(within(say("{}", Name{name}), problem));
    }
    addresses.push_back(door.address);
    doors.push_back(std::move(door));
  }

  void open(Door& door, const LinkAddress& address) {
    if (address.kind == LinkAddress::Kind::tcp) {
      door.port = links.listen(address.port);
      door.address = fmt::format("tcp:127.0.0.1:{}", door.port);
      return;
    }
    const Links::Terminal terminal = links.open_terminal();
    door.link = terminal.link;
    door.address = "serial:" + terminal.device;
  }

  /// Moves the bench on to the clock, and sends what it has said.
  void follow() {
    const double now = clock();
    while (bench.now() < now)
      for (const LinkEvent& event : bench.wait(now)) {
        const Door& door = doors[event.link];
        if (!door.link) continue;
        if (event.kind == LinkEvent::Kind::bytes) links.send(*door.link, event.bytes);
        if (event.kind == LinkEvent::Kind::lost) links.close(*door.link);
      }
  }

  void take(const LinkEvent& event) {
    if (event.kind == LinkEvent::Kind::up) {
      const auto door = std::ranges::find(doors, event.port, &Door::port);
      if (door == doors.end() || event.port == 0) return;
      if (door->link && links.is_up(*door->link)) return links.close(event.link);  // one station at a time
      door->link = event.link;
      return;
    }
    const auto door = std::ranges::find(doors, std::optional<std::size_t>(event.link), &Door::link);
    if (door == doors.end()) return;
    if (event.kind == LinkEvent::Kind::lost) {
      if (door->port != 0) door->link.reset();
      return;
    }
    bench.send(static_cast<std::size_t>(door - doors.begin()), event.bytes);
  }
};

BenchServer::BenchServer(VirtualBench& bench, const Station& station, std::function<double()> clock, double speed)
    : inner_(std::make_unique<Inner>(bench, std::move(clock), speed)) {
  Problems problems;
  for (const StationDevice& device : station.devices) inner_->add(device.name, device.link, problems);
  for (const StationInstrument& instrument : station.instruments)
    inner_->add(instrument.slot, instrument.link, problems);
  if (!problems.empty()) throw Error(Error::Kind::bad_file, problems);
}

BenchServer::~BenchServer() = default;

const std::vector<std::string>& BenchServer::addresses() const { return inner_->addresses; }

void BenchServer::serve(const std::atomic<bool>& stop) {
  while (!stop) {
    const double ahead = (inner_->bench.next() - inner_->clock()) / inner_->speed;
    const auto events = inner_->links.wait(std::clamp(ahead, shortest_step, longest_step));
    inner_->follow();
    for (const LinkEvent& event : events) inner_->take(event);
    if (!events.empty()) inner_->follow();
  }
}

}  // namespace tumble
