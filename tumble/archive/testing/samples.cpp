#include "tumble/archive/testing/samples.hpp"

#include "tumble/core/budget.hpp"
#include "tumble/core/instant.hpp"
#include "tumble/report/report.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::testing {

std::string sample_json(const SampleResult& sample) {
  const Unit unit = Unit::parse("deg/h");
  Estimate estimate;
  estimate.method = "static_bias";
  estimate.title = "Bias of a gyro at rest";
  estimate.instrument_model = "gyro";
  estimate.instrument_serial = sample.serial;
  Parameter bias;
  bias.name = "bias";
  bias.symbol = "D_F";
  bias.unit = unit;
  bias.value = unit.to_si(sample.bias);
  bias.description = "bias";
  estimate.parameters.push_back(bias);
  const double sd = unit.to_si(sample.sd);
  estimate.budget.push_back(independent_errors("noise", {sd * sd}));
  if (!sample.rig.empty()) estimate.budget.push_back({"rig", sample.rig, Matrix(1, 1, unit.to_si(sample.rig_sd))});
  estimate.covariance = covariance_of(estimate.budget, 1);
  estimate.tables.push_back(table_of({{"data.csv", {"2026-03-01T11:00:00Z", sample.ended}}}));
  estimate.provenance.inputs.push_back({"data.csv", sample.recording_sha256});
  return to_json(estimate);
}

ResultDeposit sample_deposit(const SampleResult& sample) {
  return {.json = sample_json(sample), .file = sample.serial + ".json"};
}

ArchiveAct sample_act(const std::string& why) { return {"Li Wei", "2026-03-02T09:00:00Z", why}; }

}  // namespace tumble::testing
