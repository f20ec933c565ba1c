#include "tumble/methods/imu_multi_position/faults.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <span>

#include "tumble/math/rotation.hpp"
#include "tumble/rigs/capabilities.hpp"
#include "tumble/units/error.hpp"

namespace tumble::imu_multi_position {
namespace {

struct Mistaken {
  const char* is;     ///< what the numbers look like
  const char* taken;  ///< what they were taken for
};

constexpr Mistaken forces[] = {{"g", "m/s^2"},      {"m/s^2", "g"},      {"mg", "m/s^2"},
                               {"cm/s^2", "m/s^2"}, {"mm/s^2", "m/s^2"}, {"mg", "g"}};
constexpr Mistaken rates[] = {{"deg/s", "rad/s"}, {"rad/s", "deg/s"},  {"deg/h", "deg/s"},
                              {"deg/s", "deg/h"}, {"mrad/s", "rad/s"}, {"deg/h", "rad/s"}};

/// `scale`: what is shown of what is felt.
/// `step`: between samples [s], which increments taken for rates differ by, or rates for increments.
void check_unit(std::span<const Mistaken> known, const char* what, const std::string& shown, double scale,
                double step) {
  if (scale > 0.6 && scale < 1.6) return;
  std::string like;
  for (const auto& m : known) {
    const double ratio = Unit::parse(m.taken).factor() / Unit::parse(m.is).factor();
    if (std::abs(std::log(scale / ratio)) < 0.2)
      like = fmt::format(": they look like {} taken for {}; state the unit of the columns", m.is, m.taken);
  }
  if (std::abs(std::log(scale / step)) < 0.2)
    like = ": they look like increments taken for rates; state the unit of the increments (deg, m/s) for the columns";
  if (std::abs(std::log(scale * step)) < 0.2)
    like = ": they look like rates taken for increments; state the unit of the rates (deg/s, m/s^2) for the columns";
  if (like.empty()) like = ": check their unit, or give them as counts, unit LSB";
  throw Error(Error::Kind::bad_data, fmt::format("the {} show {:.4g} times {}{}", what, scale, shown, like));
}

/// Row i shows axis along[i] with sign[i]; not sound: two rows show one axis.
struct Axes {
  int along[3];
  double sign[3];
  bool sound = true;
};

Axes axes_of(const Matrix3d& matrix) {
  Axes axes{};
  bool taken[3]{};
  for (int i = 0; i < 3; ++i) {
    matrix.row(i).cwiseAbs().maxCoeff(&axes.along[i]);
    axes.sign[i] = matrix(i, axes.along[i]) < 0.0 ? -1.0 : 1.0;
    axes.sound = axes.sound && !taken[axes.along[i]];
    taken[axes.along[i]] = true;
  }
  return axes;
}

Matrix3d matrix_of(const Axes& axes) {
  Matrix3d m = Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) m(i, axes.along[i]) = axes.sign[i];
  return m;
}

/// "gyro_x shows -y, gyro_y shows x"
std::string said(const std::array<std::string, 3>& names, const Axes& axes) {
  std::string text;
  for (int i = 0; i < 3; ++i) {
    if (axes.along[i] == i && axes.sign[i] > 0.0) continue;
    text += fmt::format("{}'{}' shows {}{}", text.empty() ? "" : ", ", names[static_cast<std::size_t>(i)],
                        axes.sign[i] < 0.0 ? "-" : "", letters[static_cast<std::size_t>(axes.along[i])]);
  }
  return text;
}

int changed(const Axes& axes) {
  int n = 0;
  for (int i = 0; i < 3; ++i) n += axes.along[i] != i || axes.sign[i] < 0.0 ? 1 : 0;
  return n;
}

}  // namespace

void check_force_unit(const Session& session, const Matrix3d& matrix) {
  if (session.accelerometer.counts) return;
  check_unit(forces, "accelerometers", "gravity at rest", std::cbrt(matrix.diagonal().prod()),
             session.accelerometer.step);
}

void check_gyros(const Session& session, const Matrix3d& matrix) {
  const Axes axes = axes_of(matrix);
  if (axes.sound && changed(axes) > 0) {
    const Matrix3d of_gyros = matrix_of(axes);
    std::string text = "the gyros do not turn about the axes of the accelerometers: " + said(session.gyro.names, axes);
    if (of_gyros.determinant() < 0.0) {
      text += ": the gyros are a left-handed triad";
    } else {  // accelerometers P f look like gyros det(P) P'
      const Axes same = axes_of(of_gyros.transpose()), mirrored = axes_of(-of_gyros.transpose());
      const bool mirror = changed(mirrored) < changed(same);
      text += fmt::format("; or the accelerometers are a {} triad: {}", mirror ? "left-handed" : "turned",
                          said(session.accelerometer.names, mirror ? mirrored : same));
    }
    throw Error(Error::Kind::bad_data, text + "; put it right in [channels] and in the signs of the columns");
  }
  if (session.gyro.counts) return;
  check_unit(rates, "gyros", "the turn between rests", std::cbrt(std::abs(matrix.determinant())), session.gyro.step);
}

std::optional<Vector3d> planned_up(const Plan& plan) {
  const std::string& word = plan.settings.word("up");
  if (word != "unknown") {
    const int axis = word.back() - 'x';
    return Vector3d((word[0] == '-' ? -1.0 : 1.0) * Vector3d::Unit(axis));
  }
  if (!is_laid_by_hand(plan) || plan.schedule.empty()) return {};
  const auto angle = [&](const char* axis) {
    const auto found = plan.schedule[0].axes.find(axis);
    return found == plan.schedule[0].axes.end() ? 0.0 : found->second.value;
  };
  const auto up = about_x(angle("mount_roll")) * (about_y(angle("mount_pitch")) * tumble::Vector3{0.0, 0.0, 1.0});
  return Vector3d(up.x, up.y, up.z);
}

void check_up(const Vector3d& first, const Vector3d& planned) {
  if (first.dot(planned) > -0.8) return;
  throw Error(
      Error::Kind::bad_data,
      fmt::format("at the first rest ({:+.2f}, {:+.2f}, {:+.2f}) shows up, the opposite of what was said: the "
                  "accelerometers show gravity, not the specific force that holds against it; reverse their signs",
                  first[0], first[1], first[2]));
}

}  // namespace tumble::imu_multi_position
