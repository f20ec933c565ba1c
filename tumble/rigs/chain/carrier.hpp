#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/rigs/chain/chain.hpp"
#include "tumble/rigs/error_names.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::chain {

/// An option that is a standard deviation, and the errors that are drawn with it.
struct Imperfection {
  Option option;
  std::vector<std::string> errors;
  bool each_segment = false;
};

/// The values of a rig's errors in one run.
class ErrorValues {
 public:
  /// Given: values [errors x segments] in SI.
  ErrorValues(const std::vector<RigError>& list, const Matrix& values) : list_(list), values_(values) {}
  /// Value [SI] of one of the rig's errors; 0 where none was drawn. The rig must have an error of this name
  /// (assertion).
  double operator()(std::string_view name, std::size_t segment = 0) const;
  /// Value [SI] of an error that several rigs share; 0 where this rig lacks it. Some rig must have it (assertion).
  double where_present(std::string_view name, std::size_t segment = 0) const;

 private:
  const std::vector<RigError>& list_;
  const Matrix& values_;
};

/// Level and azimuth of the base, gravity.
std::vector<Imperfection> base_imperfections();
/// Gravity, with which the latitude goes.
Imperfection gravity_imperfection();
/// Lever arm and mounting of the instrument.
std::vector<Imperfection> lever_imperfections(const char* sd);
std::vector<Imperfection> mount_imperfections();

/// `lists` one after the other.
std::vector<Imperfection> joined(std::vector<std::vector<Imperfection>> lists);

/// The errors that are drawn with these, and that of the latitude of the site beside gravity; all 0 where the options
/// say `ideal`. Gravity is as uncertain as the site leaves it where the options do not state it.
std::vector<RigError> errors_of(const std::vector<Imperfection>& imperfections, const Settings& options,
                                const std::optional<Site>& site);

/// lever_x, lever_y, lever_z with these defaults.
std::vector<Option> lever_options(const char* x, const char* y, const char* z);
/// temperature, ideal.
std::vector<Option> laboratory_options();

/// How the instrument sits on the fixture.
std::vector<Axis> mount_axes();

/// The level frame at rest on the Earth. The latitude turns the Earth's rate; gravity is as stated for the site.
/// Given: gravity_error [m/s^2], latitude_error [rad].
Kinematics ground_of(const std::optional<Site>& site, double gravity_error, double latitude_error);

/// Instrument from fixture for mount_roll, mount_pitch, mount_yaw in every segment, with the mounting errors.
std::vector<Pose> poses_of(const Schedule& run, const ErrorValues& errors);

/// The commanded value [SI] of an axis that is laid to values by hand, as a function of time [s].
std::function<double(double time)> last_value(const Schedule& run, const std::string& axis);

/// The segment in force at a time [s], as a function of the time: an index.
std::function<std::size_t(double time)> segment_at(const Schedule& run);

/// Base from level, as the level and azimuth errors turn it.
Rotation base_from_level(const ErrorValues& errors);

/// A problem unless `lowest` lies below `highest`.
void check_order(const Settings& options, const std::string& lowest, const std::string& highest, Problems& problems);

/// Axes the rig lacks and motions that they cannot do. True when there is nothing of the kind.
bool check_axes(const std::vector<Axis>& axes, const Schedule& schedule, Problems& problems);

/// The segments of each power-up.
std::vector<Schedule> runs_of(const Schedule& schedule);

}  // namespace tumble::chain
