#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tumble/rigs/chain/chain.hpp"
#include "tumble/rigs/rig.hpp"

namespace tumble::rigs {

/// An option that is a quantity.
Option quantity(std::string name, std::string unit, std::string fallback, std::string description);

/// An option that is a standard deviation, and the errors that are drawn with it.
struct Imperfection {
  Option option;
  std::vector<std::string> errors;
  bool each_segment = false;
};

/// The values of a rig's errors in one run.
class ErrorValues {
 public:
  ErrorValues(const std::vector<RigError>& list, const Matrix& values) : list_(list), values_(values) {}
  /// 0 when there is no error of this name, or none was drawn.
  double operator()(std::string_view name, std::size_t segment = 0) const;

 private:
  const std::vector<RigError>& list_;
  const Matrix& values_;
};

/// A driven axis of a machine.
struct MachineAxis {
  std::string name;
  std::string description;
  std::vector<Motion::Kind> motions;
  const char* max_rate;  ///< default, as a user writes it
  const char* max_acceleration;
  bool stops = true;  ///< may be given limits of travel
};

/// A rig made of turning axes that carries the instrument on a fixture. From this description follow its axes, options,
/// errors, refusals and what is felt.
struct Machine {
  std::vector<MachineAxis> axes;
  std::vector<Option> geometry;
  std::vector<Imperfection> imperfections;
  /// From the base to the fixture, with the errors of the geometry; index, scale and wobble are added to them.
  std::vector<Joint> (*joints)(const Settings& options, const ErrorValues& errors);
  /// Options of the geometry out of bounds; may be null.
  void (*check)(const Settings& options, std::vector<std::string>& problems);
};

/// What every machine has: level, azimuth, gravity, lever arm, mounting.
std::vector<Imperfection> common_imperfections();
/// Index zero, positioning and wobble of each of these axes.
std::vector<Imperfection> axis_imperfections(const std::vector<std::string>& axes);
/// Rate error and rate ripple of each of these axes.
std::vector<Imperfection> drive_imperfections(const std::vector<std::string>& axes);
/// Amplitude of the oscillations of each of these axes.
std::vector<Imperfection> oscillation_imperfections(const std::vector<std::string>& axes);

/// `lists` one after the other.
std::vector<Imperfection> joined(std::vector<std::vector<Imperfection>> lists);

std::vector<Axis> mount_axes();
std::vector<Axis> axes_of(const Machine& machine);
std::vector<Option> options_of(const Machine& machine);
std::vector<RigError> errors_of(const Machine& machine, const Settings& options);
std::vector<std::string> refusals_of(const Machine& machine, const Schedule& schedule, const Settings& options);
Reference reference_of(const Machine& machine, const RigRun& run);

/// The level frame at rest on the Earth.
Kinematics ground_of(const std::optional<Site>& site, double gravity_error);

/// Instrument from fixture for mount_roll, mount_pitch, mount_yaw in every segment, with the mounting errors.
std::vector<Pose> poses_of(const Schedule& run, const ErrorValues& errors);

/// Base from level, as the level and azimuth errors turn it.
Rotation base_from_level(const ErrorValues& errors);

/// Options that must be above zero, or not below it; all must be finite.
void check_bounds(const Settings& options, const std::vector<std::string>& positive,
                  const std::vector<std::string>& not_negative, std::vector<std::string>& problems);

/// Axes the rig lacks and motions that they cannot do. True when there is nothing of the kind.
bool check_axes(const std::vector<Axis>& axes, const Schedule& schedule, std::vector<std::string>& problems);

/// The segments of each power-up.
std::vector<Schedule> runs_of(const Schedule& schedule);

}  // namespace tumble::rigs
