#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/channel.hpp"
#include "tumble/core/plan.hpp"
#include "tumble/core/schedule.hpp"

/// A rig with its instruments that carries out commands when they come: the simulator of sim/ with commands in place of
/// a schedule (docs/virtual_rig.md). Pure: time is passed in [s], and never goes back.
namespace tumble {

/// Report of the controller of an axis about it.
struct AxisReading {
  double value = 0.0;      ///< [SI of the axis] position or temperature, by the rig's own sensor where it has one
  double rate = 0.0;       ///< [SI of the axis per second] as that sensor shows it, over the last 0.2 s
  bool moving = false;     ///< on the way to what was commanded, or turning
  bool reached = false;    ///< it does what was commanded
  bool enabled = true;     ///< it takes commands
  std::string fault = {};  ///< empty: none
};

/// Outputs of the instruments and readings of the rig's sensors, one power-up without a gap.
struct VirtualSamples {
  int power_up = 1;
  std::size_t first = 0;               ///< [1] number of the first sample since the instruments were switched on
  std::vector<Channel> channels = {};  ///< as simulate() makes them; their timelines begin with the first sample
  std::size_t size() const { return channels.empty() ? 0 : channels.front().values.size(); }
};

/// When samples are given out.
enum class SampleTiming {
  at_once,  ///< a sample as soon as it has ended: as if the motion went on
  final,    ///< a few steps later, when no command can change it any more: the bytes of simulate()
};

/// Why a command was not carried out; empty: it was.
using Refusal = std::string;

class VirtualRig {
 public:
  /// The rig of the plan with its instruments switched off, all axes at rest at 0, a chamber at 20 degC. Numbers are
  /// drawn from `seed` as simulate() draws them.
  /// Throws Error::bad_input with all that the plan lacks: model, rig, sample rate, truth.
  VirtualRig(const Plan& plan, std::uint64_t seed, SampleTiming timing = SampleTiming::at_once);
  VirtualRig(const VirtualRig& other);  ///< the copy goes on by itself
  VirtualRig(VirtualRig&&) noexcept;
  VirtualRig& operator=(const VirtualRig& other);
  VirtualRig& operator=(VirtualRig&&) noexcept;
  ~VirtualRig();

  /// The names of the axes, temperature and shake among them.
  std::vector<std::string> axes() const;
  bool is_temperature(const std::string& axis) const;

  /// Gives a command to one axis; all others go on. `hold` of a turning axis goes there, `rate` 0 stops it. A sweep
  /// needs Motion::lasts. What the rig cannot do is refused, and the axis goes on as before. `time` [s].
  Refusal command(double time, const std::string& axis, const Motion& motion);
  /// Gives all axes at once the commands of a segment of a schedule: those that it does not mention come to rest.
  /// `time` [s].
  Refusal carry_out(double time, const Segment& segment);
  /// The axis brakes as fast as it can and stands; air stays as it is; a shake ends. `time` [s].
  Refusal stop(double time, const std::string& axis);
  /// A disabled axis stops, and takes no commands. `time` [s].
  void enable(double time, const std::string& axis, bool on);
  /// Ends a trip of the axis; the axis stands, and takes commands. `time` [s].
  void clear_fault(double time, const std::string& axis);

  /// Puts axes where they are to be before the test, air soaked through, at once. The instruments must be off.
  /// `time` [s].
  void place(double time, const std::map<std::string, double>& values);
  /// Switches the instruments. Each switching-on draws their turn-on anew. Where the rig stands still, it is to the rig
  /// as the begin of a run is to simulate(). `time` [s].
  void power(double time, bool on);
  /// Whether the drive of the axis obeys commands: not while it is stuck.
  bool obeys(const std::string& axis) const;
  /// Number of the power-up, from 1; 0: off.
  int power_up() const;

  /// `time` [s].
  AxisReading reading(double time, const std::string& axis);

  /// All samples that have ended at `time` and were not given out, in order, at most `most` in all. `time` [s].
  std::vector<VirtualSamples> samples(double time, std::size_t most = 1u << 20);

  /// Faults of the physics, of which virtual_faults.hpp makes use.
  enum class Trouble {
    frozen_reading,   ///< the sensor of the axis shows what it showed
    stuck,            ///< the drive goes on as it does and obeys no command
    overshoot,        ///< each position is passed by `size` before the axis goes there
    never_settles,    ///< swings about what was commanded by `size` [SI], 0.5 Hz
    drifting_rate,    ///< the rate grows by `size` [1/s] of itself
    limit_trip,       ///< the axis stops, is disabled, and refuses until its fault is cleared
    refuses,          ///< commands to the axis are refused
    slow,             ///< a chamber changes `size` times as fast as it could
    alarm,            ///< a chamber stops where it is with an alarm
    wrong_set_point,  ///< goes `size` beside what was commanded
  };
  /// From `time` on, until `end(axis, trouble)` for what lasts. The axis must be one of axes().
  /// `time` [s], `size` [SI of the trouble].
  void begin(double time, const std::string& axis, Trouble trouble, double size);
  /// `time` [s].
  void end(double time, const std::string& axis, Trouble trouble);

  const Plan& plan() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tumble
