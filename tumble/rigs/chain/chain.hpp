#pragma once

#include <memory>
#include <span>
#include <vector>

#include "tumble/math/rotation.hpp"
#include "tumble/models/model.hpp"
#include "tumble/rigs/chain/oven.hpp"
#include "tumble/rigs/chain/profile.hpp"
#include "tumble/rigs/rig.hpp"

namespace tumble::chain {

/// How a frame moves, in its own axes.
struct Kinematics {
  Vector3 rate;            ///< against inertial space [rad/s]
  Vector3 acceleration;    ///< angular [rad/s^2]
  Vector3 specific_force;  ///< at its origin [m/s^2]
};

/// A motion seen in axes turned by a constant rotation.
Kinematics seen_in(const Rotation& new_from_old, const Kinematics& k);

/// A frame that turns against `k` about the unit vector n (the same in both), passive as in rotation.hpp:
///
///   w' = R w + n th',   alpha' = R alpha + (R w) x n th' + n th'',   f' = R f
Kinematics turned(const Kinematics& k, Vector3 n, const Turn& turn);

/// A frame with its origin moved to p [m], which may itself move in the frame:
///
///   f' = f + alpha x p + w x (w x p) + 2 w x p' + p''
Kinematics moved(const Kinematics& k, Vector3 p, Vector3 velocity = {}, Vector3 acceleration = {});

/// A part of an angle that depends on where the axis stands: cosine cos(order angle) + sine sin(order angle) [rad].
struct Harmonic {
  int order = 1;
  double cosine = 0.0, sine = 0.0;
};

enum class About { x, y, z };

/// Unit vector.
Vector3 direction_of(About about);

/// One joint: a shift and a constant rotation from the frame before, then a turn about one of the new axes.
struct Joint {
  Vector3 offset = {};   ///< of its origin, in the frame before [m]
  double stretch = 0.0;  ///< growth of offset.x with the squared rate of axis 0 [m/(rad/s)^2]
  Rotation fixed = {};   ///< at angle 0, from the frame before
  int axis = -1;         ///< which profile turns it; -1: none
  About about = About::z;
  double share = 1.0;  ///< of the profile's angle: 1, or 0 for a wobble (nothing between)
  double zero = 0.0;   ///< added to the angle [rad]
  std::vector<Harmonic> harmonics = {};
};

/// How the instrument is mounted on its fixture from some time on.
struct Pose {
  double begin = 0.0;  ///< [s]
  Rotation instrument_from_fixture = {};
};

/// From the ground to the instrument.
struct Chain {
  Rotation base = {};  ///< from level, with the constant rotation of the first joint
  Kinematics ground;   ///< in the axes of the base, at rest on the Earth
  std::vector<Profile> axes;
  std::vector<Joint> joints;    ///< the last one's frame is the fixture's
  Vector3 lever;                ///< of the instrument's reference point, in the fixture's axes [m]
  std::vector<Pose> poses;      ///< in order of time, one or more
  double temperature = 293.15;  ///< [K], where the oven is not used
  Oven oven = {};
};

/// Motion that the instrument feels at first, first + step, ... [s]. No storage is taken, so any thread may ask.
///
/// Accuracy  rounding; no angle is taken as small. Effects that change with the place within the rig are ignored: the
///           Earth's centrifugal and gravity gradients (3e-6 m/s^2 for a metre of height)
void felt(const Chain& chain, double first, double step, std::span<Felt> out);

/// Where the frame of one of the joints is at `time` [s].
PartPlacement joint_at(const Chain& chain, std::size_t joint, double time);

/// Where the instrument is at `time` [s]: its axes as mounted, at its reference point.
PartPlacement instrument_at(const Chain& chain, double time);

/// Until when nothing changes [s]. Given: time [s].
double steady_until(const Chain& chain, double time);

}  // namespace tumble::chain
