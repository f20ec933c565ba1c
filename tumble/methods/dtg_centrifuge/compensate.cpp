#include "tumble/methods/dtg_centrifuge/compensate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "tumble/methods/dtg_centrifuge/data.hpp"
#include "tumble/models/model.hpp"
#include "tumble/reduce/compensation/outputs.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::dtg_centrifuge {
namespace {

using compensation::known_terms;
using compensation::KnownTerms;
using compensation::output_of;
using compensation::Trust;
using Severity = Finding::Severity;

/// Specific force that the test covered.
struct Range {
  double force = 0.0;             ///< [m/s^2] greatest across the spin axis
  bool up = false, down = false;  ///< orientations of the spin axis
};

/// A quintic's f_X a^4 and f_Y a^4, a^2 = f_X^2 + f_Y^2, as the lines at the table's angle show them.
void add_quintic(const std::string& prefix, std::vector<Term>& terms) {
  const auto square = [](const Vector3& f) { return f.x * f.x + f.y * f.y; };
  terms.push_back({prefix + "p_4", "p_4", "deg/h/g^5", "", [square](const Felt& felt) {
                     return felt.specific_force.x * std::pow(square(felt.specific_force), 2);
                   }});
  terms.push_back({prefix + "q_4", "q_4", "deg/h/g^5", "", [square](const Felt& felt) {
                     return felt.specific_force.y * std::pow(square(felt.specific_force), 2);
                   }});
}

/// Terms of the drift that one output's parameters give, without the quadratic one, which a rate of the table gives
/// too.
KnownTerms drift_of(const Estimate& estimate, const std::string& prefix) {
  const Settings constants = defaults(truth_options(find_model("dynamically_tuned_gyro")));
  auto terms = find_model("dynamically_tuned_gyro").outputs(constants)[prefix.empty() ? 0 : 1].terms;
  std::erase_if(terms, [&](const Term& term) { return term.name == prefix + "D_xy"; });
  add_quintic(prefix, terms);
  return known_terms(estimate, terms);
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

/// Specific force along an axis: as the plan names it, else specific_force_x, accelerometer_x or the only
/// <name>.accelerometer_x.
const Channel* force_along(const Estimate& estimate, const Recording& recording, const std::string& axis) {
  if (const Channel* named = channel_of(estimate, recording, "specific_force_" + axis)) return named;
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
  Problems problems;
  for (const std::string prefix : {"", "y_"}) {
    const std::string role = prefix.empty() ? "gyro" : "gyro_y";
    if (!prefix.empty() &&
        (!channel_of(estimate, recording, role) || find_parameter(estimate, prefix + "D_x") == nullptr))
      continue;
    const auto place = output_of(estimate, recording, role, problems);
    if (!place) continue;
    compensation::require_dimension(&recording.channels[*place], "deg/h", problems);
    out.outputs[prefix] = *place;
  }
  const char* axes[] = {"x", "y", "z"};
  for (std::size_t k = 0; k < 3; ++k) {
    out.force[k] = force_along(estimate, recording, axes[k]);
    if (out.force[k] == nullptr)
      problems.push_back(
          say("the recording has no channel specific_force_{0} or accelerometer_{0} that says the "
              "specific force along {0}",
              axes[k]));
    else if (out.force[k]->kind != QuantityKind::specific_force)
      problems.push_back(
          say("channel {} is in {}, which is not a specific force", out.force[k]->name, out.force[k]->unit.text()));
  }
  if (problems.empty())
    for (const auto& [prefix, index] : out.outputs)
      for (const Channel* force : out.force)
        if (!one_clock(recording.channels[index], *force))
          problems.push_back(say("channels {} and {} are not sampled together: bring them to one clock first",
                                 recording.channels[index].name, force->name));
  compensation::refuse(recording, problems);
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

Subtracted subtract(const KnownTerms& drift, const Inputs& inputs, const Range& range, Channel& gyro, Trust& trust) {
  Subtracted out;
  std::vector<double> phi;
  double sum[2] = {}, square[2] = {};
  for (std::size_t i = 0; i < gyro.values.size(); ++i) {
    Felt felt;
    felt.specific_force = {inputs.force[0]->values[i], inputs.force[1]->values[i], inputs.force[2]->values[i]};
    const auto [predicted, sd] = compensation::predicted(drift, felt, phi);
    const double raw = gyro.values[i];
    gyro.values[i] -= predicted;
    trust.sd.values[i] = sd;
    const bool beyond = !within(range, felt.specific_force);
    trust.extrapolated.values[i] = beyond ? 1.0 : 0.0;
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
    Trust trust = compensation::trust_in(recording.channels[index]);
    Channel& gyro = out.recording.channels[index];
    const Subtracted outcome = subtract(drift_of(estimate, prefix), inputs, range, gyro, trust);
    add_findings(outcome, range, gyro.name, out.findings);
    table.rows.push_back({gyro.name, outcome.raw, outcome.compensated, outcome.compensated / outcome.raw,
                          static_cast<double>(outcome.outside) / std::max(1.0, static_cast<double>(outcome.samples))});
    out.recording.channels.push_back(std::move(trust.sd));
    out.recording.channels.push_back(std::move(trust.extrapolated));
  }
  out.tables.push_back(std::move(table));
  return out;
}

}  // namespace tumble::dtg_centrifuge
