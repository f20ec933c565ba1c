#include <algorithm>
#include <limits>

#include "tumble/station/virtual_faults.hpp"

namespace tumble {
namespace {

constexpr double must_be_said = std::numeric_limits<double>::quiet_NaN();

}  // namespace

const std::vector<FaultRule>& fault_rules() {
  using Kind = FaultKind;
  using Place = FaultPlace;
  static const std::vector<FaultRule> rules{
      {Kind::drop_link, "drop_link", Place::link, {}, 0.0, true, "the connection is closed, and none can be made"},
      {Kind::half_open, "half_open", Place::link, {}, 0.0, true, "nothing arrives, and the connection stays open"},
      {Kind::delay, "delay", Place::link, {"s"}, must_be_said, true, "every message arrives later by this time"},
      {Kind::wrong_reply, "wrong_reply", Place::link, {"%"}, 1.0, true, "the message before arrives once more in its place"},
      {Kind::cut_line, "cut_line", Place::link, {"%"}, 1.0, true, "a message ends in its middle"},
      {Kind::garbage_byte, "garbage_byte", Place::link, {"%"}, 1.0, true, "a byte of noise stands in a message"},
      {Kind::crc_error, "crc_error", Place::link, {"%"}, 1.0, true, "one bit of a message is turned over"},
      {Kind::lost_frames, "lost_frames", Place::link, {"%"}, 1.0, true, "messages do not arrive"},
      {Kind::duplicated_frames, "duplicated_frames", Place::link, {"%"}, 1.0, true, "messages arrive twice"},
      {Kind::reordered_frames, "reordered_frames", Place::link, {"%"}, 1.0, true, "a message arrives after the next one"},
      {Kind::frozen_channel, "frozen_channel", Place::channel, {}, 0.0, true, "a channel shows what it showed"},
      {Kind::status_fails, "status_fails", Place::unit, {}, 0.0, true, "the status bits of the frames are not good"},
      {Kind::counter_wraps, "counter_wraps", Place::unit, {"1"}, 10.0, false,
       "the counter of the frames begins again after so many"},
      {Kind::clock_steps, "clock_steps", Place::unit, {"s"}, must_be_said, false, "the clock of the instrument jumps"},
      {Kind::unit_reboots, "unit_reboots", Place::unit, {"s"}, 2.0, false,
       "the instrument is off for this time, then starts anew"},
      {Kind::frozen_reading, "frozen_reading", Place::axis, {}, 0.0, true, "the sensor of the axis shows what it showed"},
      {Kind::stuck_rate, "stuck_rate", Place::axis, {}, 0.0, true, "the axis goes on as it does and obeys no command, stop included"},
      {Kind::overshoot, "overshoot", Place::axis, {"deg", "K"}, must_be_said, true,
       "each position is passed by so much before the axis comes back"},
      {Kind::never_settles, "never_settles", Place::axis, {"deg", "deg/s", "K"}, must_be_said, true,
       "the axis swings about what was commanded"},
      {Kind::drifting_rate, "drifting_rate", Place::axis, {"%/s"}, must_be_said, true, "the rate grows by so much of itself"},
      {Kind::limit_trip, "limit_trip", Place::axis, {}, 0.0, true, "the axis stops, and refuses until its fault is cleared"},
      {Kind::refused_command, "refused_command", Place::axis, {}, 0.0, true, "commands to the axis are refused, stop included"},
      {Kind::chamber_slow, "chamber_slow", Place::axis, {"%"}, must_be_said, true, "the air changes with this part of its speed"},
      {Kind::chamber_alarm, "chamber_alarm", Place::axis, {}, 0.0, true, "the chamber stops where it is, with an alarm"},
      {Kind::wrong_set_point, "wrong_set_point", Place::axis, {"K", "deg", "deg/s"}, must_be_said, true,
       "the axis goes so much beside what was commanded"},
  };
  return rules;
}

const FaultRule& rule_of(FaultKind kind) { return *std::ranges::find(fault_rules(), kind, &FaultRule::kind); }

}  // namespace tumble
