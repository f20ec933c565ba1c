#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/plan.hpp"
#include "tumble/station/requirement.hpp"
#include "tumble/units/sentence.hpp"
#include "tumble/wire/controller.hpp"

namespace tumble {

/// When an axis counts as having reached what was demanded: its own readback, or `channel`, lies within the tolerances
/// for `hold` seconds. Absent tolerances are not asked for.
struct SettleRule {
  std::optional<double> value;       ///< position [rad] or temperature [K] against the demand
  std::optional<double> rate;        ///< [rad/s, K/s] against the demand; of a position or temperature: its slope
  double relative_rate = 0.0;        ///< added to `rate`, times the rate demanded [1]
  std::optional<double> rate_slope;  ///< [rad/s^2] slope of the rate, where a rate is demanded
  double hold = 1.0;                 ///< [s]
  double timeout = 60.0;             ///< [s] from the command, after which the attempt fails
  double soak = 0.0;                 ///< [s] to wait after it has settled, before recording
  std::string channel = {};          ///< observed in place of the axis: "unit.case.temperature"
};

/// Action after the attempts of a segment have failed.
enum class OnFailure { ask, skip, stop };

/// One axis of the rig as a controller drives it: value of the rig = sign * value of the controller + offset.
struct StationAxis {
  enum class Kind { angle, temperature, acceleration };
  std::string name;        ///< of the rig's axis, as plans call it
  std::size_t device = 0;  ///< index of its controller
  int number = 1;          ///< of the controller's axis
  Kind kind = Kind::angle;
  int sign = 1;
  double offset = 0.0;                     ///< [rad, K]
  std::optional<double> lowest, highest;   ///< [rad, K]
  std::optional<double> max_rate;          ///< [rad/s, K/s]
  std::optional<double> max_acceleration;  ///< [rad/s^2]; of a shaker [m/s^2]
  std::optional<double> clips_at;          ///< [1] standard deviations at which the drive clips a random motion
  std::optional<double> speed;             ///< [rad/s] of moves to a position, where the command carries it
  /// limited: turns are not repeated; wrapped: the controller's angle begins again after a turn; counted: it goes on
  /// after a turn, and the axis takes the nearest of the angles that differ by whole turns.
  enum class Turns { limited, wrapped, counted } turns = Turns::limited;
  double ramp_step = 10.0;  ///< [s] between the set points of a ramp, 10 to 60
  SettleRule settle = {};
  int retries = 1;
  OnFailure on_failure = OnFailure::ask;
};

/// A controller at its link.
struct StationDevice {
  std::string name;
  std::string controller;                            ///< shipped declaration, or a file
  std::map<std::string, std::string> settings = {};  ///< of the declaration
  std::string link;                                  ///< "tcp:HOST:PORT", "serial:DEVICE[:BAUD[:8N1]]"
  double poll = 0.1;                                 ///< [s]
  double timeout = 0.3;                              ///< [s] in which a request is answered
  std::map<ControllerVerb, double> timeouts = {};    ///< [s] of verbs that take longer
  double lost_after = 0.0;                           ///< [s] of silence; at least 3 polls
  std::optional<double> stops_by_itself =
      {};                                  ///< [s] after the host is silent, as the maker states; absent: it does not
  std::string identity = {};               ///< text that the reply to identify must contain: its serial number
  std::vector<ControllerVerb> verbs = {};  ///< that its declaration has
  std::vector<ControllerVerb> once = {};   ///< of these, those that are never sent again
  /// By verb, the values that a request may carry, and those without which it is refused; empty: not known.
  std::map<ControllerVerb, std::vector<std::string>> takes = {}, needs = {};
  /// How a set point is confirmed: the verb that reads it, and by how much the reading may differ [K]; absent: it
  /// is not.
  std::optional<ControllerVerb> set_point_verb = {};
  double set_point_step = 0.0;
  std::vector<ControllerVerb> prepare = {};  ///< verbs before the first motion, in order
  std::vector<ControllerVerb> finish = {};   ///< verbs after the last segment, in order

