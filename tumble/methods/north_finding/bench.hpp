#pragma once

#include <string>
#include <vector>

#include "tumble/core/evidence.hpp"
#include "tumble/methods/north_finding/attitude.hpp"
#include "tumble/methods/north_finding/instrument.hpp"
#include "tumble/reduce/linear/rows.hpp"
#include "tumble/reduce/linear/slow.hpp"

namespace tumble::north_finding {

/// A stay at an index angle, or a revolution of a table that turns: its rows share one draw of slow noise.
struct Position {
  std::string label;
  int run = 1;
  bool steady = true;
  double angle = 0.0;         ///< [rad] index angle; of a turn: where it begins
  double rate = 0.0;          ///< [rad/s] of the table
  linear::Interval interval;  ///< of its samples
};

/// One channel of the test.
struct Signal {
  Channel channel = gyro;
  linear::Problem problem;
  linear::Evidences evidence = {};
  linear::Rows blocks = {};              ///< averages, as they are read
  std::vector<std::size_t> row_of = {};  ///< of each block, index of its row in `rows`, or npos where it is not used
  std::vector<Position> positions = {};
  std::vector<Row> rows = {};  ///< a stay is a row, each block of a turn is a row
};

/// The test, as read.
struct Bench {
  const Plan* plan = nullptr;
  Index index;
  Records records;
  std::vector<Signal> signals;  ///< the gyro first
  double middle = 0.0;          ///< t_0 [s] since power-on, from which the drift counts
  Findings findings;
};

inline constexpr std::size_t npos = static_cast<std::size_t>(-1);

/// Reads the channels. Throws Error::bad_input, bad_data with all that is missing.
Bench bench_of(const Evidence& evidence);
/// The bench of a plan, around its [truth].
Bench bench_of(const Plan& plan);

const Signal* signal_of(const Bench& bench, Channel channel);
/// Outputs of the rows [rows] [SI of the channel, counts per second].
std::vector<double> outputs_of(const Signal& signal);

/// Attitude at the middle of a row without and with an error of the rig.
struct Move {
  std::size_t row = 0;
  View before, after;
};

/// One draw of an error of the rig, at one standard deviation: the rows of each signal that it moves.
struct Disturbance {
  std::string source;
  std::string key;  ///< see Contribution
  std::vector<std::vector<Move>> moves;
};

/// All errors of the rigs. Those that turn the base as a whole are excluded as far as the test estimates the attitude
/// of the base: about the vertical always, about x and y where roll and pitch are estimated.
std::vector<Disturbance> disturbances_of(const Bench& bench, bool estimates_pitch, bool estimates_roll);

}  // namespace tumble::north_finding
