#include "tumble/methods/imu_ferraris/compensate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tumble/core/sampling_rate.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/methods/imu_ferraris/closed_form.hpp"
#include "tumble/methods/imu_ferraris/sections.hpp"
#include "tumble/reduce/compensation/outputs.hpp"
#include "tumble/reduce/imu/sensors.hpp"
#include "tumble/units/error.hpp"

namespace tumble::imu_ferraris {
namespace {

/// One matrix of the table [SI]; a vector is its first row.
Matrix3 matrix_of(const Table& table, const std::string& name, std::size_t rows = 3) {
  Matrix3 m;
  std::size_t row = 0;
  for (const auto& cells : table.rows) {
    const auto *of = std::get_if<std::string>(&cells[0]), *unit = std::get_if<std::string>(&cells[2]);
    if (!of || !unit || *of != name || row > 2) continue;
    for (std::size_t j = 0; j < 3; ++j)
      m(row, j) = compensation::number_in(table, cells[3 + j]) * Unit::parse(*unit).factor();
    ++row;
  }
  if (row != rows) throw Error(Error::Kind::bad_file, "the result's table matrices lacks " + name);
  return m;
}

/// Accelerometers or gyros: output = scale cosines input + sensitivity force + bias.
struct Triad {
  bool gyros = false;
  Vector3 scale, bias;
  Matrix3 cosines, unresponse, sensitivity;
  Matrix covariance;  ///< of its parameters, in the order of parameters_of()
};

Triad triad_of(const Estimate& estimate, const Table& table, bool gyros) {
  Triad t;
  t.gyros = gyros;
  t.scale = diagonal_of(matrix_of(table, gyros ? "K_g" : "K_a"));
  t.cosines = matrix_of(table, gyros ? "R_g" : "R_a");
  t.bias = matrix_of(table, gyros ? "b_g" : "b_a", 1).x;
  t.unresponse = inverse(response(t.scale, t.cosines));
  if (gyros) t.sensitivity = matrix_of(table, "K_ga");
  const std::size_t first = gyros ? 12 : 0, count = gyros ? 21 : 12;
  if (estimate.covariance.rows < first + count)
    throw Error(Error::Kind::bad_file, "the result's covariance does not belong to its parameters");
  t.covariance = block(estimate.covariance, first, count, first, count);
  return t;
}

/// Derivatives of the three outputs by their own parameters, one output after the other.
std::vector<double> slopes(const Triad& t, Vector3 input, Vector3 force) {
  std::vector<double> all;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3 cosines = t.cosines[i];
    all.insert(all.end(), {dot(cosines, input), 1.0});
    for (std::size_t j = 0; j < 3;
         ++j)  // rows of R have unit length: the cosine along the axis itself follows the others
      if (j != i) all.push_back(t.scale[i] * (input[j] - cosines[j] / cosines[i] * input[i]));
    if (t.gyros) all.insert(all.end(), {force.x, force.y, force.z});
  }
  return all;
}

/// Standard uncertainty of the three inputs, from that of the parameters.
Vector3 uncertainty(const Triad& t, Vector3 input, Vector3 force) {
  const auto of_outputs = slopes(t, input, force);
  const std::size_t each = of_outputs.size() / 3;
  Vector3 sd;
  for (std::size_t k = 0; k < 3; ++k) {
    auto of_input = of_outputs;
    for (std::size_t p = 0; p < of_input.size(); ++p) of_input[p] *= t.unresponse(k, p / each);
    sd[k] = std::sqrt(std::max(quadratic_form(of_input, t.covariance), 0.0));
  }
  return sd;
}

struct Channels {
  std::array<std::size_t, outputs> index{};
  bool gyros = false;
};

/// The channels of the roles, in units of the dimension that was calibrated.
Channels channels_of(const Estimate& estimate, const Recording& recording, const Table& table) {
  Channels out;
  out.gyros = table.rows.size() > 7;
  std::vector<std::string> problems;
  for (std::size_t k = 0; k < (out.gyros ? outputs : 3); ++k) {
    const auto role = imu::role_of(k < 3 ? imu::Kind::accelerometer : imu::Kind::gyro, k % 3);
    const auto place = compensation::output_of(estimate, recording, role, problems);
    if (!place) continue;
    out.index[k] = *place;
    const Channel& channel = recording.channels[*place];
    const Parameter* bias = find_parameter(estimate, role + "_bias");
    if (!bias) throw Error(Error::Kind::bad_file, fmt::format("the result lacks {}_bias", role));
    if (channel.unit.dimension() != bias->unit.dimension())
      problems.push_back(fmt::format("channel {} is in {}, but was calibrated in {}", channel.name, channel.unit.text(),
                                     bias->unit.text()));
    if (const Channel& first = recording.channels[out.index[0]]; problems.empty() && !sampled_together(first, channel))
      problems.push_back(fmt::format("channels {} and {} are not sampled together: bring them to one clock first",
                                     first.name, channel.name));
  }
  compensation::refuse(recording, problems);
  return out;
}

}  // namespace

Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan*) {
  const Table* table = find_table(estimate, "matrices");
  if (!table || table->columns.size() != 6) throw Error(Error::Kind::bad_file, "the result has no table matrices");
  const Channels channels = channels_of(estimate, recording, *table);
  const Triad accelerometers = triad_of(estimate, *table, false);
  const Triad gyros = channels.gyros ? triad_of(estimate, *table, true) : Triad{};
  Compensation out{recording, {}, {}};
  const std::size_t used = channels.gyros ? outputs : 3, samples = recording.channels[channels.index[0]].values.size();
  std::vector<Channel> sd;
  for (std::size_t k = 0; k < used; ++k) {
    Channel& channel = out.recording.channels[channels.index[k]];
    channel.kind = k < 3 ? QuantityKind::specific_force : QuantityKind::angular_rate;
    channel.unit = Unit::parse(k < 3 ? "m/s^2" : "deg/s");
    sd.push_back(compensation::trust_in(channel).sd);
  }
  const auto take = [&](std::size_t first, std::size_t i) {
    Vector3 v;
    for (std::size_t k = 0; k < 3; ++k) v[k] = recording.channels[channels.index[first + k]].values[i];
    return v;
  };
  const auto put = [&](std::size_t first, std::size_t i, Vector3 value, Vector3 u) {
    for (std::size_t k = 0; k < 3; ++k) {
      out.recording.channels[channels.index[first + k]].values[i] = value[k];
      sd[first + k].values[i] = u[k];
    }
  };
  for (std::size_t i = 0; i < samples; ++i) {
    const Vector3 force = accelerometers.unresponse * (take(0, i) - accelerometers.bias);
    put(0, i, force, uncertainty(accelerometers, force, force));
    if (!channels.gyros) continue;
    const Vector3 rate = gyros.unresponse * (take(3, i) - gyros.sensitivity * force - gyros.bias);
    put(3, i, rate, uncertainty(gyros, rate, force));
  }
  for (auto& channel : sd) out.recording.channels.push_back(std::move(channel));
  return out;
}

}  // namespace tumble::imu_ferraris
