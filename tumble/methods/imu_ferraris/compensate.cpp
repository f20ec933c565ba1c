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

/// Accelerometers or gyros: output = scale cosines input + sensitivity force + bias.
struct Triad {
  bool gyros = false;
  Vector3 scale, bias;
  Matrix3 cosines, unresponse, sensitivity;
  Matrix covariance;  ///< of its parameters, in the order of parameters_of()
};

/// Value [SI] and place of a parameter of the result.
double value_of(const Estimate& estimate, const std::string& name, std::vector<std::size_t>& places) {
  const Parameter* parameter = find_parameter(estimate, name);
  if (parameter == nullptr) throw Error(Error::Kind::bad_file, say("the result lacks {}", name));
  places.push_back(static_cast<std::size_t>(parameter - estimate.parameters.data()));
  return parameter->value;
}

/// Sign of the diagonal of R in row `i`, which no parameter states: -1 where the table `matrices` has it so.
double sign_of_diagonal(const Estimate& estimate, bool gyros, std::size_t i) {
  const Table* table = find_table(estimate, "matrices");
  if (table == nullptr || table->columns.size() != 6) return 1.0;
  std::size_t row = 0;
  for (const auto& cells : table->rows) {
    const auto* of = std::get_if<std::string>(&cells[0]);
    if (of && *of == (gyros ? "R_g" : "R_a") && row++ == i)
      return compensation::number_in(*table, cells[3 + i]) < 0.0 ? -1.0 : 1.0;
  }
  return 1.0;
}

Triad triad_of(const Estimate& estimate, bool gyros) {
  Triad t;
  t.gyros = gyros;
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string role = imu::role_of(gyros ? imu::Kind::gyro : imu::Kind::accelerometer, i);
    t.scale[i] = value_of(estimate, role + "_scale_factor", places);
    t.bias[i] = value_of(estimate, role + "_bias", places);
    double others = 0.0;
    for (std::size_t j = 0; j < 3; ++j) {
      if (j == i) continue;
      t.cosines(i, j) = value_of(estimate, fmt::format("{}_misalignment_{}", role, imu::letters[j]), places);
      others += t.cosines(i, j) * t.cosines(i, j);
    }
    t.cosines(i, i) = sign_of_diagonal(estimate, gyros, i) * std::sqrt(std::max(1.0 - others, 0.0));
    for (std::size_t j = 0; gyros && j < 3; ++j)
      t.sensitivity(i, j) =
          value_of(estimate, fmt::format("{}_acceleration_sensitivity_{}", role, imu::letters[j]), places);
  }
  t.unresponse = inverse(response(t.scale, t.cosines));
  if (estimate.covariance.rows != estimate.parameters.size())
    throw Error(Error::Kind::bad_file, "the result's covariance does not belong to its parameters");
  t.covariance = chosen_columns(chosen_rows(estimate.covariance, places), places);
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
Channels channels_of(const Estimate& estimate, const Recording& recording) {
  Channels out;
  out.gyros = find_parameter(estimate, "gyro_x_scale_factor") != nullptr;
  Problems problems;
  for (std::size_t k = 0; k < (out.gyros ? outputs : 3); ++k) {
    const auto role = imu::role_of(k < 3 ? imu::Kind::accelerometer : imu::Kind::gyro, k % 3);
    const auto place = compensation::output_of(estimate, recording, role, problems);
    if (!place) continue;
    out.index[k] = *place;
    const Channel& channel = recording.channels[*place];
    const Parameter* bias = find_parameter(estimate, role + "_bias");
    if (!bias) throw Error(Error::Kind::bad_file, say("the result lacks {}_bias", role));
    if (channel.unit.dimension() != bias->unit.dimension())
      problems.push_back(
          say("channel {} is in {}, but was calibrated in {}", channel.name, channel.unit.text(), bias->unit.text()));
    if (const Channel& first = recording.channels[out.index[0]]; problems.empty() && !sampled_together(first, channel))
      problems.push_back(
          say("channels {} and {} are not sampled together: bring them to one clock first", first.name, channel.name));
  }
  compensation::refuse(recording, problems);
  return out;
}

