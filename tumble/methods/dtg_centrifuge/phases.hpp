#pragma once

#include "tumble/methods/dtg_centrifuge/lines.hpp"

/// Whether the line of the gyro keeps its phase against the table's angle along each level.
namespace tumble::dtg_centrifuge {

/// By how much faster the lines of both gyros turn than the angle that was recorded [1], over all levels.
struct TurnOfLine {
  double value = 0.0, sd = 0.0;
};

TurnOfLine turn_of_line(const std::vector<Measured>& measured);

/// An error where the line turns faster or more slowly than the recorded angle: the encoder's scale is wrong, or its clock is
/// another.
void check_turn(const std::vector<Measured>& measured, Findings& findings);

}  // namespace tumble::dtg_centrifuge
