#include "tumble/reduce/linear/joint.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/reduce/linear/work.hpp"
#include "tumble/units/error.hpp"

namespace tumble::linear {
namespace {

constexpr double shown_of_error = 0.9;  ///< [1] of the variance of a rig error before the test, below which it is shown

void append(const Solution& output, Solution& all) {
  all.columns.insert(all.columns.end(), output.columns.begin(), output.columns.end());
  all.channels.insert(all.channels.end(), output.channels.begin(), output.channels.end());
  all.stands_for.insert(output.stands_for.begin(), output.stands_for.end());
  all.contains.insert(output.contains.begin(), output.contains.end());
  all.observations += output.observations;
  for (const auto& finding : output.findings) {
    const auto equal = [&](const Finding& f) { return f.message == finding.message && f.where == finding.where; };
    if (std::ranges::none_of(all.findings, equal)) all.findings.push_back(finding);
  }
}

JointSolution together(std::vector<Work> works) {
  std::vector<MixedData> data;
  std::vector<MixedFit> alone;
  for (auto& work : works) {
    data.push_back(std::move(work.data));
    alone.push_back(work.solution.fit);
  }
  JointFit joint = fit_joint_model(data, alone);
  JointSolution out;
  std::size_t parameter = 0, row = 0;
  for (auto& work : works) {
    const std::size_t rows = work.rows.weights.size();
    if (!work.rows.output.empty()) set_fitted(work, std::span(joint.fit.fitted).subspan(row, rows));
    append(work.solution, out.all);
    out.first.push_back(parameter);
    parameter += work.solution.columns.size();
    row += rows;
    out.outputs.push_back(std::move(work.solution));
  }
  out.all.fit = std::move(joint.fit);
  for (std::size_t i = 0; i < out.outputs.size(); ++i) add_doubt(out.outputs[i], out.first[i], out.all.fit);
  out.errors = std::move(joint.effects);
  return out;
}

/// A finding where the drift of an output comes from its segments alone: they do not show the drift that all share.
void say_unstated(std::span<const Problem> problems, JointSolution& solution) {
  std::vector<std::string> settings;
  auto severity = Finding::Severity::info;
  for (std::size_t i = 0; i < problems.size(); ++i) {
    if (problems[i].bias_instability > 0.0) continue;
    const Solution& output = solution.outputs[i];
    if (std::ranges::find(output.fit.slow_origin, SlowOrigin::contrasts) == output.fit.slow_origin.end()) continue;
    // as many as the likelihood needs to look for flicker
    if (output.segments.size() < output.columns.size() + 4) severity = Finding::Severity::warning;
    if (std::ranges::find(settings, problems[i].stated_by) == settings.end()) settings.push_back(problems[i].stated_by);
  }
  if (settings.empty()) return;
  solution.all.findings.push_back(
      {severity, "drift_from_segments_alone", {{"settings", fmt::format("{}", fmt::join(settings, ", "))}}});
}

}  // namespace

JointSolution identify(const Evidence& evidence, std::span<const Problem> problems) {
  auto solution = together(worked_out(evidence, problems));
  say_unstated(problems, solution);
  return solution;
}

JointSolution predict(const Plan& plan, std::span<const Problem> problems, std::span<const Truth> truths) {
  JointSolution out = together(worked_out(plan, problems, truths));
  out.all.fit.parameters.clear();
  for (const auto& output : out.outputs)
    out.all.fit.parameters.insert(out.all.fit.parameters.end(), output.fit.parameters.begin(),
                                  output.fit.parameters.end());
  return out;
}

Table rig_errors(const JointSolution& solution) {
  auto shown = solution.errors;
  std::erase_if(shown, [](const FoundEffect& error) { return !(error.sd < std::sqrt(shown_of_error)); });
  return tabulate("rig_errors",
                  "errors of the rig as this test shows them, in units of the standard uncertainty stated for each",
                  shown, {{"error", &FoundEffect::draw}, {"found", &FoundEffect::value}, {"sd", &FoundEffect::sd}});
}

}  // namespace tumble::linear
