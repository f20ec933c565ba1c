#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <tuple>
#include <vector>

#include "bindings.hpp"
#include "tumble/methods/imu_ferraris/closed_form.hpp"
#include "tumble/units/error.hpp"

namespace tumble::python {
namespace {

using namespace imu_ferraris;

/// Samples of three axes, one row each, in any unit.
using Triads = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Square = nb::ndarray<const double, nb::shape<3, 3>, nb::c_contig, nb::device::cpu>;
using Triple = nb::ndarray<const double, nb::shape<3>, nb::c_contig, nb::device::cpu>;
using Rows = std::array<std::array<double, 3>, 3>;
using Row = std::array<double, 3>;

Vector3 row(const Triads& values, std::size_t i) {
  const double* const p = values.data() + 3 * i;
  return {p[0], p[1], p[2]};
}

Vector3 mean_of(const Triads& values) {
  Vector3 sum;
  for (std::size_t i = 0; i < values.shape(0); ++i) sum += row(values, i);
  return sum / static_cast<double>(values.shape(0));
}

Row plain(Vector3 v) { return {v.x, v.y, v.z}; }
Rows plain(const Matrix3& m) { return {plain(m.x), plain(m.y), plain(m.z)}; }
Vector3 vector_of(const Triple& v) { return {v.data()[0], v.data()[1], v.data()[2]}; }
Matrix3 matrix_of(const Square& m) {
  const double* const p = m.data();
  return {{p[0], p[1], p[2]}, {p[3], p[4], p[5]}, {p[6], p[7], p[8]}};
}

/// Sections in the order of imu_ferraris: x_p, x_a, y_p, y_a, z_p, z_a, x_rot, y_rot, z_rot. Output in the units of the
/// samples for one of `gravity` and of `angle`/s.
/// Returned  K_a, R_a, b_a, K_g, R_g, K_ga, b_g
std::tuple<Rows, Rows, Row, Rows, Rows, Rows, Row> calibrate(const std::vector<Triads>& force,
                                                             const std::vector<Triads>& rate, double sample_rate,
                                                             double gravity, double angle) {
  if (force.size() != poses + turns || rate.size() != poses + turns)
    throw Error(Error::Kind::bad_input, "nine sections are needed");
  Means means{.gravity = gravity, .gyros = true};
  for (std::size_t p = 0; p < poses; ++p) {
    means.force[p] = mean_of(force[p]);
    means.rate[p] = mean_of(rate[p]);
    means.samples[p] = static_cast<double>(rate[p].shape(0));
  }
  for (std::size_t t = 0; t < turns; ++t) {
    means.turn_time[t] = static_cast<double>(rate[poses + t].shape(0)) / sample_rate;
    means.turned[t] = means.turn_time[t] * mean_of(rate[poses + t]);
    means.turn_force[t] = mean_of(force[poses + t]);
    means.angle[t] = angle;
  }
  const Calibration found = closed_form(means);
  return {
      plain(diagonal3(found.k_a)), plain(found.r_a), plain(found.b_a), plain(diagonal3(found.k_g)), plain(found.r_g),
      plain(found.k_ga),           plain(found.b_g)};
}

using Matrix2d = nb::ndarray<nb::numpy, double, nb::shape<-1, 3>>;

/// (values - offset - coupling * other) by a matrix; other: null for none.
Matrix2d applied(const Matrix3& matrix, Vector3 offset, const Triads& values, const Matrix3& coupling,
                 const Triads* other) {
  const std::size_t count = values.shape(0);
  auto* const kept = new std::vector<double>(3 * count);
  const nb::capsule owner(kept, [](void* it) noexcept { delete static_cast<std::vector<double>*>(it); });
  double* to = kept->data();
  for (std::size_t i = 0; i < count; ++i) {
    Vector3 v = row(values, i) - offset;
    if (other != nullptr) v = v - coupling * row(*other, i);
    v = matrix * v;
    *to++ = v.x, *to++ = v.y, *to++ = v.z;
  }
  return {kept->data(), {count, 3}, owner};
}

/// R^-1 K^-1 (values - b)
Matrix2d calibrated(const Triads& values, const Square& k, const Square& r, const Triple& b) {
  return applied(inverse(matrix_of(r)) * inverse(matrix_of(k)), vector_of(b), values, {}, nullptr);
}

/// R^-1 K^-1 (values - K_ga force - b), force calibrated, row by row
Matrix2d calibrated_rate(const Triads& values, const Square& k, const Square& r, const Triple& b, const Square& k_ga,
                         const Triads& force) {
  if (force.shape(0) != values.shape(0))
    throw Error(Error::Kind::bad_input, "argument gyr: " + std::to_string(values.shape(0)) +
                                            " rows were given; accepted are as many as acc has, " +
                                            std::to_string(force.shape(0)));
  return applied(inverse(matrix_of(r)) * inverse(matrix_of(k)), vector_of(b), values, matrix_of(k_ga), &force);
}

}  // namespace

void bind_compat_imucal(nb::module_& module) {
  using namespace nb::literals;
  module.def("ferraris", &calibrate, "force"_a, "rate"_a, "sample_rate"_a, "gravity"_a, "angle"_a);
  module.def("ferraris_calibrated", &calibrated, "values"_a, "k"_a, "r"_a, "b"_a);
  module.def("ferraris_calibrated_rate", &calibrated_rate, "values"_a, "k"_a, "r"_a, "b"_a, "k_ga"_a, "force"_a);
}

}  // namespace tumble::python
