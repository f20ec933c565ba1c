#include "tumble/tasks/prediction/problem.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/core/budget.hpp"
#include "tumble/math/golden_section.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble::prediction {
namespace {

constexpr double least_excitation = 1e-8;
constexpr int instants_of_a_move = 40;
constexpr int probes = 16;
constexpr double most_samples = 1e9;
constexpr std::size_t most_segments = 5000;

/// Fractions that no period of a motion hits twice.
double fraction(int i) { return golden_fraction(static_cast<std::size_t>(i), 0.5); }

/// A bench, a table and a chamber in all directions: what a regressor is measured against.
std::vector<Felt> strong_motions() {
  std::vector<Felt> out;
  const RandomStream random(1);
  const auto vector = [&](int i, int k, double size) {
    const auto draw = random.split(static_cast<std::uint64_t>(i)).split(static_cast<std::uint64_t>(k));
    return size * Vector3{draw.normal(0), draw.normal(1), draw.normal(2)};
  };
  for (int i = 0; i < probes; ++i) {
    const Vector3 thermal = vector(i, 3, 10.0);
    out.push_back({.rate = vector(i, 0, 1.0),
                   .angular_acceleration = vector(i, 1, 1.0),
                   .specific_force = vector(i, 2, 10.0),
                   .temperature = 293.15 + thermal.x,
                   .temperature_gradient = 0.1 * thermal.y,
                   .temperature_rate = 1e-3 * thermal.z,
                   .start_temperature = 293.15 + thermal.y,
                   .since_power_on = 100.0 * i});
  }
  return out;
}

double largest(const Term& term, const std::vector<Felt>& felt) {
  double most = 0.0;
  for (const auto& one : felt) most = std::max(most, std::abs(term.regressor(one)));
  return most;
}

/// The columns that may go first where not all can be told apart: those without a true value, then the others, the
/// last in the table first.
std::vector<std::string> dispensable(const std::vector<Term>& terms, const std::map<std::string, double>& truth) {
  std::vector<std::string> out;
  for (const bool zero : {true, false})
    for (auto term = terms.rbegin(); term != terms.rend(); ++term)
      if ((truth.at(term->name) == 0.0) == zero) out.push_back(term->name);
  return out;
}

void describe(const OutputProblem& output, Estimate& estimate) {
  if (output.not_excited.empty()) return;
  std::string names;
  for (const auto& term : output.not_excited) names += (names.empty() ? "" : ", ") + term.name;
  estimate.findings.push_back({Finding::Severity::info, "not_excited", {{"terms", names}}, output.problem.channel});
}

}  // namespace

