#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tumble/core/plan.hpp"
#include "tumble/rigs/rig.hpp"

namespace tumble {

/// One power-up of a plan, carried out by its rig without errors, at some instants.
struct PlanMotion {
  /// A part of the rig; the last one is the instrument.
  struct MovedPart {
    std::string name;
    Vector3 axis;
    bool slides = false;
    std::vector<PartPlacement> at;  ///< an instant each
  };
  /// An axis as its controller knows it.
  struct AxisCourse {
    std::string name;
    Unit unit;
    std::vector<double> values;  ///< [SI of the axis] an instant each
  };
  std::vector<MovedPart> parts;
  std::vector<AxisCourse> axes;
  std::vector<double> settled;  ///< [s since power-on] a segment each: when the rig does what was commanded
  Vector3 earth_rate;           ///< [rad/s] in level axes (east, north, up); 0 where the plan has no site
  Vector3 specific_force;       ///< [m/s^2] of what is at rest, in level axes: upwards
};

/// The rig of the simulation, asked at first, first + step, ... [s since power-on].
///
/// Given     run     number of the power-up
/// Throws    Error::bad_input where the plan has no rig or no such power-up
PlanMotion motion_of(const Plan& plan, int run, double first, double step, std::size_t count);

}  // namespace tumble
