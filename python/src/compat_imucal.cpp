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

/// Samples of three axes, one row each, in any unit and any order in memory.
using Triads = nb::ndarray<const double, nb::shape<-1, 3>, nb::device::cpu>;
using Square = nb::ndarray<const double, nb::shape<3, 3>, nb::c_contig, nb::device::cpu>;
using Triple = nb::ndarray<const double, nb::shape<3>, nb::c_contig, nb::device::cpu>;
using Rows = std::array<std::array<double, 3>, 3>;
using Row = std::array<double, 3>;

/// One axis of them.
struct Axis {
  const double* first;
  std::int64_t step;
  std::size_t count;

  double operator[](std::size_t i) const { return first[static_cast<std::int64_t>(i) * step]; }
};

Axis axis_of(const Triads& values, std::size_t axis) {
  return {values.data() + static_cast<std::int64_t>(axis) * values.stride(1), values.stride(0), values.shape(0)};
}

double mean_of(const Axis& values) {
  double sums[4] = {};
  std::size_t i = 0;
  for (; i + 4 <= values.count; i += 4)
    for (std::size_t lane = 0; lane < 4; ++lane) sums[lane] += values[i + lane];
  for (; i < values.count; ++i) sums[0] += values[i];
  return ((sums[0] + sums[1]) + (sums[2] + sums[3])) / static_cast<double>(values.count);
}

Vector3 mean_of(const Triads& values) {
  return {mean_of(axis_of(values, 0)), mean_of(axis_of(values, 1)), mean_of(axis_of(values, 2))};
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

/// One column of the answer after the other.
using Answer = nb::ndarray<nb::numpy, double, nb::shape<-1, 3>, nb::f_contig>;

/// Adds row . values_i + offset to to_i. Step: from one sample of an axis to the next, 0 for any.
template <std::int64_t Step>
void combine(Vector3 row, double offset, const std::array<Axis, 3>& values, double* __restrict to) {
  const auto at = [&](const Axis& axis, std::size_t i) { return Step == 1 ? axis.first[i] : axis[i]; };
  const Axis x = values[0], y = values[1], z = values[2];
  for (std::size_t i = 0; i < x.count; ++i) to[i] += offset + row.x * at(x, i) + row.y * at(y, i) + row.z * at(z, i);
}

void combine(Vector3 row, double offset, const Triads& values, double* to) {
  const std::array<Axis, 3> axes{axis_of(values, 0), axis_of(values, 1), axis_of(values, 2)};
  if (axes[0].step == 1)
    combine<1>(row, offset, axes, to);
  else
    combine<0>(row, offset, axes, to);
}

/// matrix (values - offset), and matrix coupling other subtracted where there is another.
Answer applied(const Matrix3& matrix, Vector3 offset, const Triads& values, const Matrix3& coupling,
               const Triads* other) {
  const std::size_t count = values.shape(0);
  auto* const numbers = new double[3 * count]();
  const nb::capsule owner(numbers, [](void* it) noexcept { delete[] static_cast<double*>(it); });
  const Vector3 constant = matrix * offset;
  const Matrix3 coupled = matrix * coupling;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    combine(matrix[axis], -constant[axis], values, numbers + axis * count);
    if (other != nullptr) combine(-coupled[axis], 0.0, *other, numbers + axis * count);
  }
  return Answer(numbers, {count, 3}, owner, {1, static_cast<std::int64_t>(count)});
}

/// R^-1 K^-1 (values - b)
Answer calibrated(const Triads& values, const Square& k, const Square& r, const Triple& b) {
  return applied(inverse(matrix_of(r)) * inverse(matrix_of(k)), vector_of(b), values, {}, nullptr);
}

/// R^-1 K^-1 (values - K_ga force - b), force calibrated, row by row
Answer calibrated_rate(const Triads& values, const Square& k, const Square& r, const Triple& b, const Square& k_ga,
                       const Triads& force) {
  if (force.shape(0) != values.shape(0))
    throw Error(Error::Kind::bad_input, say("argument gyr: {} rows were given; accepted are as many as acc has, {}",
                                            values.shape(0), force.shape(0)));
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
