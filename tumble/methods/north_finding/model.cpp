#include "tumble/methods/north_finding/model.hpp"

#include <cmath>

#include "tumble/earth/earth.hpp"

namespace tumble::north_finding {
namespace {

/// North and up with their derivatives by azimuth, pitch and roll.
struct Slopes {
  Directions by_azimuth, by_pitch, by_roll;
};

struct Axes {
  Vector3 x, y, z;  ///< of the base, in the level axes whose first points along the azimuth, the second to its left

  Vector3 operator*(Vector3 v) const { return {dot(x, v), dot(y, v), dot(z, v)}; }
};

Axes axes_of(double pitch, double roll) {
  const double cp = std::cos(pitch), sp = std::sin(pitch), cr = std::cos(roll), sr = std::sin(roll);
  return {{cp, 0.0, sp}, {-sp * sr, cr, cp * sr}, {-sp * cr, -sr, cp * cr}};
}

const Vector3 up{0.0, 0.0, 1.0};
Vector3 north_at(double azimuth) { return {std::cos(azimuth), std::sin(azimuth), 0.0}; }

Slopes slopes_at(const State& s) {
  const double p = s[pitch], r = s[roll];
  const Axes axes = axes_of(p, r);
  const double cp = std::cos(p), sp = std::sin(p), cr = std::cos(r), sr = std::sin(r);
  const Axes by_pitch{{-sp, 0.0, cp}, {-cp * sr, 0.0, -sp * sr}, {-cp * cr, 0.0, -sp * cr}};
  const Axes by_roll{{}, axes.z, -1.0 * axes.y};
  const Vector3 north = north_at(s[azimuth]);
  return {
      {axes * Vector3{-north.y, north.x, 0.0}, {}}, {by_pitch * north, by_pitch * up}, {by_roll * north, by_roll * up}};
}

/// Sensitivity of the channel along the axes of the body [1].
Vector3 sensitivity(const State& s, Channel channel) {
  if (channel == gyro) return {1.0, s[gyro_y], s[gyro_z]};
  return channel == accelerometer_x ? Vector3{1.0, s[x_y], s[x_z]} : Vector3{s[y_x], 1.0, s[y_z]};
}

/// The field of the channel in the base: the Earth's rate or what supports the instrument.
Vector3 field(const State& s, Channel channel, const Directions& d) {
  if (channel != gyro) return s[gravity_here] * d.up;
  return earth_rate * (std::cos(s[latitude]) * d.north + std::sin(s[latitude]) * d.up);
}

Vector3 beside(Channel channel, const View& view) { return channel == gyro ? view.spin : view.force; }

double offset(const State& s, const Row& row) {
  return s[bias_of(row.channel)] + (row.channel == gyro ? s[gyro_drift] * row.time : 0.0);
}

/// Mean over the views of a vector of the base along the body's sensitivity.
double along(const std::vector<View>& views, Vector3 sensitive, Vector3 in_base) {
  double sum = 0.0;
  for (const auto& view : views) sum += view.weight * dot(sensitive, view.turn * in_base);
  return sum;
}

}  // namespace

const char* role_of(Channel channel) {
  return channel == gyro ? "gyro" : channel == accelerometer_x ? "accelerometer_x" : "accelerometer_y";
}

Directions directions_of(double azimuth, double pitch, double roll) {
  const Axes axes = axes_of(pitch, roll);
  return {axes * north_at(azimuth), axes * up};
}

std::pair<double, double> sensitivity_in_base(const Row& row) {
  double x = 0.0, y = 0.0;
  for (const auto& view : row.views) {
    const Vector3 axis = row.channel == accelerometer_y ? view.turn.y : view.turn.x;
    x += view.weight * axis.x;
    y += view.weight * axis.y;
  }
  return {x, y};
}

double output_of(const State& s, const Row& row, const std::vector<View>& views) {
  const Vector3 sensitive = sensitivity(s, row.channel);
  const Vector3 in_base = field(s, row.channel, directions_of(s[azimuth], s[pitch], s[roll]));
  double sum = along(views, sensitive, in_base);
  for (const auto& view : views) sum += view.weight * dot(sensitive, beside(row.channel, view));
  return s[scale_of(row.channel)] * (sum + offset(s, row));
}

double output_of(const State& state, const Row& row) { return output_of(state, row, row.views); }

std::array<double, quantities> slopes_of(const State& s, const Row& row) {
  std::array<double, quantities> out{};
  const auto& views = row.views;
  const double k = s[scale_of(row.channel)];
  const Vector3 sensitive = sensitivity(s, row.channel);
  const Directions d = directions_of(s[azimuth], s[pitch], s[roll]);
  const Slopes slopes = slopes_at(s);
  const auto by = [&](const Directions& change) { return k * along(views, sensitive, field(s, row.channel, change)); };
  out[azimuth] = by(slopes.by_azimuth);
  out[pitch] = by(slopes.by_pitch);
  out[roll] = by(slopes.by_roll);
  const Vector3 in_base = field(s, row.channel, d);
  const auto component = [&](Vector3 axis) {
    double sum = along(views, axis, in_base);
    for (const auto& view : views) sum += view.weight * dot(axis, beside(row.channel, view));
    return k * sum;
  };
  const double x = component({1.0, 0.0, 0.0}), y = component({0.0, 1.0, 0.0}), z = component({0.0, 0.0, 1.0});
  out[scale_of(row.channel)] = output_of(s, row) / k;
  out[bias_of(row.channel)] = k;
  if (row.channel == gyro) {
    out[latitude] =
        k * earth_rate * along(views, sensitive, std::cos(s[latitude]) * d.up - std::sin(s[latitude]) * d.north);
    out[gyro_drift] = k * row.time;
    out[gyro_y] = y;
    out[gyro_z] = z;
  } else {
    out[gravity_here] = k * along(views, sensitive, d.up);
    out[row.channel == accelerometer_x ? x_y : y_x] = row.channel == accelerometer_x ? y : x;
    out[row.channel == accelerometer_x ? x_z : y_z] = z;
  }
  return out;
}

double exact_azimuth(double rate_x, double rate_y, double up_x, double up_y, double latitude) {
  const double up_z = std::sqrt(1.0 - up_x * up_x - up_y * up_y);
  const double rate_z = (earth_rate * std::sin(latitude) - up_x * rate_x - up_y * rate_y) / up_z;
  const Vector3 u{up_x, up_y, up_z}, w{rate_x, rate_y, rate_z};
  const Vector3 north = w - dot(w, u) * u;
  return std::atan2(cross(north, u).x, north.x);
}

}  // namespace tumble::north_finding
