#include "tumble/methods/dtg_centrifuge/rig_lines.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "tumble/math/circle.hpp"
#include "tumble/math/golden_section.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::dtg_centrifuge {
namespace {

/// Added to the diagonal of a column of unit size [1]: to all against rounding, and to the other lines so that what
/// they share with a line of the estimator belongs to the estimator's.
constexpr double against_rounding = 1e-12, to_other_lines = 1e-6;

constexpr std::size_t points = 192;

/// Lines that errors of the rig give in addition to those of the estimator: multiples of arm and theta.
constexpr std::array<std::array<int, 2>, 8> others{{{1, 0}, {2, 0}, {1, 2}, {1, -2}, {2, 1}, {2, -1}, {2, -2}, {0, 4}}};
constexpr std::size_t all = columns + 2 * others.size();

struct Instants {
  std::array<double, points> tau, arm, theta;
  Matrix felt{points, 5};  ///< columns f_x, f_y, f_z, w_x, w_y
};

/// At which rate an axis turns at `time` [rad/s]. A difference of its angles from the beginning to the end of a segment
/// is not this rate: the instant of the end belongs to the next segment, which begins at the angle that was recorded.
double rate_of_drive(const Reference& reference, const char* axis, double time) {
  for (const auto& drive : reference.drives)
    if (drive.axis == axis) return drive.at(time).rate;
  return 0.0;
}

double angle(const Reference& reference, const char* name, double time) {
  double reading = 0.0;
  for (const auto& sensor : reference.sensors)
    if (sensor.channel.name == name) sensor.read(time, 0.0, std::span(&reading, 1));
  return reading;
}

/// So spaced that the instants fall in step with nothing.
Instants look(const Reference& reference, const Spin& spin) {
  Instants out;
  const double begin = spin.begin - spin.power_on, length = spin.end - spin.begin;
  for (std::size_t k = 0; k < points; ++k) {
    const double share = golden_fraction(k, 0.5 / points), time = begin + share * length;
    Felt felt;
    reference.felt(time, 0.0, std::span(&felt, 1));
    out.tau[k] = 2.0 * share - 1.0;
    out.arm[k] = angle(reference, "arm_angle", time);
    out.theta[k] = -angle(reference, "table_angle", time);
    const double sensed[] = {felt.specific_force.x, felt.specific_force.y, felt.specific_force.z, felt.rate.x,
                             felt.rate.y};
    for (std::size_t c = 0; c < 5; ++c) out.felt(k, c) = sensed[c];
  }
  return out;
}

RigLines lines_of(const Instants& at) {
  Matrix design(points, all, 1.0);
  std::ranges::copy(at.tau, column(design, 1).begin());
  std::size_t next = 2;
  const auto line = [&](int of_arm, int of_theta) {
    for (std::size_t k = 0; k < points; ++k) {
      const double turns = (of_arm * at.arm[k] + of_theta * at.theta[k]) * 0.5 / pi;
      const CirclePoint p = on_circle(turns);
      design(k, next) = p.cosine;
      design(k, next + 1) = p.sine;
    }
    next += 2;
  };
  for (int h = 1; h <= 3; ++h) line(0, h);
  line(1, -1);
  line(1, 1);
  for (const auto& [of_arm, of_theta] : others) line(of_arm, of_theta);
  // Other lines may coincide with those of the estimator: what cannot be distinguished then belongs to the estimator's.
  Matrix normal = gram(design);
  for (std::size_t k = 0; k < all; ++k)
    normal(k, k) += (k < columns ? against_rounding : to_other_lines + against_rounding) * static_cast<double>(points);
  Matrix b = solve_symmetric(normal, transposed_product(design, at.felt));
  b += solve_symmetric(normal, transposed_product(design, at.felt - design * b));
  const auto phasors = [&](std::size_t c) {
    return Phasors{{Complex(b(2, c), -b(3, c)), Complex(b(4, c), -b(5, c)), Complex(b(6, c), -b(7, c))},
                   Complex(b(8, c), -b(9, c))};
  };
  RigLines lines;
  lines.force[0] = phasors(0);
  lines.force[1] = phasors(1);
  lines.force_along = b(0, 2);
  lines.rate[0] = phasors(3);
  lines.rate[1] = phasors(4);
  return lines;
}

RigLines rig_lines_at(const Reference& reference, const Spin& spin) {
  const Instants at = look(reference, spin);
  RigLines lines = lines_of(at);
  const double middle = 0.5 * (spin.begin + spin.end) - spin.power_on;
  lines.arm_rate = rate_of_drive(reference, "arm", middle);
  lines.table_rate = rate_of_drive(reference, "table", middle);
  return lines;
}

}  // namespace

RigLines rig_lines_of(const Test& test, const Spin& spin) {
  return rig_lines_at(test.power_ups[spin.power_up].reference, spin);
}

std::vector<std::string> keys_of(const Test& test, const std::vector<RigLinesShift>& shifts) {
  ConductedTest conducted;
  conducted.power_ups = test.power_ups;
  std::vector<std::string> keys;
  for (const RigLinesShift& shift : shifts)
    keys.push_back(shift.error.error.each_segment ? "" : key_of(conducted, shift.error));
  return keys;
}

std::vector<RigLinesShift> shifts_of(const Test& test, const std::vector<const Spin*>& spins,
                                     const std::vector<RigLines>& nominal) {
  return observed_with_errors(test.power_ups, spins, nominal, rig_lines_at);
}

}  // namespace tumble::dtg_centrifuge
