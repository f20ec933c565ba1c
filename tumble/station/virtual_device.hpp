#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tumble/station/virtual_rig.hpp"
#include "tumble/wire/controller.hpp"

namespace tumble {

/// A controller in front of axes of a virtual rig, or of the power of its instruments.
struct VirtualDevice {
  std::string name;
  std::vector<std::string> axes;  ///< the first is axis 1 of the controller; "power": the supply of the instruments
  double voltage = 28.0, current = 1.0;  ///< [V], [A] of the supply, when it is on

  std::vector<Motion> profiles = {};  ///< random motions that the controller of a shaker has in store

  /// Values that the controller of a chamber remembers for each axis. After `off` a set point waits for `start`.
  struct Memory {
    bool off = false;
    double ramp = 0.0;  ///< [K/s]; 0: as fast as it can
    std::optional<double> set_point = {};
  };
  std::map<std::string, Memory> memory = {};
};

/// The verbs that `answer` knows, by name.
std::vector<std::string> virtual_verbs();

/// Answer of the controller, after the rig has done what is asked. Verbs are those of the executive: identify, take,
/// release, enable, disable, home, rate, position, sine, sweep, random, stop, read, state, clear_fault,
/// set_temperature, set_ramp, start, hold, off, resume, set_point, alarm, set_voltage, set_current, set_limits. A reply
/// carries all that the device knows: `position.2` is that of axis 2. A value that a verb needs and does not have, an
/// axis that is not there and a motion that the rig cannot make are refused. `time` [s].
ControllerReply answer(VirtualRig& rig, double time, VirtualDevice& device, const ControllerRequest& request);

}  // namespace tumble
