#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/core/sampling_rate.hpp"
#include "tumble/methods/imu_turntable/turntable.hpp"
#include "tumble/reduce/compensation/outputs.hpp"
#include "tumble/units/error.hpp"

namespace tumble::imu_turntable {
namespace {

using imu::letters;
using imu::role_of;
using Severity = Finding::Severity;

constexpr int passes = 4;  ///< each takes the second order and the levers a factor of a thousand further

/// One output: bias, scale factor and misalignments are inverted by a matrix, the other terms subtracted.
struct OutputModel {
  compensation::KnownTerms known;
  std::vector<bool> inverted;  ///< for each known term
};

struct Triad {
  Kind kind = Kind::gyro;
  std::array<std::size_t, 3> channels{};  ///< in the recording
  std::array<double, 3> scale{};
  std::array<OutputModel, 3> models;
  Matrix3 inverse = identity3();
  Vector3 bias;
  Matrix3 by_acceleration = {};  ///< output i for an angular acceleration about axis j, by the levers
};

OutputModel model_of(const Estimate& estimate, Kind kind, std::size_t axis) {
  OutputModel model;
  model.known = compensation::known_terms(
      estimate, linear::terms_of("imu", defaults(find_model("imu").constants()), imu_turntable::terms_of(kind, axis)));
  for (const Term& term : model.known.terms) {
    const auto has = [&](const char* part) { return term.name.find(part) != std::string::npos; };
    model.inverted.push_back(has("_bias") || has("_scale_factor_error") || has("_misalignment"));
  }
  return model;
}

void set_matrix(const Estimate& estimate, Triad& triad) {
  const Matrix3 sensitivity = sensitivity_of(estimate, triad.kind);
  for (std::size_t i = 0; i < 3; ++i) triad.bias[i] = value_of(estimate, role_of(triad.kind, i) + "_bias");
  if (!(std::abs(determinant(sensitivity)) > 1e-6))
    throw Error(Error::Kind::bad_data, say("the {}s of the result do not show three directions: their matrix "
                                           "cannot be inverted",
                                           triad.kind == Kind::gyro ? "gyro" : "accelerometer"));
  triad.inverse = inverse(sensitivity);
}

void set_levers(Triad& triad) {
  for (std::size_t j = 0; j < 3; ++j) {
    Felt turning;
    turning.angular_acceleration[j] = 1.0;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& [known, inverted] = triad.models[i];
      for (std::size_t t = 0; t < known.terms.size(); ++t)
        if (!inverted[t]) triad.by_acceleration(i, j) += known.coefficients[t] * known.terms[t].regressor(turning);
    }
  }
}

bool calibrated(const Estimate& estimate, Kind kind) {
  return std::ranges::any_of(estimate.parameters,
                             [&](const Parameter& p) { return p.name.starts_with(role_of(kind, 0) + "_"); });
}

std::vector<Triad> triads_of(const Estimate& estimate, const Recording& recording) {
  const Settings settings = settings_of(estimate, imu::scale_factor_options());
  std::vector<Triad> triads;
  Problems problems;
  const Channel* first = nullptr;
  for (const Kind kind : {Kind::gyro, Kind::accelerometer}) {
    if (!calibrated(estimate, kind)) continue;
    Triad triad{.kind = kind};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto place = compensation::output_of(estimate, recording, role_of(kind, i), problems);
      if (!place) continue;
      const Channel& channel = recording.channels[*place];
      if (first && !sampled_together(*first, channel))
        problems.push_back(say("channels {} and {} are not sampled together: bring them to one clock first",
                               first->name, channel.name));
      first = first ? first : &channel;
      triad.channels[i] = *place;
      triad.scale[i] = imu::reading_of(kind, settings, channel).scale;
      triad.models[i] = model_of(estimate, kind, i);
    }
    set_matrix(estimate, triad);
    set_levers(triad);
    triads.push_back(std::move(triad));
  }
  if (triads.empty() && problems.empty())
    throw Error(Error::Kind::bad_file, "the result holds neither gyros nor accelerometers");
  compensation::refuse(recording, problems);
  return triads;
}

/// u = M (y - b - the other terms at the input so far).
Vector3 compensated(const Triad& triad, const Recording& recording, std::size_t k, const Felt& felt) {
  Vector3 y;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& [known, inverted] = triad.models[i];
    y[i] = triad.scale[i] * recording.channels[triad.channels[i]].values[k] - triad.bias[i];
    for (std::size_t t = 0; t < known.terms.size(); ++t)
      if (!inverted[t]) y[i] -= known.coefficients[t] * known.terms[t].regressor(felt);
  }
  return triad.inverse * y;
}

/// Central differences; a sample without both neighbours takes what there is.
void differentiate(const Channel& clock, std::vector<Felt>& felt) {
  for (std::size_t k = 0; k < felt.size(); ++k) {
    const std::size_t before = k > 0 ? k - 1 : k, after = k + 1 < felt.size() ? k + 1 : k;
    const double time = clock.time(after) - clock.time(before);
    const Vector3 change = felt[after].rate - felt[before].rate;
    felt[k].angular_acceleration = time > 0.0 && std::isfinite(norm(change)) ? (1.0 / time) * change : Vector3{};
  }
}

