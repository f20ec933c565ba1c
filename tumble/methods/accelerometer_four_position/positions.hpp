#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/evidence.hpp"
#include "tumble/reduce/accelerometer/output.hpp"
#include "tumble/reduce/linear/rows.hpp"

/// Four positions of an accelerometer in gravity, at one or several temperatures.
///
/// See Lu Hanjie, Liu Yabin, Zhou Qiang, dynamic test of linear accelerometers, 2019, figure 11; docs/equations (3.5),
/// (3.6)
namespace tumble::accelerometer_four_position {

/// Direction of the axes in a position.
enum class Place { none, up, down, level };

/// The output over one segment.
struct Position {
  std::size_t stretch = 0;  ///< index in Bench::evidence.stretches
  std::string label;
  int run = 1;
  std::size_t power_up = 0;  ///< counted over plans and runs
  Place place = Place::none;
  bool o_level = false;                               ///< level: true where o is vertical, else p
  bool upwards = true;                                ///< level: that axis points up
  bool commands_temperature = false;                  ///< its segment does, beside an angle
  double gravity = 0.0;                               ///< [m/s^2] by the plan's site
  double output = 0.0;                                ///< [m/s^2] E/K_m, mean; NaN where predicted
  double seconds = 0.0;                               ///< of the samples used
  double temperature = 0.0, temperature_drift = 0.0;  ///< [K] mean, and second half minus first
  double set_point = 0.0;                             ///< [K] mean temperature by the schedule
  double squares = 0.0, freedom = 0.0;                ///< of the averages about the mean [(m/s^2)^2 s]: a density
  double averaging = 0.0;                             ///< [s] of these averages
};

/// Four segments (two for the source's estimator) from which one scale factor and one bias come; indices in
/// Bench::positions. Level positions: the first is the one in which p (or o) is up.
struct Cell {
  std::size_t up = 0, down = 0;
  std::optional<std::size_t> second, fourth;
  std::size_t power_up = 0;
  int run = 1;
  double temperature = 0.0;  ///< [K] mean of its positions
  double spread = 0.0;       ///< [K] greatest minus least
  std::size_t group = 0;     ///< which temperature
  bool o_level = false;
  bool measured_temperature = false;
};

/// The test, as read.
struct Bench {
  const Evidence* measured = nullptr;     ///< as given, outlives the bench; null where predicted
  std::shared_ptr<const Evidence> rates;  ///< recordings of `evidence`: counts per second; null where predicted
  linear::Evidences evidence;
  linear::Rows rows;        ///< one row a stretch
  linear::Problem problem;  ///< input a_i, no columns
  std::vector<Position> positions;
  std::vector<Cell> cells;                ///< in the order of the test
  std::vector<double> group_temperature;  ///< [K] by group, rising
  accelerometer::Output output;
  double reference_scale_factor = 1.0;  ///< K_m [SI]
  double pulse = 0.0;                   ///< [m/s] of one pulse at K_m; 0: not counted
  double white = 0.0;                   ///< [(m/s^2)^2 s] white noise of the output, without the rounding to pulses
  double white_freedom = 0.0;
  bool measured_temperature = false;  ///< false: as the schedule commands
  double self_heating = 0.0;          ///< [K] by which the unit is stated to be warmer than the set points
  Findings findings;
};

/// "20.0 degC" for a temperature [K], to a tenth of a degree.
std::string in_words(double temperature);

/// Reads the channel `role`. Throws Error::bad_input, bad_data that list everything that is missing.
Bench bench_of(const Evidence& evidence, const std::string& role);

/// The bench of a plan, around its [truth].
Bench bench_of(const Plan& plan);

}  // namespace tumble::accelerometer_four_position
