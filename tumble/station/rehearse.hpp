#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/plan.hpp"
#include "tumble/core/progress.hpp"
#include "tumble/station/carry_out.hpp"
#include "tumble/station/disk.hpp"
#include "tumble/station/recorder_read.hpp"
#include "tumble/station/run_desk.hpp"
#include "tumble/station/virtual_faults.hpp"

namespace tumble {

/// Settings of a rehearsal.
struct Rehearsal {
  Plan plan;
  std::optional<Station> station = {};  ///< absent: one is made from the plan's rig
  std::vector<VirtualFault> faults = {};
  std::uint64_t seed = 1;
  std::string folder;          ///< of the run, which must not be there yet
  bool resume = false;         ///< it is there, and was interrupted: it is carried on with the rig at rest
  Disk* disk = nullptr;        ///< that the run is recorded on; absent: one without faults
  std::string recording = {};  ///< file that it is sealed into; empty: as seal() chooses
  std::map<std::string, std::string> units = {};    ///< serial number by slot; absent: that of the plan
  std::function<void(double simulated)> pace = {};  ///< waits until this time [s] may be; absent: as fast as it goes
  RunDesk* desk = nullptr;                          ///< where others watch it and give orders
  double speed = 0.0;                               ///< [1] that `pace` keeps; 0: as fast as it goes
  RunCompany company = {};  ///< `ask` and `orders` are played by the rehearsal where they are empty
};

/// How it went.
struct Rehearsed {
  RunEnd end;
  double simulated = 0.0;  ///< [s]
  std::vector<SealedRecording> recordings;
  std::map<std::string, AxisReading> axes;  ///< how the rig was left
};

/// Carries a plan out on a virtual rig over its protocols, in simulated time as fast as it goes: prompts are answered
/// at once, and recorded as rehearsed.
///
/// Throws    Error::bad_input with every reason for which the plan cannot be carried out at the station;
///           Error::bad_file where the run cannot be written
Rehearsed rehearse(const Rehearsal& rehearsal, const Progress& progress = {});

}  // namespace tumble
