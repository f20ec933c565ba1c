#include "tumble/methods/rlg_north_finder/path.hpp"

#include <cmath>

#include "tumble/units/constants.hpp"

namespace tumble::rlg_north_finder {
namespace {

constexpr double upright = 0.9;        ///< share of the specific force along an axis that stands upright
constexpr double turning_rate = 1e-3;  ///< [rad/s] above the Earth's rate
/// Of a turn, by which a turn by hand may miss a whole one. What the Earth's rate then adds, 0.02 of that of a turn of
/// 18 s, is 2.6e-5 rad: 0.2 arcsec of a misalignment with two turns each way, and least squares takes it into account.
constexpr double greatest_fraction = 0.02;
constexpr const char* names[] = {"x", "y", "z"};

/// Index of the component that is nearly all of v, or -1.
int along(Vector3 v) {
  for (std::size_t i = 0; i < 3; ++i)
    if (std::abs(v[i]) > upright * norm(v)) return static_cast<int>(i);
  return -1;
}

/// A stay that the formulas need.
struct Need {
  std::size_t axis;
  bool up;
  const char *positions, *parameters;
};

constexpr Need needs[] = {
    {0, true, "2", "gyro.bias, accelerometer_x.scale_factor, accelerometer_x.bias, accelerometer_y.misalignment_x"},
    {1, false, "3", "gyro.bias, accelerometer_y.scale_factor, accelerometer_y.bias, accelerometer_x.misalignment_y"},
    {0, false, "4", "gyro.bias, accelerometer_x.scale_factor, accelerometer_x.bias, accelerometer_y.misalignment_x"},
    {1, true, "5", "gyro.bias, accelerometer_y.scale_factor, accelerometer_y.bias, accelerometer_x.misalignment_y"},
    {2, true, "1, 6", "accelerometer_x.misalignment_z, accelerometer_y.misalignment_z"},
    {2, false, "7, 8", "accelerometer_x.misalignment_z, accelerometer_y.misalignment_z"}};

/// Rotation number s about axis i. The Earth's rate along it is that of the stay before, else of the stay after.
Turning turning_of(const std::vector<linear::SegmentSummary>& segments, std::size_t s, std::size_t i) {
  std::size_t stay = s;
  while (stay > 0 && !segments[stay].steady) --stay;
  while (stay + 1 < segments.size() && !segments[stay].steady) ++stay;
  const double earth = segments[stay].steady ? segments[stay].felt.rate[i] : 0.0, seconds = segments[s].duration;
  const double angle = segments[s].felt.rate[i] * seconds;
  return {s, static_cast<int>(i), angle / two_pi, std::remainder(angle - earth * seconds, two_pi), seconds};
}

}  // namespace

const Turning* Path::rotation(int axis, bool forward) const {
  for (const auto& turning : rotations)
    if (turning.axis == axis && (turning.turns > 0.0) == forward) return &turning;
  return nullptr;
}

Path path_of(const std::vector<linear::SegmentSummary>& segments) {
  Path path;
  for (std::size_t s = 0; s < segments.size(); ++s) {
    const Vector3 force = segments[s].felt.specific_force, rate = segments[s].felt.rate;
    const int axis = along(segments[s].steady ? force : rate);
    if (axis < 0) continue;
    const auto i = static_cast<std::size_t>(axis);
    if (segments[s].steady)
      (force[i] > 0.0 ? path.up : path.down)[i].push_back(s);
    else if (std::abs(rate[i]) >= turning_rate)
      path.rotations.push_back(turning_of(segments, s, i));
  }
  return path;
}

Findings missing(const Path& path, Finding::Severity severity) {
  Findings findings;
  const auto both = [&](int axis) { return path.rotation(axis, true) && path.rotation(axis, false); };
  if (!both(0)) findings.push_back({severity, "no_rotations_about_x", {}});
  for (const int axis : {1, 2})
    if (!both(axis))
      findings.push_back({severity,
                          "no_rotations_about_axis",
                          {{"axis", names[axis]},
                           {"position", 8 - axis},
                           {"parameter", std::string("gyro.misalignment_") + names[axis]}}});
  for (const Need& need : needs)
    if ((need.up ? path.up : path.down)[need.axis].empty())
      findings.push_back(
          {severity,
           need.up ? "no_stay_with_axis_up" : "no_stay_with_axis_down",
           {{"axis", names[need.axis]}, {"positions", need.positions}, {"parameters", need.parameters}}});
  return findings;
}

Findings not_whole(const Path& path, const std::vector<linear::SegmentSummary>& segments) {
  Findings findings;
  for (const auto& turning : path.rotations) {
    if (std::abs(turning.beyond) > greatest_fraction * two_pi)
      findings.push_back({Finding::Severity::error,
                          "turns_not_whole",
                          {{"turns", turning.turns}, {"axis", names[turning.axis]}},
                          segments[turning.segment].label});
  }
  for (int axis = 0; axis < 3; ++axis) {
    const Turning *forward = path.rotation(axis, true), *reverse = path.rotation(axis, false);
    if (forward && reverse && std::round(forward->turns) != -std::round(reverse->turns))
      findings.push_back({Finding::Severity::error,
                          "unequal_turns",
                          {{"forward", segments[forward->segment].label},
                           {"reverse", segments[reverse->segment].label},
                           {"forward_turns", forward->turns},
                           {"reverse_turns", -reverse->turns},
                           {"axis", names[axis]}}});
  }
  return findings;
}

}  // namespace tumble::rlg_north_finder
