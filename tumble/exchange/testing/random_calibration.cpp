#include "tumble/exchange/testing/random_calibration.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/random.hpp"

namespace tumble::testing {
namespace {

/// Numbers between -1 and 1, one after the other.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : stream_(seed) {}
  double operator()(double size) { return size * (2.0 * stream_.uniform(next_++) - 1.0); }
  Vector3 vector(double size) { return {(*this)(size), (*this)(size), (*this)(size)}; }
  Matrix3 matrix(double size) { return {vector(size), vector(size), vector(size)}; }

 private:
  RandomStream stream_;
  std::uint64_t next_ = 0;
};

void draw_triad(Draw& draw, const Parts& parts, bool gyro, TriadCalibration& t) {
  t.calibrated = true;
  t.axes = {true, true, true};
  t.output = Unit::parse(gyro ? "rad/s" : "m/s^2");
  const Matrix3 drawn = draw.matrix(0.05);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      if (i == j ? parts.scale : parts.misalignment) t.response(i, j) += drawn(i, j);
  const Vector3 bias = draw.vector(gyro ? 0.02 : 0.5);
  if (parts.bias) t.bias = bias;
  if (gyro && parts.by_force) t.by_force = draw.matrix(1e-3);
  if (!gyro && parts.lever) t.lever = draw.matrix(0.05);
  for (std::size_t i = 0; i < 3; ++i) {
    if (parts.curve) t.curve[i] = {{draw(1e-4), draw(1e-5), 0.0, 0.0}, draw(1e-3), draw(1e-5)};
    if (parts.table && i != 1) {  // one axis has none, and the tables of the others differ in length
      const double reach = gyro ? 4.0 : 19.6;
      for (int k = -4; k <= (i == 0 ? 4 : 2); ++k) {
        t.curve[i].table.at.push_back(0.25 * reach * (k + draw(0.3)));
        t.curve[i].table.departure.push_back(draw(1e-3) * reach);
      }
    }
    if (parts.thermal_bias) t.thermal[i].output = {draw(1e-3), draw(1e-5), draw(1e-7)};
    if (parts.thermal_scale) t.thermal[i].scale = {draw(1e-4), draw(1e-6)};
    if (parts.noise) t.noise[i] = {.white = 1e-3 * (2.0 + draw(1.0)), .walk = 1e-4 * (2.0 + draw(1.0))};
  }
  t.range = gyro ? Vector3{4.0, 4.0, 4.0} : Vector3{19.6, 19.6, 19.6};
}

}  // namespace

ImuCalibration random_calibration(std::uint64_t seed, const Parts& parts) {
  Draw draw(seed);
  ImuCalibration c;
  draw_triad(draw, parts, false, c.accelerometers);
  draw_triad(draw, parts, true, c.gyros);
  c.title = "random calibration";
  c.serial = std::to_string(seed);
  if (parts.thermal_bias || parts.thermal_scale)
    c.reference_temperature = 293.15, c.coldest = 263.15, c.hottest = 323.15;
  return c;
}

ImuSample random_truth(std::uint64_t seed) {
  Draw draw(seed ^ 0x5eedU);
  ImuSample truth{draw.vector(19.6), draw.vector(4.0), 293.15 + draw(30.0), {}};
  truth.angular_acceleration = draw.vector(10.0);
  return truth;
}

double difference(const ImuSample& a, const ImuSample& b) {
  return std::max(norm(a.force - b.force), norm(a.rate - b.rate));
}

}  // namespace tumble::testing