/// The greatest rates and forces of the session, with a fiftieth over.
struct Limits {
  Vector3 rate, force;
};

Limits limits_of(const Estimate& estimate) {
  const Table* table = find_table(estimate, "covered");
  if (!table || table->rows.size() != 3 || table->columns.size() != 3)
    throw Error(Error::Kind::bad_file,
                "the result has no table covered: it cannot be said where the compensation holds");
  Limits limits;
  for (std::size_t i = 0; i < 3; ++i) {
    limits.rate[i] = 1.02 * compensation::number_in(*table, table->rows[i][1]);
    limits.force[i] = 1.02 * compensation::number_in(*table, table->rows[i][2]);
  }
  return limits;
}

bool beyond(Vector3 value, Vector3 limit, double slack) {
  for (std::size_t i = 0; i < 3; ++i)
    if (std::abs(value[i]) > limit[i] + slack) return true;
  return false;
}

/// The outputs in the making: of each the channel, its uncertainty and whether it is extrapolated.
struct Written {
  const Recording& recording;
  const Channels& channels;
  Recording& out;
  std::vector<compensation::Trust> trust = {};

  Vector3 taken(std::size_t first, std::size_t sample) const {
    Vector3 v;
    for (std::size_t k = 0; k < 3; ++k) v[k] = recording.channels[channels.index[first + k]].values[sample];
    return v;
  }
  void put(std::size_t first, std::size_t sample, Vector3 value, Vector3 sd, bool outside) {
    for (std::size_t k = 0; k < 3; ++k) {
      out.channels[channels.index[first + k]].values[sample] = value[k];
      trust[first + k].sd.values[sample] = sd[k];
      trust[first + k].extrapolated.values[sample] = std::isnan(value[k]) ? value[k] : outside ? 1.0 : 0.0;
    }
  }
};

}  // namespace

Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan*) {
  const Channels channels = channels_of(estimate, recording);
  const Limits limits = limits_of(estimate);
  const Triad accelerometers = triad_of(estimate, false);
  const Triad gyros = channels.gyros ? triad_of(estimate, true) : Triad{};
  Compensation out{recording, {}, {}};
  Written written{recording, channels, out.recording};
  const std::size_t used = channels.gyros ? outputs : 3, samples = recording.channels[channels.index[0]].values.size();
  for (std::size_t k = 0; k < used; ++k) {
    Channel& channel = out.recording.channels[channels.index[k]];
    channel.kind = k < 3 ? QuantityKind::specific_force : QuantityKind::angular_rate;
    channel.unit = Unit::parse(k < 3 ? "m/s^2" : "deg/s");
    written.trust.push_back(compensation::trust_in(channel));
  }
  std::size_t far = 0, first = 0;
  for (std::size_t i = 0; i < samples; ++i) {
    const Vector3 force = accelerometers.unresponse * (written.taken(0, i) - accelerometers.bias);
    Vector3 rate;
    if (channels.gyros) rate = gyros.unresponse * (written.taken(3, i) - gyros.sensitivity * force - gyros.bias);
    const bool outside =
        beyond(force, limits.force, si(0.02, "g")) || (channels.gyros && beyond(rate, limits.rate, si(0.1, "deg/s")));
    if (outside && far++ == 0) first = i;
    written.put(0, i, force, uncertainty(accelerometers, force, force), outside);
    if (channels.gyros) written.put(3, i, rate, uncertainty(gyros, rate, force), outside);
  }
  for (auto& [sd, extrapolated] : written.trust) {
    out.recording.channels.push_back(std::move(sd));
    out.recording.channels.push_back(std::move(extrapolated));
  }
  if (far > 0)
    out.findings.push_back({Finding::Severity::warning,
                            "beyond_rates_and_forces",
                            {{"share", static_cast<double>(far) / static_cast<double>(samples), "%"}},
                            "",
                            {far, recording.channels[channels.index[0]].time(first), {}}});
  return out;
}

}  // namespace tumble::imu_ferraris
