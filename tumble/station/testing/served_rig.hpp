#pragma once

#include <atomic>
#include <chrono>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/station/made_station.hpp"
#include "tumble/station/run_plan.hpp"
#include "tumble/station/serve_bench.hpp"
#include "tumble/station/virtual_bench.hpp"

namespace tumble::testing {

/// [s]
inline double wall() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// A TCP port that nobody has.
inline std::string free_address() {
  Links links([] { return 0.0; });
  return "tcp:127.0.0.1:" + std::to_string(links.listen(0));
}

/// The station of a plan at free TCP ports of this machine. It waits long for answers, because tests run on machines
/// that have much else to do.
inline Station station_over_tcp(const Plan& plan, const ScratchFolder& scratch) {
  Station station = station_for(plan);
  station.file = scratch.file("station.toml");
  std::ofstream(scratch.file(std::string(made_frames_name))) << frames_for(plan);
  for (StationDevice& device : station.devices) {
    device.link = free_address();
    device.timeout = 5.0;
    device.lost_after = 15.0;
  }
  for (StationInstrument& instrument : station.instruments) instrument.link = free_address();
  return station;
}

/// A virtual rig that is served in a thread of its own, from now until it is destroyed.
class ServedRig {
 public:
  ServedRig(const Plan& plan, const Station& station, double speed, const std::vector<VirtualFault>& faults = {})
      : station_(station), parts_(parts_of(station_)), bench_(plan, station_, parts_, 1, faults) {
    bench_.put(mounted_for(plan, station_));
    server_.emplace(
        bench_, station_, [speed, begin = wall()] { return speed * (wall() - begin); }, speed);
    thread_ = std::thread([this] { server_->serve(stop_); });
  }
  ServedRig(const ServedRig&) = delete;
  ServedRig& operator=(const ServedRig&) = delete;
  ~ServedRig() { end(); }
  /// Where each wire is reached: devices, then instruments.
  const std::vector<std::string>& addresses() const { return server_->addresses(); }
  /// How the rig is, after its service has ended.
  std::map<std::string, AxisReading> end() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    return bench_.readings();
  }

 private:
  Station station_;
  StationParts parts_;
  VirtualBench bench_;
  std::optional<BenchServer> server_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// A run of that plan over the links of the station, whose questions are answered at once; after `most` [s] of the wall
/// it is stopped.
inline PlannedRunAtStation run_over_tcp(const Plan& plan, const Station& station, const std::string& folder,
                                        double speed, double most = 60.0) {
  PlannedRunAtStation run;
  run.plan = plan;
  run.station = station;
  run.folder = folder;
  run.units = {{"unit", "7"}};
  run.who = "a test";
  run.date = "2026-11-24";
  run.speed = speed;
  run.clock = wall;
  auto answers = std::make_shared<std::vector<decltype(RunEvent::what)>>();
  run.company.ask = [answers](const Prompt& prompt) {
    answers->push_back(PromptAnswer{prompt.id, prompt.standard, "a test"});
  };
  run.company.orders = [answers, until = wall() + most]() mutable {
    if (wall() > until) {
      until += 1e9;
      answers->push_back(RunOrder{RunOrder::Kind::stop, "the time of the test"});
    }
    return std::exchange(*answers, {});
  };
  return run;
}

}  // namespace tumble::testing
