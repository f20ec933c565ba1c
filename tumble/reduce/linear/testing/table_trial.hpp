#pragma once

#include "tumble/core/plan.hpp"

namespace tumble::linear {

/// A schedule on a two-axis table that shows every term over angular motion: six faces, rates of both signs and two
/// sizes about one and two axes, oscillations about each axis. Given: the larger speed [deg/s], amplitude [deg] and
/// frequency [Hz] of the oscillations.
void add_table_motions(Plan& plan, double speed = 60.0, double amplitude = 20.0, double frequency = 0.5);

}  // namespace tumble::linear
