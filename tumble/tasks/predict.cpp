#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "tumble/tasks/calibration.hpp"
#include "tumble/tasks/prediction/advice.hpp"
#include "tumble/tasks/prediction/problem.hpp"
#include "tumble/tasks/prediction/simulated_tests.hpp"
#include "tumble/tasks/prior.hpp"
#include "tumble/tasks/provenance.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using namespace prediction;

void describe_prediction(const Plan& plan, Estimate& estimate) {
  estimate.method = plan.method.empty() ? "predict" : plan.method;
  estimate.instrument_model = plan.instrument_model;
  estimate.instrument_serial = plan.instrument_serial;
  estimate.provenance = provenance_of(plan);
  if (estimate.title.empty()) estimate.title = plan.title.empty() ? estimate.method : plan.title;
}

/// What to add if the schedule excites terms that it does not distinguish.
void add_advice(const Plan& plan, const std::vector<Felt>& felt, const OutputProblem& output, Findings& findings) {
  const auto advice = advise(plan, felt, output.problem.columns, output.not_excited);
  if (!advice.add.empty())
    findings.push_back({Finding::Severity::info,
                        "add_to_schedule",
                        {{"additions", fmt::format("{}", fmt::join(advice.add, "; "))}},
                        output.problem.channel});
  if (!advice.out_of_reach.empty())
    findings.push_back({Finding::Severity::info,
                        "out_of_reach_of_rig",
                        {{"rig", plan.rig_kind}, {"terms", fmt::format("{}", fmt::join(advice.out_of_reach, ", "))}},
                        output.problem.channel});
}

/// With what the plan's prior adds: the values are those of the truth, so that it is not asked whether the unit
/// belongs.
Estimate with_prior(Plan plan, Estimate estimate) {
  read_prior(plan);
  add_prior(plan, estimate, true);
  return estimate;
}

}  // namespace

Estimate predict_model(const Plan& plan, const std::vector<std::string>& terms, bool advise) {
  refuse_unpredictable(plan);
  if (const auto problems = problems_of_terms(plan, terms); !problems.empty())
    throw Error(Error::Kind::bad_input, problems);
  const auto felt = felt_over(plan);
  const auto outputs = output_problems(plan, felt, terms);
  if (std::ranges::all_of(outputs, [](const auto& output) { return output.problem.columns.empty(); }))
    throw Error(Error::Kind::bad_input,
                say("{}: the schedule excites no term of {}", Name{plan.file}, Name{plan.instrument_model}));
  auto estimate = predict_outputs(plan, outputs);
  for (const auto& output : outputs)
    if (advise) add_advice(plan, felt, output, estimate.findings);
  describe_prediction(plan, estimate);
  return with_prior(plan, std::move(estimate));
}

Estimate predict(const Plan& plan) {
  const auto* method = plan.method.empty() ? nullptr : &find_method(plan.method);
  if (!method) return predict_model(plan, {});
  refuse_unpredictable(plan);
  Plan whole = plan;
  read_calibration(whole);
  auto estimate = method->predict ? method->predict(whole) : predict_by_tests(whole);
  describe_prediction(whole, estimate);
  return with_prior(whole, std::move(estimate));
}

}  // namespace tumble
