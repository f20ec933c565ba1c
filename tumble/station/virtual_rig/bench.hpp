#pragma once

#include <cmath>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tumble/rigs/rig.hpp"
#include "tumble/sim/power_up.hpp"
#include "tumble/station/virtual_rig.hpp"
#include "tumble/station/virtual_rig/course.hpp"
#include "tumble/station/virtual_rig/unit.hpp"

namespace tumble::virtual_rig {

using Trouble = VirtualRig::Trouble;

/// The controller of one axis.
struct AxisControl {
  Axis axis;
  Motion demand = {};  ///< what was commanded last
  bool told = false;   ///< something was commanded
  bool enabled = true;
  std::string fault = {};
  std::map<Trouble, double> troubles = {};  ///< with their sizes
  double drifts_since = 0.0;                ///< [s]
  std::optional<AxisReading> frozen = {};
  unsigned commands = 0;  ///< what was planned for later is void after a further command
  /// [rad] whole turns that rates have made, which the drive adds to commanded positions (profile_of() of the rigs): a
  /// controller counts them
  double whole_turns = 0.0;

  bool has(Trouble trouble) const { return troubles.contains(trouble); }
  bool is_air() const { return axis.unit == "degC"; }
  bool turns() const;  ///< can keep a rate
};

/// Something that the rig does by itself after a command.
struct Later {
  enum class What { motion, trip, drift, swing };
  What what = What::motion;
  std::string axis;
  unsigned commands = 0;  ///< of the axis, when it was planned
  Motion motion = {};
  double sense = 1.0;  ///< of a swing
};

/// The courses of the rig, the instruments on it, and the controllers of its axes.
struct Bench {
  struct Powered {
    Unit unit;
    std::size_t course;
  };

  std::shared_ptr<const Plan> plan;
  const Rig* rig = nullptr;
  RandomStream random{0};
  SampleTiming timing = SampleTiming::at_once;
  std::vector<PlannedRun> planned = {};
  double now = 0.0;                       ///< [s]
  std::map<std::size_t, Course> courses;  ///< the last one is in force
  std::deque<Powered> units;              ///< the last one is on, where `on`
  bool on = false;
  int power_ups = 0;
  std::map<std::string, AxisControl> axes = {};
  std::multimap<double, Later> later = {};
  double soaks_since = -HUGE_VAL;  ///< [s] the air or the power of the instruments has changed

  Bench(const Plan& plan, std::uint64_t seed, SampleTiming timing);

  Course& course() { return courses.rbegin()->second; }
  AxisControl& control(const std::string& axis);  ///< throws Error::bad_input for an unknown axis
  /// `time` [s].
  DriveState drive(double time, const std::string& axis);

  /// Carries out what the rig does by itself up to this time. Throws Error::bad_input where time goes back. `time` [s].
  void advance(double time);

  // commands.cpp
  /// `time` [s].
  Refusal command(double time, const std::string& axis, const Motion& motion);
  /// `time` [s].
  Refusal carry_out(double time, const Segment& segment);
  /// `time` [s].
  void halt(double time, const std::string& axis);
  /// `time` [s], `size` [SI of the trouble].
  void begin(double time, const std::string& axis, Trouble trouble, double size);
  /// `time` [s].
  void end(double time, const std::string& axis, Trouble trouble);

  // power.cpp
  /// `time` [s].
  void place(double time, const std::map<std::string, double>& values);
  /// `time` [s].
  void power(double time, bool on);
  /// `time` [s].
  std::vector<VirtualSamples> samples(double time, std::size_t most);

  // refusals.cpp
  /// `time` [s].
  Refusal refusal_of(double time, const std::string& axis, const Motion& motion, double& trips_after);
  /// `time` [s].
  Motion standstill(double time, const std::string& axis);  ///< a motion that stays where the axis is or shall be

  /// `time` [s].
  AxisReading reading(double time, const std::string& axis);

 private:
  void start_course(double time, int run);
  void carry(double time, const Later& later);
  void enter(double time, const std::map<std::string, Motion>& changes, bool others_go_on);
  bool is_soaked(double time) const;
  /// The motion of a controller, whose positions count all turns, in the form that the drive needs. `time` [s].
  Motion without_turns(double time, AxisControl& control, Motion motion);
  Motion altered(double time, const AxisControl& control, const Motion& motion);
  void plan_later(double time, const std::string& axis, const Motion& motion, double trips_after);
  void apply(double time, const std::string& axis, const Motion& motion, double trips_after);
};

/// The motion by which an axis stops where it is at `value`. `value` [SI of the axis].
Motion stop_of(const AxisControl& control, double value);

}  // namespace tumble::virtual_rig