  bool can(ControllerVerb verb) const;
  /// Whether the verb may carry this value; true where nothing is known of the verb.
  bool may_carry(ControllerVerb verb, const std::string& value) const;
};

/// A place for a unit under test, and its stream.
struct StationInstrument {
  std::string slot;
  std::string frames;  ///< declaration of its stream, shipped or a file; empty: it has no stream of its own
  std::string link;
  double rate = 0.0;  ///< [Hz]; 0: not stated
  double lost_after =
      0.0;  ///< [s] without a byte while it is recorded, after which the unit drops out; 0: silence_of()
  /// The commands of its declaration start and stop the stream; parts_of() clears it where the declaration has none.
  bool start = false;
  double start_within = 30.0;  ///< [s] in which the stream must have started, else the unit drops out
  double answer_within = 2.0;  ///< [s] for a command that starts it, after which all are sent again
};

/// [s] that a stream may be silent while it is recorded: as stated, else 5 s, but at least 20 samples.
double silence_of(const StationInstrument& instrument);

/// Condition that must hold while a plan is carried out. A software interlock never replaces one of hardware.
struct StationInterlock {
  enum class Action { stop, hold };
  Requirement require;
  Action action = Action::stop;
  double debounce = 0.0;  ///< [s]
  double stale = 10.0;    ///< [s] after which a channel without news is not known, and the condition not met
};

/// One command of the safe list.
struct SafeCommand {
  std::size_t device = 0;
  ControllerRequest request;
  std::optional<Requirement> confirm;  ///< absent: of `stop`, rates read zero; of other verbs, the reply
  double within = 10.0;                ///< [s] from when it is sent
  bool wait = false;                   ///< is sent only when those before it are confirmed, or overdue
  std::string words = {};              ///< for a person, where it could not be confirmed
};

/// Equipment with a certificate.
struct StationEquipment {
  std::string name, serial, certificate;
  std::string due;  ///< "2027-03-01", the last day on which it may be used; empty: not stated
};

/// How the unit is switched off and on between power-ups.
struct StationPower {
  std::optional<std::size_t> device = {};  ///< a supply with the verbs off and start; absent: a person is asked
  double off_time = 60.0;                  ///< [s]
  double warm_up = 0.0;                    ///< [s] after it is switched on
};

/// A bench: which controller on which link is which axis of the rig, its limits, interlocks and safe list. Plans do not
/// name any of this, so that one plan runs on several benches.
struct Station {
  std::string file, sha256, text;
  std::string name;
  std::vector<StationDevice> devices;
  std::vector<StationAxis> axes;
  std::vector<std::string> by_hand;  ///< axes that a person moves: "mount_yaw"
  bool all_units = false;            ///< a unit that fails ends the run; else the others go on
  double answer_within = 600.0;      ///< [s] until a question that nobody answers holds the rig
  std::vector<StationInstrument> instruments;
  std::vector<StationInterlock> interlocks;
  std::vector<SafeCommand> safe;
  StationPower power;
  std::vector<StationEquipment> equipment;
};

/// Reads a station file (docs/station.md has its keys).
///
/// Throws    Error::bad_input with all problems, each with its line
///           Error::bad_file where it cannot be read
Station load_station(const std::string& path);

/// Reads a station from its text. Files that the station names are relative to the folder of `file`.
Station read_station(const std::string& text, const std::string& file);

/// The declaration that a device names: a shipped one, or a file relative to `folder`.
/// Throws Error::bad_input where it is not known or not sound; Error::bad_file where it cannot be read.
Controller controller_of_device(const StationDevice& device, const std::string& folder);

/// Request to carry out a plan at a station.
struct StationRequest {
  std::map<std::string, std::string> units = {};  ///< serial number by slot
  std::string date = {};                          ///< of today, "2026-11-24"
  bool rehearsed = false;                         ///< equipment may be out of calibration: nothing is measured
  std::string accept_expired = {};                ///< reason for which equipment out of calibration is accepted
};

/// Equipment whose calibration was due before that date, in words. Given: date "2026-11-24".
std::vector<Sentence> expired_equipment(const Station& station, const std::string& date);

/// All reasons why a plan cannot be carried out at a station, so that it is refused before anything moves.
Problems check_station(const Plan& plan, const Station& station, const StationRequest& request);

}  // namespace tumble
