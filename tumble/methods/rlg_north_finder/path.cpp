#include "tumble/methods/rlg_north_finder/path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/earth/earth.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::rlg_north_finder {
namespace {

constexpr double upright = 0.9;   ///< share of the specific force along an axis that stands upright
constexpr double turning = 1e-3;  ///< [rad/s] above the Earth's rate
constexpr const char* names[] = {"x", "y", "z"};

std::array<double, 3> parts(Vector3 v) { return {v.x, v.y, v.z}; }

/// The part of an axis that carries nearly all of v, or -1.
int along(const std::array<double, 3>& v) {
  const double all = std::hypot(v[0], v[1], v[2]);
  for (int i = 0; i < 3; ++i)
    if (std::abs(v[static_cast<std::size_t>(i)]) > upright * all) return i;
  return -1;
}

}  // namespace

const Turning* Path::rotation(int axis, bool forward) const {
  for (const auto& one : rotations)
    if (one.axis == axis && (one.turns > 0.0) == forward) return &one;
  return nullptr;
}

Path path_of(const std::vector<linear::SegmentSummary>& segments) {
  Path path;
  for (std::size_t s = 0; s < segments.size(); ++s) {
    const auto force = parts(segments[s].felt.specific_force), rate = parts(segments[s].felt.rate);
    if (segments[s].steady) {
      if (const int axis = along(force); axis >= 0)
        (force[static_cast<std::size_t>(axis)] > 0.0 ? path.up : path.down)[static_cast<std::size_t>(axis)].push_back(
            s);
      continue;
    }
    const int axis = along(rate);
    if (axis < 0 || std::abs(rate[static_cast<std::size_t>(axis)]) < turning) continue;
    const double angle = rate[static_cast<std::size_t>(axis)] * segments[s].duration;
    path.rotations.push_back({s, axis, angle / two_pi, segments[s].duration});
  }
  return path;
}

std::vector<std::string> missing(const Path& path) {
  std::vector<std::string> lacking;
  const auto ask = [&](bool there, const char* what, const char* term) {
    if (!there) lacking.push_back(fmt::format("the path has {}: {} cannot be had", what, term));
  };
  const auto both = [&](int axis) { return path.rotation(axis, true) && path.rotation(axis, false); };
  ask(both(0), "no whole rotations about x, forward and reverse (position 8)",
      "gyro.scale_factor, and with it every term of the gyro,");
  ask(both(1), "no whole rotations about y, forward and reverse (position 7)", "gyro.misalignment_y");
  ask(both(2), "no whole rotations about z, forward and reverse (position 6)", "gyro.misalignment_z");
  const auto stands = [&](std::size_t axis, bool up) { return !(up ? path.up : path.down)[axis].empty(); };
  ask(stands(0, true), "no stay with x up (position 2)",
      "gyro.bias, accelerometer_x.scale_factor, accelerometer_x.bias, accelerometer_y.misalignment_x");
  ask(stands(1, false), "no stay with y down (position 3)",
      "gyro.bias, accelerometer_y.scale_factor, accelerometer_y.bias, accelerometer_x.misalignment_y");
  ask(stands(0, false), "no stay with x down (position 4)",
      "gyro.bias, accelerometer_x.scale_factor, accelerometer_x.bias, accelerometer_y.misalignment_x");
  ask(stands(1, true), "no stay with y up (position 5)",
      "gyro.bias, accelerometer_y.scale_factor, accelerometer_y.bias, accelerometer_x.misalignment_y");
  ask(stands(2, true), "no stay with z up (position 1 or 6)",
      "accelerometer_x.misalignment_z, accelerometer_y.misalignment_z");
  ask(stands(2, false), "no stay with z down (position 7 or 8)",
      "accelerometer_x.misalignment_z, accelerometer_y.misalignment_z");
  return lacking;
}

std::vector<std::string> not_whole(const Path& path, const std::vector<linear::SegmentSummary>& segments) {
  std::vector<std::string> problems;
  for (const auto& one : path.rotations) {
    const double earth = earth_rate * one.seconds / two_pi;
    if (std::abs(one.turns - std::round(one.turns)) > 1e-3 + earth)
      problems.push_back(
          fmt::format("'{}' is {:.4g} turns about {}: a rotation must be whole turns, so that the "
                      "Earth's rate averages out",
                      segments[one.segment].label, one.turns, names[one.axis]));
  }
  for (int axis = 0; axis < 3; ++axis) {
    const Turning *forward = path.rotation(axis, true), *reverse = path.rotation(axis, false);
    if (forward && reverse && std::round(forward->turns) != -std::round(reverse->turns))
      problems.push_back(
          fmt::format("'{}' and '{}' are {:.4g} and {:.4g} turns about {}: forward and reverse must be "
                      "the same number",
                      segments[forward->segment].label, segments[reverse->segment].label, forward->turns,
                      -reverse->turns, names[axis]));
  }
  return problems;
}

}  // namespace tumble::rlg_north_finder
