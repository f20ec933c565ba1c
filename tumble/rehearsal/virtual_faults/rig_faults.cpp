#include <algorithm>
#include <cmath>

#include "tumble/rehearsal/virtual_faults.hpp"

namespace tumble {
namespace {

using Trouble = VirtualRig::Trouble;

/// What a fault of an axis is to the rig.
Trouble trouble_of(FaultKind kind) {
  switch (kind) {
    case FaultKind::stuck_rate:
      return Trouble::stuck;
    case FaultKind::overshoot:
      return Trouble::overshoot;
    case FaultKind::never_settles:
      return Trouble::never_settles;
    case FaultKind::drifting_rate:
      return Trouble::drifting_rate;
    case FaultKind::limit_trip:
      return Trouble::limit_trip;
    case FaultKind::refused_command:
      return Trouble::refuses;
    case FaultKind::chamber_slow:
      return Trouble::slow;
    case FaultKind::chamber_alarm:
      return Trouble::alarm;
    case FaultKind::wrong_set_point:
      return Trouble::wrong_set_point;
    default:
      return Trouble::frozen_reading;
  }
}

/// The counter as it must be now to begin again after `frames`.
std::uint64_t counter_before_wrap(const FrameCodec& codec, double frames) {
  for (const auto& frame : codec.frames)
    if (frame.counter && !frame.fields.empty()) {
      const auto steps =
          static_cast<std::uint64_t>(std::max(1.0, frames)) * std::max<std::uint64_t>(1, frame.counter->step);
      return frame.counter->modulus - steps % frame.counter->modulus;
    }
  return 0;
}

}  // namespace

RigFaults::RigFaults(const std::vector<VirtualFault>& faults) {
  for (const auto& fault : faults) {
    if (rule_of(fault.kind).place == FaultPlace::link) continue;
    changes_.push_back({fault.at, true, fault});
    if (fault.kind == FaultKind::unit_reboots)
      changes_.push_back({fault.at + fault.by, false, fault});
    else if (fault.lasts)
      changes_.push_back({fault.at + *fault.lasts, false, fault});
  }
  std::ranges::stable_sort(changes_, {}, &Change::time);
}

double RigFaults::next() const { return done_ < changes_.size() ? changes_[done_].time : HUGE_VAL; }

void RigFaults::carry_out(const Change& change, VirtualRig& rig, VirtualStream& stream) {
  const VirtualFault& fault = change.fault;
  switch (fault.kind) {
    case FaultKind::frozen_channel:
      return stream.freeze(fault.about, change.begins);
    case FaultKind::status_fails:
      return stream.set_status(!change.begins);
    case FaultKind::counter_wraps:
      return stream.set_counter(counter_before_wrap(stream.codec(), fault.by));
    case FaultKind::clock_steps:
      return stream.step_clock(fault.by);
    case FaultKind::unit_reboots:
      if (rig.power_up() > 0 || !change.begins) rig.power(change.time, !change.begins);
      return;
    default:
      if (change.begins)
        rig.begin(change.time, fault.about, trouble_of(fault.kind), fault.by);
      else
        rig.end(change.time, fault.about, trouble_of(fault.kind));
  }
}

void RigFaults::act(double time, VirtualRig& rig, VirtualStream& stream) {
  while (done_ < changes_.size() && changes_[done_].time <= time) carry_out(changes_[done_++], rig, stream);
}

}  // namespace tumble
