#include "tumble/rehearsal/served_rig.hpp"

#include <chrono>

namespace tumble {

ServedRig::ServedRig(const Plan& plan, const Station& station, double speed, const std::vector<VirtualFault>& faults)
    : station_(station), parts_(parts_of(station_)), bench_(plan, station_, parts_, seed, faults) {
  using Clock = std::chrono::steady_clock;
  bench_.put(mounted_for(plan, station_));
  server_.emplace(
      bench_, station_,
      [begin = Clock::now(), speed] { return speed * std::chrono::duration<double>(Clock::now() - begin).count(); },
      speed);
  thread_ = std::thread([this] { server_->serve(ended_); });
}

ServedRig::~ServedRig() { end(); }

std::map<std::string, AxisReading> ServedRig::end() {
  ended_ = true;
  if (thread_.joinable()) thread_.join();
  return bench_.readings();
}

}  // namespace tumble
