#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/math/random.hpp"
#include "tumble/station/virtual_rig.hpp"
#include "tumble/station/virtual_stream.hpp"

namespace tumble {

/// Kinds of faults that a virtual rig can have (docs/virtual_rig.md).
enum class FaultKind {
  // of a link: what happens to its messages
  drop_link,
  half_open,
  delay,
  wrong_reply,
  cut_line,
  garbage_byte,
  crc_error,
  lost_frames,
  duplicated_frames,
  reordered_frames,
  // of the instrument
  frozen_channel,
  status_fails,
  counter_wraps,
  clock_steps,
  unit_reboots,
  // of an axis
  frozen_reading,
  stuck_rate,
  overshoot,
  never_settles,
  drifting_rate,
  limit_trip,
  refused_command,
  chamber_slow,
  chamber_alarm,
  wrong_set_point,
};

/// Where a fault is: the key of a fault file that names what it is about.
enum class FaultPlace { link, unit, channel, axis };

/// Keys of a fault file for one kind of fault.
struct FaultRule {
  FaultKind kind;
  const char* name;  ///< in the file
  FaultPlace place;
  std::vector<const char*> by_units;  ///< of its size, one of them; empty: it has none
  double by;                          ///< [SI] its size, where the file does not say it; NaN: it must
  bool lasts;                         ///< it has an end: `for`
  const char* summary;
};
const std::vector<FaultRule>& fault_rules();
const FaultRule& rule_of(FaultKind kind);

/// One fault, and how a run in which it happens should end.
struct VirtualFault {
  FaultKind kind = FaultKind::drop_link;
  std::string name = {};              ///< of the entry, for reports
  std::string about = {};             ///< the link, channel or axis; empty for links: all
  double at = 0.0;                    ///< [s]
  std::optional<double> random = {};  ///< [1/s] how often, in place of a time
  std::optional<double> lasts = {};   ///< [s]; absent: once, or until the end where it lasts
  double by = 0.0;                    ///< [SI]
  std::string ends;                   ///< complete, aborted, stopped, failed, error, faulted
  std::string finding = {};           ///< that the run should have; empty: none
  std::optional<double> within = {};  ///< [s] from the fault to the confirmed end
};

/// Reads a file of faults: [[fault]] with kind, name, link | channel | axis, at or random, for, by, ends, finding,
/// within.
/// Throws Error::bad_input with all problems, each with its line, unknown keys and kinds with the nearest known one.
std::vector<VirtualFault> read_faults(std::string_view text, const std::string& file);

/// Each fault at its time; those at random as often as a Poisson process has them up to `until` [s]. In order of time.
std::vector<VirtualFault> timed_faults(const std::vector<VirtualFault>& faults, std::uint64_t seed, double until);

/// Faults that a link applies to messages: each is a reply, a command or a frame. A pure filter in simulated time.
class LinkFaults {
 public:
  /// Given: faults with their times (timed_faults); those of other links and of other places are not used.
  LinkFaults(const std::vector<VirtualFault>& faults, std::string link, std::uint64_t seed);

  /// Bytes that arrive of a message which is sent at `time` [s], with their times. `time` never goes back.
  std::vector<TimedBytes> pass(double time, std::string_view message);
  /// False while the link is dropped: a connection is closed, and none can be made. `time` [s].
  bool is_up(double time) const;

 private:
  struct Active {
    VirtualFault fault;
    bool spent = false;  ///< has hit the one message that it is for
  };
  bool hits(Active& active, double time);
  void change(FaultKind kind, std::string& message);

  std::string link_;
  std::vector<Active> faults_;
  RandomStream random_;
  std::uint64_t drawn_ = 0;
  std::string last_;                         ///< the message before
  std::optional<std::string> waiting_ = {};  ///< that comes after the next one
  double last_time_ = 0.0;                   ///< [s] of the last delivery
};

/// Carries out the faults of rig and instrument at their times.
class RigFaults {
 public:
  /// Given: faults with their times (timed_faults); those of links are not used.
  explicit RigFaults(const std::vector<VirtualFault>& faults);

  /// When the next one begins or ends [s]; infinity: none.
  double next() const;
  /// All that begins and ends up to `time` [s]. Samples up to each of these times must have been taken before.
  void act(double time, VirtualRig& rig, VirtualStream& stream);

 private:
  struct Change {
    double time;
    bool begins;
    VirtualFault fault;
  };
  static void carry_out(const Change& change, VirtualRig& rig, VirtualStream& stream);

  std::vector<Change> changes_;
  std::size_t done_ = 0;
};

}  // namespace tumble