void refuse_unpredictable(const Plan& plan) {
  Problems problems;
  if (plan.instrument_model.empty()) problems.push_back("to predict, the plan needs [instrument] model = \"...\"");
  if (plan.rig_kind.empty()) problems.push_back("to predict, the plan needs [rig] kind = \"...\"");
  if (!(plan.sample_rate > 0.0))
    problems.push_back("to predict, the plan needs [instrument] rate = \"1 Hz\" or the like");
  if (plan.schedule.empty()) problems.push_back("to predict, the plan needs at least one [[schedule]]");
  if (plan.schedule.size() > most_segments)
    problems.push_back(say("the schedule has {} segments, and {} can be predicted: all are correlated",
                           plan.schedule.size(), most_segments));
  double samples = 0.0;
  for (const auto& segment : plan.schedule) samples += segment.duration * plan.sample_rate;
  if (samples > most_samples)
    problems.push_back(
        say("the schedule has {:.2g} samples, and {:.2g} can be predicted: is [instrument] rate "
            "(here {:g} Hz) right?",
            samples, most_samples, plan.sample_rate));
  if (plan.truth.texts().empty())
    problems.push_back(
        "to predict, the plan needs [truth] with the noise of the instrument: angle_random_walk = \"...\"");
  else if (!plan.instrument_model.empty()) {
    std::vector<std::string> silent;
    for (const auto& output : find_model(plan.instrument_model).outputs(plan.truth))
      if (!(noise_of(plan.truth, output.noise_prefix).angle_random_walk > 0.0))
        if (const auto name = output.noise_prefix + "angle_random_walk";
            std::ranges::find(silent, name) == silent.end())
          silent.push_back(name);
    for (const auto& name : silent)
      problems.push_back(say(
          "to predict, [truth] must state the white noise of the instrument: {} = \"...\"; without it the uncertainty "
          "would be that of the rig alone",
          name));
  }
  if (!plan.file.empty())
    for (auto& problem : problems) problem = in_file(plan.file, problem);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

std::vector<Felt> felt_over(const Plan& plan) {
  std::vector<Felt> out;
  for (std::size_t first = 0; first < plan.schedule.size();) {
    RigRun run{{}, plan.rig, plan.site, plan.sample_rate, {}, RandomStream{0}};
    while (first < plan.schedule.size() && (run.segments.empty() || plan.schedule[first].run == run.segments[0].run))
      run.segments.push_back(plan.schedule[first++]);
    const Reference reference = find_rig(plan.rig_kind).reference(run);
    double begin = 0.0;
    for (std::size_t s = 0; s < run.segments.size(); ++s) {
      const double end = begin + run.segments[s].duration, from = std::clamp(reference.settled[s], begin, end);
      const bool rests = !reference.steady_until || reference.steady_until(from) >= end;
      for (int i = 0; i < (rests ? 1 : instants_of_a_move); ++i) {
        Felt felt;
        reference.felt(from + fraction(i) * (end - from), 1.0, {&felt, 1});
        out.push_back(felt);
      }
      begin = end;
    }
  }
  return out;
}

bool excited(const Term& term, const std::vector<Felt>& felt) {
  return largest(term, felt) > least_excitation * largest(term, strong_motions());
}

Problems problems_of_terms(const Plan& plan, const std::vector<std::string>& names) {
  std::vector<std::string> known;
  Problems problems;
  for (const auto& output : find_model(plan.instrument_model).outputs(plan.truth))
    for (const auto& term : output.terms) known.push_back(term.name);
  for (const auto& name : names)
    if (std::ranges::find(known, name) == known.end())
      problems.push_back(say("{} has no term '{}'{}", plan.instrument_model, name, did_you_mean(name, known)));
  return problems;
}

std::vector<OutputProblem> output_problems(const Plan& plan, const std::vector<Felt>& felt,
                                           const std::vector<std::string>& only) {
  const Model& model = find_model(plan.instrument_model);
  std::vector<OutputProblem> out;
  for (const auto& output : model.outputs(plan.truth)) {
    OutputProblem one;
    one.problem.channel = output.channel;
    one.problem.input = output.input;
    std::map<std::string, double> truth;
    const auto coefficients = coefficients_of(model, output, plan.truth);
    for (std::size_t k = 0; k < coefficients.size(); ++k) truth[output.terms[k].name] = coefficients[k];
    for (const auto& term : output.terms) {
      if (!only.empty() && std::ranges::find(only, term.name) == only.end()) continue;
      (excited(term, felt) ? one.problem.columns : one.not_excited).push_back(term);
    }
    one.problem.leave_out_first = dispensable(one.problem.columns, truth);
    one.problem.oversampling = std::max(1, plan.truth.integer("oversampling"));
    one.problem.averaging = std::max(1.0, 1.0 / plan.sample_rate);
    for (const auto& [name, member] :
         {std::pair{"settling", &TermProblem::settling}, std::pair{"averaging", &TermProblem::averaging}})
      if (plan.settings.texts().contains(name)) one.problem.*member = plan.settings.number(name);
    out.push_back(std::move(one));
  }
  return out;
}

Estimate predict_outputs(const Plan& plan, const std::vector<OutputProblem>& outputs) {
  std::vector<TermProblem> problems;
  for (const auto& output : outputs)
    if (!output.problem.columns.empty()) problems.push_back(output.problem);
  if (problems.empty()) return {};
  Estimate whole;
  auto parts = predict_terms(plan, problems);
  std::size_t next = 0;
  for (const auto& output : outputs) {
    if (output.problem.columns.empty()) continue;
    describe(output, parts[next]);
    append(whole, parts[next++]);
  }
  gather_small(whole);
  return whole;
}

}  // namespace tumble::prediction
