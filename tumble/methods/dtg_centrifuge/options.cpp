#include "tumble/methods/dtg_centrifuge/options.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tumble/units/error.hpp"

namespace tumble::dtg_centrifuge {

std::vector<Option> options() {
  using Type = Option::Type;
  return {
      {"estimator",
       Type::word,
       "1",
       "regression",
       {"regression", "fourier"},
       "regression on the angles with the true rate taken off, docs/equations (1.12)-(1.15), or the source's steps, "
       "docs/equations (1.6)-(1.11)"},
      {"order",
       Type::word,
       "1",
       "auto",
       {"auto", "constant", "cubic", "quintic"},
       "of the drift in specific force, docs/equations (1.13); auto: the simplest whose AICc is within 4 of the "
       "lowest"},
      {"settling", Type::quantity, "s", "1 s", {}, "time dropped in each segment after the rig has settled"},
      {"averaging",
       Type::quantity,
       "s",
       "",
       {},
       "time over which a sample of the gyro is the mean, docs/equations (1.15); absent: one sampling interval"},
      {"natural_frequency",
       Type::quantity,
       "Hz",
       "",
       {},
       "of the gyro's capture loop; absent: no loop of second order"},
      {"damping_ratio", Type::quantity, "1", "0.7", {}, "of the capture loop"},
      {"time_constant", Type::quantity, "s", "", {}, "of a capture loop of first order"},
      {"loop_lag_sd", Type::quantity, "%", "1 %", {}, "relative standard uncertainty of the loop's lag"},
      {"scale_factor_sd", Type::quantity, "ppm", "0 ppm", {}, "standard uncertainty of the gyro's scale factor"},
      {"reference_gain",
       Type::quantity,
       "1",
       "1",
       {},
       "scale factor of the reference gyro over that of the gyro, from elsewhere; used where reference_gain_sd is "
       "given"},
      {"reference_gain_sd",
       Type::quantity,
       "ppm",
       "",
       {},
       "its standard uncertainty; absent: the Earth's rate alone tells the gain"},
      {"reference_azimuth",
       Type::quantity,
       "deg",
       "0 deg",
       {},
       "input axis of the reference gyro from X toward Y; used where reference_azimuth_sd is given"},
      {"reference_azimuth_sd",
       Type::quantity,
       "deg",
       "",
       {},
       "its standard uncertainty; absent: the Earth's rate alone tells the azimuth"},
      {"reference_sensitivity",
       Type::word,
       "1",
       "zero",
       {"zero", "fitted"},
       "of the reference gyro to specific force: none, or as its line over the levels says"},
      {"reference_averaging", Type::quantity, "s", "", {}, "as averaging, of the reference gyro"},
      {"reference_natural_frequency", Type::quantity, "Hz", "", {}, "of the reference gyro's loop; absent: none"},
      {"reference_damping_ratio", Type::quantity, "1", "0.7", {}, "of that loop"},
      {"reference_time_constant", Type::quantity, "s", "", {}, "of a loop of first order"},
      {"reference_clock_offset", Type::quantity, "s", "0 s", {}, "by which stamps of the reference gyro are late"},
      {"reference_clock_offset_sd", Type::quantity, "s", "0 s", {}, "its standard uncertainty"},
      {"encoder_stamps",
       Type::word,
       "1",
       "begin",
       {"begin", "instant"},
       "an angle is that in the middle of the interval that begins at its stamp, as `tumble simulate` writes it, or "
       "that at its stamp"}};
}

void refuse_impossible(const Settings& settings) {
  std::vector<std::string> problems;
  for (const char* name : {"settling", "averaging", "loop_lag_sd", "scale_factor_sd", "reference_gain_sd",
                           "reference_azimuth_sd", "reference_averaging", "reference_clock_offset_sd"})
    if (settings.has(name) && !(settings.number(name) >= 0.0 && std::isfinite(settings.number(name))))
      problems.push_back(fmt::format("{} must not be negative", name));
  for (const char* name : {"natural_frequency", "damping_ratio", "time_constant", "reference_gain",
                           "reference_natural_frequency", "reference_damping_ratio", "reference_time_constant"})
    if (settings.has(name) && !(settings.number(name) > 0.0 && std::isfinite(settings.number(name))))
      problems.push_back(fmt::format("{} must be positive", name));
  for (const char* name : {"reference_azimuth", "reference_clock_offset"})
    if (!std::isfinite(settings.number(name))) problems.push_back(fmt::format("{} must be finite", name));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

}  // namespace tumble::dtg_centrifuge