std::vector<Felt> felt_by(const std::vector<Triad>& triads, const Recording& recording) {
  const Channel& clock = recording.channels[triads.front().channels[0]];
  std::vector<Felt> felt(clock.values.size());
  for (auto& sample : felt) sample.temperature = 0.0;
  for (int pass = 0; pass < passes; ++pass)
    for (const Triad& triad : triads) {
      for (std::size_t k = 0; k < felt.size(); ++k) {
        Felt so_far = felt[k];
        // in a gap of one triad the other is compensated without it
        if (!std::isfinite(norm(so_far.rate))) so_far.rate = {};
        if (!std::isfinite(norm(so_far.specific_force))) so_far.specific_force = {};
        (triad.kind == Kind::gyro ? felt[k].rate : felt[k].specific_force) = compensated(triad, recording, k, so_far);
      }
      if (triad.kind == Kind::gyro) differentiate(clock, felt);
    }
  return felt;
}

/// Standard uncertainty of the angular acceleration by differences of the rates [rad/s^2], sample by sample. Where it
/// jumps within a sample, the central differences at that sample and beside it are off by up to half of what the
/// one-sided differences there are apart, and anything between is as likely: that half over sqrt(3).
std::vector<Vector3> acceleration_sd(const Channel& clock, const std::vector<Felt>& felt) {
  std::vector<Vector3> apart(felt.size()), sd(felt.size());
  for (std::size_t k = 1; k + 1 < felt.size(); ++k) {
    const double before = clock.time(k) - clock.time(k - 1), after = clock.time(k + 1) - clock.time(k);
    const Vector3 change =
        (1.0 / after) * (felt[k + 1].rate - felt[k].rate) - (1.0 / before) * (felt[k].rate - felt[k - 1].rate);
    if (std::isfinite(norm(change))) apart[k] = change;
  }
  for (std::size_t k = 0; k < felt.size(); ++k)
    for (std::size_t near = k > 0 ? k - 1 : k; near < std::min(k + 2, felt.size()); ++near)
      for (std::size_t i = 0; i < 3; ++i)
        sd[k][i] = std::max(sd[k][i], 0.5 / std::sqrt(3.0) * std::abs(apart[near][i]));
  return sd;
}

/// The greatest that the test covered, with a fiftieth over.
Felt limits_of(const Estimate& estimate) {
  const Table* table = find_table(estimate, "covered");
  if (!table || table->rows.size() != 3 || table->columns.size() != 3)
    throw Error(Error::Kind::bad_file,
                "the result has no table covered: it cannot be said where the compensation holds");
  const auto cell = [&](std::size_t row, std::size_t column) {
    return 1.02 * compensation::number_in(*table, table->rows[row][column]);
  };
  Felt felt;
  felt.rate = {cell(0, 1), cell(1, 1), cell(2, 1)};
  felt.specific_force = {cell(0, 2), cell(1, 2), cell(2, 2)};
  return felt;
}

bool beyond(Vector3 value, Vector3 limit, double slack) {
  return std::abs(value.x) > limit.x + slack || std::abs(value.y) > limit.y + slack ||
         std::abs(value.z) > limit.z + slack;
}

/// Output `i` of a triad in its place, and the channels of its uncertainty and of extrapolation.
void write(const Triad& triad, std::size_t i, const std::vector<Felt>& felt, const std::vector<Vector3>& acceleration,
           const std::vector<bool>& outside, Recording& recording) {
  Channel& channel = recording.channels[triad.channels[i]];
  const bool counted = channel.kind == QuantityKind::count || channel.kind == QuantityKind::other;
  const double scale = counted ? 1.0 : triad.scale[i];
  if (counted) {
    channel.kind = triad.kind == Kind::gyro ? QuantityKind::angular_rate : QuantityKind::specific_force;
    channel.unit = Unit::parse(triad.kind == Kind::gyro ? "deg/s" : "g");
  }
  auto [sd, extrapolated] = compensation::trust_in(channel);
  std::vector<double> phi;
  for (std::size_t k = 0; k < felt.size(); ++k) {
    const double value = imu::component(imu::field_of(triad.kind, felt[k]), i);
    const double by_levers = norm(scaled(triad.by_acceleration[i], acceleration[k]));
    const double by_terms = compensation::predicted(triad.models[i].known, felt[k], phi).sd;
    sd.values[k] = std::isnan(value) ? value : std::hypot(by_terms, by_levers) / std::abs(scale);
    extrapolated.values[k] = std::isnan(value) ? value : outside[k] ? 1.0 : 0.0;
    channel.values[k] = value / scale;
  }
  recording.channels.push_back(std::move(sd));
  recording.channels.push_back(std::move(extrapolated));
}

}  // namespace

Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan*) {
  const auto triads = triads_of(estimate, recording);
  const Felt limit = limits_of(estimate);
  const auto felt = felt_by(triads, recording);
  std::vector<bool> outside(felt.size());
  std::size_t far = 0, first = 0;
  for (std::size_t k = 0; k < felt.size(); ++k) {
    outside[k] = beyond(felt[k].rate, limit.rate, si(0.1, "deg/s")) ||
                 beyond(felt[k].specific_force, limit.specific_force, si(0.02, "g"));
    if (outside[k] && far++ == 0) first = k;
  }
  Compensation out{recording, {}, {}};
  const auto acceleration = acceleration_sd(recording.channels[triads.front().channels[0]], felt);
  for (const Triad& triad : triads)
    for (std::size_t i = 0; i < 3; ++i) write(triad, i, felt, acceleration, outside, out.recording);
  if (triads.size() == 1)
    out.findings.push_back(
        {Severity::info,
         triads.front().kind == Kind::gyro ? "acceleration_sensitivity_remains" : "lever_effect_remains",
         {}});
  if (far > 0)
    out.findings.push_back({Severity::warning,
                            "beyond_rates_and_forces",
                            {{"share", static_cast<double>(far) / static_cast<double>(felt.size()), "%"}},
                            "",
                            {far, recording.channels[triads.front().channels[0]].time(first), {}}});
  return out;
}

}  // namespace tumble::imu_turntable
