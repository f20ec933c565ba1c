#pragma once

#include <string>
#include <vector>

#include "tumble/core/plan.hpp"

namespace tumble::sdof_gyro_support {

/// A plan for trials: an sdof_gyro of known drift and noise on a rig with all its errors, without a schedule. Given:
/// rate [Hz].
Plan trial_plan(const std::string& method, const std::vector<Option>& options, const std::string& rig, double rate);

/// A position of a two-axis table.
struct Position {
  std::string label;
  double outer = 0.0, inner = 0.0;  ///< [rad]
};

/// Specific force along the 6 faces, 12 edges and 8 corners of a cube in the instrument, in a mixed order.
std::vector<Position> cube_positions();
/// A segment that holds a position. Given: duration [s].
Segment at(const Position& position, double duration);

}  // namespace tumble::sdof_gyro_support
