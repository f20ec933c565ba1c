#pragma once

#include <map>
#include <string>

#include "tumble/station/virtual_rig.hpp"
#include "tumble/wire/controller.hpp"

namespace tumble {

/// A controller in front of axes of a virtual rig: the first of `axes` is its axis 1, and so on.
struct VirtualDevice {
  std::string name;
  std::vector<std::string> axes;
};

/// What the controller answers, and what the rig does about it. Verbs are those of the executive: identify, take,
/// release, enable, disable, home, rate, position, sine, stop, read, state, clear_fault, set_temperature, set_ramp,
/// start, hold, off. A value that a verb needs and does not have, an axis that is not there and a motion that the rig
/// cannot make are refused.
ControllerReply answer(VirtualRig& rig, double time, const VirtualDevice& device, const ControllerRequest& request);

}  // namespace tumble
