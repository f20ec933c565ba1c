#include "tumble/methods/imu_multi_position/faults.hpp"

#include <fmt/format.h>

#include <cmath>
#include <span>

#include "tumble/math/rotation.hpp"
#include "tumble/rigs/capabilities.hpp"
#include "tumble/units/error.hpp"

namespace tumble::imu_multi_position {
namespace {

/// Scales [1] of outputs whose unit is right: no instrument is so far off; the mistaken units are 9.8 times off and
/// more.
constexpr double least_scale = 0.6, greatest_scale = 1.6;
constexpr double looks_like = 0.2;  ///< [1] in the logarithm, within which a scale is that of a mistaken unit
/// Cosine of the angle between shown and stated direction up, below which it is opposite.
constexpr double opposite_up = -0.8;

struct Mistaken {
  const char* is;     ///< unit that the numbers probably have
  const char* taken;  ///< unit in which they were read
};

constexpr Mistaken forces[] = {{"g", "m/s^2"},      {"m/s^2", "g"},      {"mg", "m/s^2"},
                               {"cm/s^2", "m/s^2"}, {"mm/s^2", "m/s^2"}, {"mg", "g"}};
constexpr Mistaken rates[] = {{"deg/s", "rad/s"}, {"rad/s", "deg/s"},  {"deg/h", "deg/s"},
                              {"deg/s", "deg/h"}, {"mrad/s", "rad/s"}, {"deg/h", "rad/s"}};

/// Refuses outputs of this scale [1], shown by felt, that is far from 1. Given: step [s] between samples, the ratio of
/// increments to rates.
void check_unit(std::span<const Mistaken> units, const char* what, const char* shown, double scale, double step) {
  if (scale > least_scale && scale < greatest_scale) return;
  Sentence like = ": check their unit, or give them as counts, unit LSB";
  for (const auto& m : units) {
    const double ratio = Unit::parse(m.taken).factor() / Unit::parse(m.is).factor();
    if (std::abs(std::log(scale / ratio)) < looks_like)
      like = say(": they look like {} taken for {}; state the unit of the columns", Name{m.is}, Name{m.taken});
  }
  if (std::abs(std::log(scale / step)) < looks_like)
    like = ": they look like increments taken for rates; state the unit of the increments (deg, m/s) for the columns";
  if (std::abs(std::log(scale * step)) < looks_like)
    like = ": they look like rates taken for increments; state the unit of the rates (deg/s, m/s^2) for the columns";
  throw Error(Error::Kind::bad_data, say("the {} show {:.4g} times {}{}", what, scale, shown, like));
}

/// Row i shows axis along[i] with sign[i]; not sound: two rows show one axis.
struct Axes {
  std::array<std::size_t, 3> along{0, 1, 2};
  Vector3 sign;
  bool sound = true;
};

Axes axes_of(const Matrix3& matrix) {
  Axes axes;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3 size = absolute(matrix[i]);
    axes.along[i] = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    axes.sign[i] = matrix(i, axes.along[i]) < 0.0 ? -1.0 : 1.0;
  }
  const auto [x, y, z] = axes.along;
  axes.sound = x != y && y != z && z != x;
  return axes;
}

Matrix3 matrix_of(const Axes& axes) {
  Matrix3 m;
  for (std::size_t i = 0; i < 3; ++i) m(i, axes.along[i]) = axes.sign[i];
  return m;
}

/// "gyro_x shows -y, gyro_y shows x"
std::string exchanges(const std::array<std::string, 3>& names, const Axes& axes) {
  std::string text;
  for (std::size_t i = 0; i < 3; ++i) {
    if (axes.along[i] == i && axes.sign[i] > 0.0) continue;
    text += fmt::format("{}'{}' shows {}{}", text.empty() ? "" : ", ", names[i], axes.sign[i] < 0.0 ? "-" : "",
                        letters[axes.along[i]]);
  }
  return text;
}

int changed(const Axes& axes) {
  int n = 0;
  for (std::size_t i = 0; i < 3; ++i) n += axes.along[i] != i || axes.sign[i] < 0.0 ? 1 : 0;
  return n;
}

}  // namespace

void check_force_unit(const Session& session, const Matrix3& matrix) {
  if (session.accelerometer.counts) return;
  check_unit(forces, "accelerometers", "gravity at rest", std::cbrt(matrix.x.x * matrix.y.y * matrix.z.z),
             session.accelerometer.step);
}

void check_gyros(const Session& session, const Matrix3& matrix) {
  const Axes axes = axes_of(matrix);
  if (axes.sound && changed(axes) > 0) {
    const Matrix3 of_gyros = matrix_of(axes);
    Sentence text = say("the gyros do not turn about the axes of the accelerometers: {}",
                        Name{exchanges(session.gyro.names, axes)});
    if (determinant(of_gyros) < 0.0) {
      text = say("{}: the gyros are a left-handed triad", text);
    } else {  // accelerometers P f look like gyros det(P) P'
      const Axes same = axes_of(transposed(of_gyros)), mirrored = axes_of(-transposed(of_gyros));
      const bool mirror = changed(mirrored) < changed(same);
      text = say("{}; or the accelerometers are a {} triad: {}", text, mirror ? "left-handed" : "turned",
                 Name{exchanges(session.accelerometer.names, mirror ? mirrored : same)});
    }
    throw Error(Error::Kind::bad_data, say("{}; correct [channels] and the signs of the columns", text));
  }
  if (session.gyro.counts) return;
  check_unit(rates, "gyros", "the turn between rests", std::cbrt(std::abs(determinant(matrix))), session.gyro.step);
}

std::optional<Vector3> planned_up(const Plan& plan) {
  const std::string& word = plan.settings.word("up");
  if (word != "unknown") {
    return (word[0] == '-' ? -1.0 : 1.0) * identity3()[static_cast<std::size_t>(word.back() - 'x')];
  }
  if (!is_laid_by_hand(plan) || plan.schedule.empty()) return {};
  const auto angle = [&](const char* axis) {
    const auto motion = plan.schedule[0].axes.find(axis);
    return motion == plan.schedule[0].axes.end() ? 0.0 : motion->second.value;
  };
  return about_x(angle("mount_roll")) * (about_y(angle("mount_pitch")) * Vector3{0.0, 0.0, 1.0});
}

void check_up(Vector3 first, Vector3 planned) {
  if (dot(first, planned) > opposite_up) return;
  throw Error(
      Error::Kind::bad_data,
      say("at the first rest ({:+.2f}, {:+.2f}, {:+.2f}) shows up, the opposite of the stated direction: the "
          "accelerometers show gravity instead of the specific force, which points up at rest; reverse their signs",
          first.x, first.y, first.z));
}

}  // namespace tumble::imu_multi_position
