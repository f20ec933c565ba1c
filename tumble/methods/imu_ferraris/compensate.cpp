#include "tumble/methods/imu_ferraris/compensate.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "tumble/math/eigen/dense.hpp"
#include "tumble/math/eigen/view.hpp"
#include "tumble/methods/imu_ferraris/sections.hpp"
#include "tumble/reduce/imu/sensors.hpp"
#include "tumble/units/error.hpp"

namespace tumble::imu_ferraris {
namespace {

using Three = Eigen::Matrix3d;
using Vector = Eigen::Vector3d;
using imu::letters;

/// One matrix of the table [SI]; a vector is its first row.
Three matrix_of(const Table& table, const std::string& name, int rows = 3) {
  Three m = Three::Zero();
  int row = 0;
  for (const auto& cells : table.rows) {
    if (std::get<std::string>(cells[0]) != name || row > 2) continue;
    const Unit unit = Unit::parse(std::get<std::string>(cells[2]));
    for (int j = 0; j < 3; ++j) m(row, j) = std::get<double>(cells[3 + static_cast<std::size_t>(j)]) * unit.factor();
    ++row;
  }
  if (row != rows) throw Error(Error::Kind::bad_file, "the result's table matrices lacks " + name);
  return m;
}

/// Accelerometers or gyros: output = response input + sensitivity force + bias.
struct Triad {
  Three response, unresponse, cosines, sensitivity = Three::Zero();
  Vector scale, bias;
  Eigen::MatrixXd covariance;  ///< of its parameters
  int each = 4;                ///< parameters of an output
};

Triad triad_of(const Estimate& estimate, const Table& table, bool gyros) {
  Triad t;
  t.scale = matrix_of(table, gyros ? "K_g" : "K_a").diagonal();
  t.cosines = matrix_of(table, gyros ? "R_g" : "R_a");
  t.bias = matrix_of(table, gyros ? "b_g" : "b_a", 1).row(0).transpose();
  t.response = t.scale.asDiagonal() * t.cosines;
  t.unresponse = t.response.inverse();
  if (gyros) t.sensitivity = matrix_of(table, "K_ga");
  t.each = gyros ? 7 : 4;
  const int first = gyros ? 12 : 0, count = 3 * t.each;
  if (static_cast<int>(estimate.covariance.rows) < first + count)
    throw Error(Error::Kind::bad_file, "the result's covariance does not belong to its parameters");
  t.covariance = map(estimate.covariance).block(first, first, count, count);
  return t;
}

/// Standard uncertainty of the three inputs, from that of the parameters.
Vector uncertainty(const Triad& t, const Vector& input, const Vector& force) {
  Eigen::Matrix<double, 3, Eigen::Dynamic> slope = Eigen::MatrixXd::Zero(3, 3 * t.each);
  for (int i = 0; i < 3; ++i) {
    int p = i * t.each;
    slope(i, p++) = t.cosines.row(i).dot(input);
    slope(i, p++) = 1.0;
    for (int j = 0; j < 3; ++j)  // rows of R have unit length: the cosine along the axis itself follows the others
      if (j != i) slope(i, p++) = t.scale[i] * (input[j] - t.cosines(i, j) / t.cosines(i, i) * input[i]);
    for (int j = 0; j < 3 && t.each > 4; ++j) slope(i, p++) = force[j];
  }
  const Eigen::MatrixXd of = t.unresponse * slope;
  return (of * t.covariance * of.transpose()).diagonal().cwiseMax(0.0).cwiseSqrt();
}

struct Channels {
  std::array<std::size_t, outputs> index{};
  bool gyros = false;
};

/// The channels that played the roles, in units of the dimension that was calibrated.
Channels channels_of(const Estimate& estimate, const Recording& recording, const Table& table) {
  Channels out;
  out.gyros = table.rows.size() > 7;
  std::vector<std::string> problems;
  for (std::size_t k = 0; k < (out.gyros ? outputs : 3); ++k) {
    const auto role = imu::role_of(k < 3 ? imu::Kind::accelerometer : imu::Kind::gyro, k % 3);
    const auto known = estimate.provenance.settings.find("channels." + role);
    const auto& name = known == estimate.provenance.settings.end() ? role : known->second;
    const Channel* channel = find_channel(recording, name);
    if (!channel) {
      problems.push_back(fmt::format("no channel '{}' for {}", name, role));
      continue;
    }
    out.index[k] = static_cast<std::size_t>(channel - recording.channels.data());
    const Parameter* bias = find_parameter(estimate, role + "_bias");
    if (!bias) throw Error(Error::Kind::bad_file, fmt::format("the result lacks {}_bias", role));
    if (channel->unit.dimension() != bias->unit.dimension())
      problems.push_back(
          fmt::format("{} is in {}, but was calibrated in {}", name, channel->unit.text(), bias->unit.text()));
    if (find_channel(recording, name + ".compensation_sd"))
      problems.push_back(name + " is compensated already: it would be done twice");
    if (channel->values.size() != recording.channels[out.index[0]].values.size())
      problems.push_back(name + " has not as many samples as the accelerometers");
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
  return out;
}

}  // namespace

Compensation compensate(const Estimate& estimate, const Recording& recording) {
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
    sd.push_back(channel);
    sd.back().name += ".compensation_sd";
  }
  const auto take = [&](std::size_t first, std::size_t i) {
    Vector v;
    for (int k = 0; k < 3; ++k)
      v[k] = recording.channels[channels.index[first + static_cast<std::size_t>(k)]].values[i];
    return v;
  };
  const auto put = [&](std::size_t first, std::size_t i, const Vector& value, const Vector& u) {
    for (int k = 0; k < 3; ++k) {
      const std::size_t at = first + static_cast<std::size_t>(k);
      out.recording.channels[channels.index[at]].values[i] = value[k];
      sd[at].values[i] = u[k];
    }
  };
  for (std::size_t i = 0; i < samples; ++i) {
    const Vector force = accelerometers.unresponse * (take(0, i) - accelerometers.bias);
    put(0, i, force, uncertainty(accelerometers, force, force));
    if (!channels.gyros) continue;
    const Vector rate = gyros.unresponse * (take(3, i) - gyros.sensitivity * force - gyros.bias);
    put(3, i, rate, uncertainty(gyros, rate, force));
  }
  for (auto& channel : sd) out.recording.channels.push_back(std::move(channel));
  return out;
}

}  // namespace tumble::imu_ferraris
