#pragma once

#include <vector>

#include "tumble/methods/north_finding/model.hpp"
#include "tumble/reduce/stretches.hpp"

/// Attitude of the body by the rig, with the errors of the rig and in a given world: the azimuth of the rig is
/// what is looked for.
namespace tumble::north_finding {

/// A rig in one power-up, asked in three worlds that differ in where the Earth's rate points. Their rates give the
/// attitude against the ground, also while the rig turns:
///
///   w = C w_earth + spin:   C north = (w(0) - spin)/w_ie,   C up = (w(90) - w(-90))/(2 w_ie),   2 spin = w(90) +
///   w(-90)
class Attitude {
 public:
  /// errors  [errors x segments] as RigRun has them; empty: none
  Attitude(const PowerUp& power_up, const Matrix& errors);

  /// At `time` [s], `base_from_level` the attitude of the body at index 0.
  View at(double time, const Rotation& base_from_level) const;
  /// Body from level (east, north, up) at a time [s].
  Rotation body_from_level(double time) const;

 private:
  struct Vectors {
    Vector3 north, up, spin, force;
  };
  Vectors vectors(double time) const;

  Reference equator_, pole_, other_pole_;
  double gravity_ = 0.0;
};

/// The body at index 0: the first segment of the plan with the axis that turns at 0. Throws Error::bad_input where none
/// or several axes turn, or where it does not point up.
struct Index {
  std::string axis;
  Rotation base_from_level;
};
Index index_of(const Plan& plan);

}  // namespace tumble::north_finding
