#include "tumble/methods/static_bias/compensate.hpp"

#include <fmt/format.h>

#include "tumble/units/error.hpp"

namespace tumble::static_bias {
namespace {

std::vector<Term> subtracted_terms() {
  return {{"bias", "b", "", "constant output", [](const Felt&) { return 1.0; }}};
}

double& rate(Felt& felt) { return felt.rate.x; }
double& force(Felt& felt) { return felt.specific_force.x; }

/// The channel named for the signal, else the only one of the kind of the bias.
const Channel& signal_of(const Estimate& estimate, const Recording& recording, QuantityKind kind) {
  if (const Channel* named = channel_of(estimate, recording, "signal")) return *named;
  std::vector<const Channel*> all;
  for (const Channel& channel : recording.channels)
    if (channel.kind == kind && !channel.name.ends_with(".compensation_sd")) all.push_back(&channel);
  if (all.size() == 1) return *all.front();
  const std::string where = recording.origin.file.empty() ? "" : recording.origin.file + ": ";
  throw Error(Error::Kind::bad_data, all.empty()
                                         ? fmt::format("{}the recording has no channel of {}", where, name(kind))
                                         : fmt::format("{}several channels are possible, {} and {} among them, and the "
                                                       "result's [channels] signal names another one",
                                                       where, all[0]->name, all[1]->name));
}

void add_findings(const Estimate& estimate, const std::string& channel, Findings& findings) {
  const Table* runs = find_table(estimate, "runs");
  if (runs && runs->rows.size() == 1)
    findings.push_back({Finding::Severity::warning, "turn_on_change_not_included", {{"channel", channel}}, channel});
  const auto axis = estimate.provenance.settings.find("axis");
  if (axis == estimate.provenance.settings.end() || axis->second == "none" || axis->second.empty())
    findings.push_back({Finding::Severity::warning, "bias_of_one_attitude", {}, channel});
}

}  // namespace

Table covered() { return regressors_table(subtracted_terms(), {1.0}, {1.0}); }

Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan* plan) {
  const Parameter* bias = find_parameter(estimate, "bias");
  if (!bias) throw Error(Error::Kind::bad_file, "the result has no parameter bias");
  const bool is_rate = bias->unit.dimension() == Unit::parse("deg/h").dimension();
  const Channel& channel =
      signal_of(estimate, recording, is_rate ? QuantityKind::angular_rate : QuantityKind::specific_force);
  ErrorModel model;
  model.role = "signal";
  model.unit = channel.unit.text();
  model.shown = is_rate ? rate : force;
  model.terms = subtracted_terms();
  model.spread = "turn_on_repeatability";
  if (channel.unit.dimension() != bias->unit.dimension())
    throw Error(Error::Kind::bad_data,
                say("channel {} is in {}, but the bias in {}", channel.name, channel.unit.text(), bias->unit.text()));
  Estimate named = estimate;
  named.provenance.settings["channels.signal"] = channel.name;
  Compensation out = tumble::compensate(model, named, recording, plan);
  add_findings(estimate, channel.name, out.findings);
  return out;
}

}  // namespace tumble::static_bias
