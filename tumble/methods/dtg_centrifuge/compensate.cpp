#include "tumble/methods/dtg_centrifuge/compensate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/methods/dtg_centrifuge/data.hpp"
#include "tumble/models/model.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::dtg_centrifuge {
namespace {

using Severity = Finding::Severity;

/// Terms of the drift that one output's parameters give, with their covariance.
struct Drift {
  std::vector<Term> terms;
  std::vector<double> coefficients;
  Matrix covariance;
};

/// Specific force that the test covered.
struct Range {
  double force = 0.0;             ///< [m/s^2] greatest across the spin axis
  bool up = false, down = false;  ///< orientations of the spin axis
};

Drift drift_of(const Estimate& estimate, const std::string& prefix) {
  Drift drift;
  std::vector<std::size_t> used;
  const Settings constants = defaults(truth_options(find_model("dynamically_tuned_gyro")));
  const auto outputs = find_model("dynamically_tuned_gyro").outputs(constants);
  for (const auto& term : outputs[prefix.empty() ? 0 : 1].terms)
    for (std::size_t p = 0; p < estimate.parameters.size(); ++p) {
      const Parameter& parameter = estimate.parameters[p];
      if (parameter.name != term.name || parameter.name == prefix + "D_xy") continue;
      if (!std::isfinite(parameter.value) || parameter.unit.dimension() != Unit::parse(term.unit).dimension())
        throw Error(Error::Kind::bad_file,
                    fmt::format("the result's parameter '{}' has no value in {}", parameter.name, term.unit));
      drift.terms.push_back(term);
      drift.coefficients.push_back(parameter.value);
      used.push_back(p);
    }
  drift.covariance = Matrix(used.size(), used.size());
  for (std::size_t r = 0; r < used.size(); ++r)
    for (std::size_t c = 0; c < used.size(); ++c) drift.covariance(r, c) = estimate.covariance(used[r], used[c]);
  return drift;
}

Range range_of(const Estimate& estimate) {
  const Table* table = find_table(estimate, "nonlinearity");
  Range range;
  if (table != nullptr && table->columns.size() > 3)
    for (const auto& row : table->rows) {
      const auto* force = std::get_if<double>(&row[2]);
      const auto* spin = std::get_if<std::string>(&row[3]);
      if (force == nullptr || spin == nullptr) continue;
      range.force = std::max(range.force, *force);
      (*spin == "up" ? range.up : range.down) = true;
    }
  if (!(range.force > 0.0))
    throw Error(Error::Kind::bad_file, "the result has no table nonlinearity, which says where the compensation holds");
  return range;
}

const Channel* role(const Estimate& estimate, const Recording& recording, const std::string& name) {
  const auto setting = estimate.provenance.settings.find("channels." + name);
  return find_channel(recording, setting == estimate.provenance.settings.end() ? name : setting->second);
}

/// Specific force along an axis: as the plan names it, else specific_force_x, accelerometer_x or the only
/// <name>.accelerometer_x.
const Channel* force_along(const Estimate& estimate, const Recording& recording, const std::string& axis) {
  if (const Channel* named = role(estimate, recording, "specific_force_" + axis)) return named;
  const std::string model = "accelerometer_" + axis;
  const Channel* only = find_channel(recording, model);
  if (only != nullptr) return only;
  for (const Channel& channel : recording.channels)
    if (channel.name.ends_with("." + model)) {
      if (only != nullptr) return nullptr;
      only = &channel;
    }
  return only;
}

struct Inputs {
  std::map<std::string, std::size_t> outputs;  ///< by prefix: index in the recording
  std::array<const Channel*, 3> force{};
};

Inputs inputs_of(const Estimate& estimate, const Recording& recording) {
  Inputs out;
  std::vector<std::string> problems;
  for (const std::string prefix : {"", "y_"}) {
    const Channel* gyro = role(estimate, recording, prefix.empty() ? "gyro" : "gyro_y");
    if (gyro == nullptr && prefix.empty()) problems.push_back("the recording has no channel for the role gyro");
    if (gyro == nullptr || find_parameter(estimate, prefix + "D_x") == nullptr) continue;
    if (find_channel(recording, gyro->name + ".extrapolated") != nullptr)
      problems.push_back("channel " + gyro->name + " is compensated already: its drift would be subtracted twice");
    out.outputs[prefix] = static_cast<std::size_t>(gyro - recording.channels.data());
  }
  const char* axes[] = {"x", "y", "z"};
  for (std::size_t k = 0; k < 3; ++k) {
    out.force[k] = force_along(estimate, recording, axes[k]);
    if (out.force[k] == nullptr)
      problems.push_back(
          fmt::format("the recording has no channel specific_force_{0} or accelerometer_{0} that says the "
                      "specific force along {0}",
                      axes[k]));
    else if (out.force[k]->kind != QuantityKind::specific_force)
      problems.push_back(fmt::format("channel {} is in {}, which is not a specific force", out.force[k]->name,
                                     out.force[k]->unit.text()));
  }
  if (problems.empty())
    for (const auto& [prefix, index] : out.outputs)
      for (const Channel* force : out.force)
        if (!one_clock(recording.channels[index], *force))
          problems.push_back(fmt::format("channels {} and {} are not sampled together: bring them to one clock first",
                                         recording.channels[index].name, force->name));
  if (!problems.empty()) {
    for (auto& problem : problems)
      problem = (recording.origin.file.empty() ? "" : recording.origin.file + ": ") + problem;
    throw Error(Error::Kind::bad_data, problems);
  }
  return out;
}

/// Whether the test covered this specific force.
bool within(const Range& range, Vector3 f) {
  constexpr double slack = 1.02, g = standard_gravity;
  if (std::hypot(f.x, f.y) > slack * range.force) return false;
  if (range.up && range.down) return std::abs(f.z) < slack * g;
  return std::abs(f.z - (range.up ? g : -g)) < 0.1 * g;
}

struct Subtracted {
  double raw = 0.0, compensated = 0.0;  ///< sums of squares about the mean
  double first_outside = 0.0;
  std::size_t samples = 0, outside = 0, blank = 0;
};

Subtracted subtract(const Drift& drift, const Inputs& inputs, const Range& range, Channel& gyro, Channel& sd,
                    Channel& outside) {
  Subtracted out;
  const std::size_t n = drift.terms.size();
  std::vector<double> phi(n);
  double sum[2] = {}, square[2] = {};
  for (std::size_t i = 0; i < gyro.values.size(); ++i) {
    Felt felt;
    felt.specific_force = {inputs.force[0]->values[i], inputs.force[1]->values[i], inputs.force[2]->values[i]};
    double predicted = 0.0;
    for (std::size_t t = 0; t < n; ++t) predicted += drift.coefficients[t] * (phi[t] = drift.terms[t].regressor(felt));
    const double variance = quadratic_form(phi, drift.covariance);
    const double raw = gyro.values[i];
    gyro.values[i] -= predicted;
    sd.values[i] = std::isnan(variance) ? variance : std::sqrt(std::max(0.0, variance));
    const bool beyond = !within(range, felt.specific_force);
    outside.values[i] = beyond ? 1.0 : 0.0;
    out.blank += std::isnan(predicted) && !std::isnan(raw);
    if (std::isnan(gyro.values[i])) continue;
    if (beyond && out.outside++ == 0) out.first_outside = gyro.time(i);
    ++out.samples;
    const double values[2] = {raw, gyro.values[i]};
    for (int k = 0; k < 2; ++k) {
      sum[k] += values[k];
      square[k] += values[k] * values[k];
    }
  }
  const double count = static_cast<double>(out.samples);
  if (out.samples > 1) {
    out.raw = std::sqrt(std::max(0.0, (square[0] - sum[0] * sum[0] / count) / (count - 1.0)));
    out.compensated = std::sqrt(std::max(0.0, (square[1] - sum[1] * sum[1] / count) / (count - 1.0)));
  }
  return out;
}

void add_findings(const Subtracted& outcome, const Range& range, const std::string& channel, Findings& findings) {
  const double share = static_cast<double>(outcome.outside) / static_cast<double>(outcome.samples);
  if (outcome.outside > 0)
    findings.push_back({Severity::warning,
                        "force_outside_tested_range",
                        {{"share", share, "%"},
                         {"across", range.force, "g"},
                         {"least_along", si(range.down ? -1.0 : 1.0, "g"), "g"},
                         {"most_along", si(range.up ? 1.0 : -1.0, "g"), "g"},
                         {"channel", channel}},
                        channel,
                        {outcome.outside, outcome.first_outside, {}}});
  if (outcome.blank > 0)
    findings.push_back({Severity::warning, "samples_without_force", {}, channel, {outcome.blank, {}, {}}});
}

Table empty_table() {
  const Unit one, rate = Unit::parse("deg/h");
  return {"compensation",
          "sd of the samples before and after",
          {{"channel", one},
           {"sd raw", rate},
           {"sd compensated", rate},
           {"ratio", one},
           {"outside calibrated range", Unit::parse("%")}},
          {}};
}

}  // namespace

Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan*) {
  const Range range = range_of(estimate);
  if (find_parameter(estimate, "D_x") == nullptr || find_parameter(estimate, "D_y") == nullptr)
    throw Error(
        Error::Kind::bad_data,
        "the result holds the size of the sensitive term only, not D_x and D_y: identify with the angles of arm "
        "and table and estimator = \"regression\"");
  const Inputs inputs = inputs_of(estimate, recording);
  Compensation out{recording, {}, {}};
  Table table = empty_table();
  for (const auto& [prefix, index] : inputs.outputs) {
    Channel sd = recording.channels[index];
    Channel outside = sd;
    sd.name += ".compensation_sd";
    outside.name += ".extrapolated";
    outside.kind = QuantityKind::other;
    outside.unit = Unit();
    Channel& gyro = out.recording.channels[index];
    const Subtracted outcome = subtract(drift_of(estimate, prefix), inputs, range, gyro, sd, outside);
    add_findings(outcome, range, gyro.name, out.findings);
    table.rows.push_back({gyro.name, outcome.raw, outcome.compensated, outcome.compensated / outcome.raw,
                          static_cast<double>(outcome.outside) / std::max(1.0, static_cast<double>(outcome.samples))});
    out.recording.channels.push_back(std::move(sd));
    out.recording.channels.push_back(std::move(outside));
  }
  out.tables.push_back(std::move(table));
  return out;
}

}  // namespace tumble::dtg_centrifuge
