#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tumble/core/plan.hpp"
#include "tumble/core/recording.hpp"
#include "tumble/math/matrix.hpp"
#include "tumble/math/random.hpp"
#include "tumble/math/rotation.hpp"
#include "tumble/models/model.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble {

/// One axis of a rig and how a plan may move it.
struct Axis {
  std::string name;
  std::string unit;  ///< of its position
  std::vector<Motion::Kind> motions;
  std::string description;
};

/// One way in which a rig departs from what the plan says. The simulator draws it, the budget of an estimate
/// differences the rig with respect to it, and a prediction does the same before the test.
struct RigError {
  std::string name;           ///< as budgets name it: "level of the table axis, east"
  double sd = 0.0;            ///< [SI]; 0: not present
  bool each_segment = false;  ///< drawn anew for every segment (repeatability of a position); else once for all runs
};

/// One power-up to be carried out.
struct RigRun {
  Schedule segments;
  Settings options;  ///< resolved against the rig's
  std::optional<Site> site;
  double rate = 1.0;  ///< [Hz] at which it will be asked; a rig with a state of its own keeps it at this rate
  Matrix errors;  ///< value of every error (row, in the order of Rig::errors) in every segment (column); empty: all 0
  RandomStream random{0};  ///< what cannot be commanded: draughts, tremor, random vibration
};

/// A channel that the rig records: an encoder, a thermometer, a reference accelerometer.
struct Sensor {
  Channel channel;                                                                  ///< without values
  std::function<void(double first, double step, std::span<double> readings)> read;  ///< times as in Reference::felt
};

/// State of an axis as the rig's own controller knows it.
struct DriveState {
  double value = 0.0;    ///< [SI of the axis] where the drive is, without what its sensor reads wrong
  double rate = 0.0;     ///< [SI of the axis per second]
  bool reached = false;  ///< it does what was commanded
};

/// An axis that a controller moves, and its state at a time [s] as in Reference::felt.
struct Drive {
  std::string axis;
  std::function<DriveState(double time)> at;
};

/// Where a part of a rig is.
struct PartPlacement {
  Rotation part_from_level;
  Vector3 origin;  ///< [m] from the base, in level axes
};

/// A part of a rig that moves as one, for pictures of the test.
struct RigPart {
  std::string name;     ///< of the axis that moves it; "instrument" for the instrument
  Vector3 axis = {};    ///< unit vector in the part's own axes; zero: it is carried by the part before
  bool slides = false;  ///< along its axis; else it turns about it
  std::function<PartPlacement(double time)> at;  ///< time [s] as in Reference::felt
};

/// Motion that the instrument feels during one power-up. Times are [s] since its beginning; a sample stamped t means
/// the interval from t to t + 1/rate and is asked for at its middle.
struct Reference {
  /// At first, first + step, ... Blocks may be asked for in any order and from several threads.
  std::function<void(double first, double step, std::span<Felt> felt)> felt;
  /// Until when what is felt stays as it is at `time`, since_power_on apart; `time` itself where it changes. Null:
  /// always.
  std::function<double(double time)> steady_until;
  std::vector<double> settled;  ///< a segment each: when all axes had reached the motion commanded
  std::vector<Sensor> sensors;
  std::vector<Drive> drives;   ///< an axis each that can be commanded
  std::vector<RigPart> parts;  ///< from the base to the instrument, which is the last
};

/// A catalogue entry of rigs/: turns one power-up of a schedule into what the instrument feels.
struct Rig {
  const char* name;
  const char* summary;
  std::vector<Axis> (*axes)();
  std::vector<Option> (*options)();
  /// Errors of the rig; those of gravity and latitude follow from the site where the options do not state them.
  std::vector<RigError> (*errors)(const Settings& options, const std::optional<Site>& site);
  Reference (*reference)(const RigRun& run);
  /// Everything in the schedule the rig cannot do, and every option out of bounds, as messages; empty: it can.
  Problems (*refusals)(const Schedule& schedule, const Settings& options);
};

/// The entry of that name, or Error::unsupported with the nearest known name.
const Rig& find_rig(std::string_view name);

/// All entries, in the order of their names.
const std::vector<const Rig*>& rig_catalogue();

}  // namespace tumble
