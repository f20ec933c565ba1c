#pragma once

#include <chrono>
#include <cstdint>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "tumble/desk/run_plan.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/rehearsal/made_station.hpp"
#include "tumble/rehearsal/served_rig.hpp"
#include "tumble/units/error.hpp"

namespace tumble::testing {

/// [s]
inline double wall() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// A TCP port that nobody has, below those that a system gives to connections: none of these takes it meanwhile.
inline std::string free_address() {
  constexpr unsigned first = 20000, count = 12000;
  static std::mt19937 any{std::random_device{}()};
  Links links([] { return 0.0; });
  for (;;) {
    const auto port = static_cast<std::uint16_t>(first + any() % count);
    try {
      return "tcp:127.0.0.1:" + std::to_string(links.listen(port));
    } catch (const Error&) {  // somebody has it
    }
  }
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
