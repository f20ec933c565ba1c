#include "tumble/station/link_wires.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tumble/units/error.hpp"

namespace tumble {
namespace wired {  // named, since Inner has them as members

constexpr double opened_within = 5.0;  ///< [s] the first time
constexpr double again_within = 0.2;   ///< [s] afterwards: nothing else is done in the meantime
constexpr double first_again = 0.2;    ///< [s] after it was lost: the rig may turn until it is told to stop
constexpr double again_after = 2.0;    ///< [s] between attempts

struct Wire {
  std::string name;
  std::optional<LinkAddress> address;  ///< absent: an instrument without a stream
  std::optional<std::size_t> link;     ///< absent: it is lost
  double again = 0.0;                  ///< [s] when to open it again
};

}  // namespace wired

using namespace wired;

struct LinkWires::Inner {
  Links links;
  std::function<double()> clock;
  double speed;
  std::vector<Wire> all;
  std::function<void(std::size_t, int)> changed;

  Inner(std::function<double()> time, double scale) : links(time), clock(std::move(time)), speed(scale) {}

  void add(const std::string& name, const std::string& link, Problems& problems) {
    Wire wire{name, {}, {}};
    try {
      if (!link.empty()) {
        wire.address = parse_link(link);
        wire.link = links.open(*wire.address, opened_within);
        // Names are not looked up again while axes may move: without a network that takes long.
        if (const auto peer = links.peer(*wire.link); !peer.empty()) wire.address->host = peer;
      }
    } catch (const Error& error) {
      for (const auto& problem : error.problems) problems.push_back(within(say("{}", Name{name}), problem));
    }
    all.push_back(std::move(wire));
  }

  /// Opens what was lost, one at a time.
  std::vector<LinkEvent> open_again() {
    const double now = clock();
    for (std::size_t w = 0; w < all.size(); ++w) {
      Wire& wire = all[w];
      if (!wire.address || wire.link || now < wire.again) continue;
      wire.again = now + again_after;
      try {
        wire.link = links.open(*wire.address, again_within);
        if (changed) changed(w, links.descriptor(*wire.link));
        return {{LinkEvent::Kind::up, w, clock(), {}, {}}};
      } catch (const Error&) {
        return {};  // it is tried again
      }
    }
    return {};
  }

  std::vector<LinkEvent> wait(double until) {
    std::vector<LinkEvent> events = open_again();
    if (!events.empty()) return events;
    for (LinkEvent& event : links.wait(std::max(0.0, until - clock()) / speed)) {
      const auto found = std::ranges::find(all, std::optional<std::size_t>(event.link), &Wire::link);
      if (found == all.end()) continue;
      event.link = static_cast<std::size_t>(found - all.begin());
      if (event.kind == LinkEvent::Kind::lost) {
        found->link.reset();
        found->again = event.time + first_again;
        if (changed) changed(event.link, -1);
      }
      events.push_back(std::move(event));
    }
    return events;
  }
};

LinkWires::LinkWires(const Station& station, std::function<double()> clock, double speed)
    : inner_(std::make_unique<Inner>(std::move(clock), speed)) {
  Problems problems;
  for (const StationDevice& device : station.devices) inner_->add(device.name, device.link, problems);
  for (const StationInstrument& instrument : station.instruments)
    inner_->add(instrument.slot, instrument.link, problems);
  if (!problems.empty()) throw Error(Error::Kind::bad_file, problems);
}

LinkWires::~LinkWires() = default;

int LinkWires::descriptor(std::size_t wire) const {
  const bool up = wire < inner_->all.size() && inner_->all[wire].link;
  return up ? inner_->links.descriptor(*inner_->all[wire].link) : -1;
}

void LinkWires::tell_changes(std::function<void(std::size_t wire, int descriptor)> tell) {
  inner_->changed = std::move(tell);
}

Wires LinkWires::wires() {
  return {.now = inner_->clock,
          .send =
              [this](std::size_t wire, std::string_view bytes) {
                if (wire < inner_->all.size() && inner_->all[wire].link)
                  inner_->links.send(*inner_->all[wire].link, bytes);
              },
          .wait = [this](double until) { return inner_->wait(until); }};
}

}  // namespace tumble
