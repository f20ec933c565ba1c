#include "tumble/tasks/optimise.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/language/say.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/tasks/optimisation/criteria.hpp"
#include "tumble/tasks/optimisation/improve.hpp"
#include "tumble/tasks/optimisation/order.hpp"
#include "tumble/tasks/optimisation/points.hpp"
#include "tumble/tasks/optimisation/report.hpp"
#include "tumble/tasks/optimisation/standard.hpp"
#include "tumble/tasks/optimisation/work.hpp"
#include "tumble/tasks/plan_file/write_schedule.hpp"
#include "tumble/tasks/prior.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using namespace prediction;
using namespace optimisation;

constexpr std::uint64_t seed = 20150917;
constexpr int starts = 4;                   ///< besides the usual schedules
constexpr double quanta = 100.0;            ///< in the time of a power-up
constexpr int few_steps = 6;                ///< where a prediction takes a dozen simulated tests
constexpr double work_of_search = 20000.0;  ///< segments x parameters: a prediction of many takes a second
constexpr double worth_it = 0.999;          ///< [1] of the criterion: less is not worth another schedule

bool same_motions(const Segment& a, const Segment& b) {
  return std::ranges::equal(a.axes, b.axes, [](const auto& x, const auto& y) {
    return x.first == y.first && x.second.kind == y.second.kind && x.second.value == y.second.value;
  });
}

void refuse_impossible(const Plan& plan, const OptimiseOptions& options) {
  Problems problems;
  const auto collect = [&](auto check) {
    try {
      check();
    } catch (const Error& error) {
      problems.insert(problems.end(), error.problems.begin(), error.problems.end());
    }
  };
  collect([&] { refuse_unpredictable(plan); });
  if (options.total_time && !(*options.total_time > 0.0)) problems.push_back("the total time must be above zero");
  if (!(options.step > 0.0) || options.step > pi)
    problems.push_back("the step between positions must be above zero and at most 180 deg");
  for (const auto& segment : plan.schedule)
    for (const auto& [axis, motion] : segment.axes)
      if (motion.kind == Motion::Kind::ramp || motion.kind == Motion::Kind::random)
        problems.push_back(say("segment '{}': {} {}: only holds, rates and oscillations are optimised", segment.label,
                               Name{axis}, motion.kind == Motion::Kind::ramp ? "is ramped" : "moves at random"));
  if (!plan.instrument_model.empty())
    for (auto& problem : problems_of_terms(plan, options.terms)) problems.push_back(std::move(problem));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

/// The model's terms that can be told.
std::vector<std::string> terms_told(const Work& work) {
  std::vector<std::string> out;
  const auto estimate = predict_model(everything(work), work.only, false);
  for (const auto& output : find_model(work.plan.instrument_model).outputs(work.plan.truth))
    for (const auto& term : output.terms)
      if (find_parameter(estimate, term.name)) out.push_back(term.name);
  return out;
}

Work prepare(const Plan& plan, const OptimiseOptions& options) {
  Work work;
  work.plan = plan;
  const auto* method = plan.method.empty() ? nullptr : &find_method(plan.method);
  work.from_terms = !method || !options.terms.empty();
  work.only = options.terms;
  for (const auto& segment : plan.schedule)
    if (std::ranges::find(work.runs, segment.run) == work.runs.end()) work.runs.push_back(segment.run);
  work.time = options.total_time.value_or(total_of(plan.schedule)) / static_cast<double>(work.runs.size());
  work.closing = plan.schedule.size() > 2 && same_motions(plan.schedule.front(), plan.schedule.back());
  if (plan.settings.texts().contains("settling")) work.settling = plan.settings.number("settling");
  auto range = range_of(plan, options.step);
  limit_to_instrument(plan, range);
  work.all = candidates(plan, range);
  std::erase_if(work.all, [&](const Candidate& one) {
    return one.setup + work.settling + std::max(one.least, shortest_dwell) > 0.5 * work.time;
  });
  if (work.all.empty())
    throw Error(Error::Kind::bad_input, say("{}: {} is too short for any two motions of the rig {} with its settling",
                                            Name{plan.file}, Name{say_seconds(work.time)}, Name{plan.rig_kind}));
  work.terms = terms_told(work);
  if (work.from_terms) work.only = work.names = work.terms;
  return work;
}

bool drifts(const Plan& plan) {
  for (const auto& output : find_model(plan.instrument_model).outputs(plan.truth)) {
    const auto noise = noise_of(plan.truth, output.noise_prefix);
    if (noise.bias_instability > 0.0 || noise.rate_random_walk > 0.0 || noise.markov_sd > 0.0 || noise.rate_ramp != 0.0)
      return true;
  }
  return false;
}

/// Information of the plan's prior about the terms: the population of a unit of the model as one more observation.
/// Terms that the method identifies under another name are searched without it.
void add_population(const PriorChoice& choice, const std::vector<std::string>& terms, Matrix& information) {
  if (!choice.population) return;
  const Estimate& population = *choice.population;
  std::vector<std::size_t> which, place;
  for (std::size_t t = 0; t < terms.size(); ++t)
    for (std::size_t k = 0; k < population.parameters.size(); ++k)
      if (population.parameters[k].name == terms[t] && population.parameters[k].contains.empty())
        which.push_back(k), place.push_back(t);
  const Matrix covariance = chosen_columns(chosen_rows(population.covariance, which), which);
  if (which.empty() || !cholesky(covariance).positive) return;
  const Matrix inverse = inverse_symmetric(covariance);
  for (std::size_t i = 0; i < which.size(); ++i)
    for (std::size_t j = 0; j < which.size(); ++j) information(place[i], place[j]) += inverse(i, j);
}

DesignProblem design_problem(const Work& work, const DesignSpace& space) {
  DesignProblem problem;
  problem.points = space.points;
  problem.parameters = space.terms.size() + space.errors.size();
  problem.weights.assign(problem.parameters, 0.0);
  problem.prior = Matrix(problem.parameters, problem.parameters);
  for (std::size_t e = space.terms.size(); e < problem.parameters; ++e) problem.prior(e, e) = 1.0;
  add_population(work.plan.prior, space.terms, problem.prior);
  problem.effort = work.time;
  problem.quantum = std::max(work.time / quanta, 1.0 / work.plan.sample_rate);
  return problem;
}

/// The model's outputs that the method or the user asks something of.
std::vector<OutputProblem> outputs_of(const Work& work) {
  auto outputs = output_problems(with_schedule(work.plan, schedule_of(work.plan, work.all, Visits(1), 0.0)),
                                 felt_of(work.all), work.terms);
  std::erase_if(outputs, [](const OutputProblem& output) { return output.problem.columns.empty(); });
  return outputs;
}

/// One for every term.
void weigh_for_d(const DesignSpace& space, DesignProblem& problem) {
  problem.criterion = DesignCriterion::D;
  std::fill_n(problem.weights.begin(), space.terms.size(), 1.0);
}

/// One over the variance that every term is compared with.
void weigh_for_a(const Work& work, const DesignSpace& space, const std::vector<double>& reference,
                 DesignProblem& problem) {
  problem.criterion = DesignCriterion::A;
  for (std::size_t k = 0; k < space.terms.size(); ++k) {
    const auto term = std::ranges::find(work.terms, space.terms[k]) - work.terms.begin();
    const double unit = reference[static_cast<std::size_t>(term)];
    problem.weights[k] = std::isfinite(unit) && unit > 0.0 ? 1.0 / (unit * unit) : 0.0;
  }
}

/// Visits that the exchange finds, in their order.
Visits searched(const Work& work, const DesignProblem& problem, const std::vector<StandardSet>& standard) {
  std::vector<Design> from;
  for (const auto& set : standard) {
    Design design;
    double setup = 0.0;
    for (const auto j : set.candidates) setup += problem.points[j].setup;
    for (const auto j : set.candidates)
      design.push_back({j, (problem.effort - setup) / static_cast<double>(set.candidates.size())});
    if (setup < problem.effort) from.push_back(std::move(design));
  }
  Visits visits;
  for (const auto& visit : exchange(problem, seed, starts, from)) visits.push_back({visit.point, visit.effort});
  if (visits.empty()) return {};
  return ordered(work.plan, work.all, std::move(visits), drifts(work.plan), seed);
}

/// The parameters by which schedules are compared: those of the plan as it is, and the terms of the model that the
/// method shows where it shows nothing but terms.
void name_parameters(Work& work, const ScheduleRow& own) {
  if (work.from_terms) return;
  bool all_terms = true;
  if (own.estimate)
    for (const auto& parameter : own.estimate->parameters) {
      work.names.push_back(parameter.name);
      all_terms = all_terms && std::ranges::find(work.terms, parameter.name) != work.terms.end();
    }
  if ((!all_terms || !is_quick(work)) && !work.names.empty()) return;
  const auto most = predicted_row(work, "", everything(work).schedule);
  if (most.estimate)
    for (const auto& parameter : most.estimate->parameters)
      if (std::ranges::find(work.names, parameter.name) == work.names.end()) work.names.push_back(parameter.name);
  if (work.names.empty())
    throw Error(Error::Kind::bad_input, say("{}: the plan itself cannot be predicted, so that nothing can be compared "
                                            "with it: {}",
                                            Name{work.plan.file}, own.refused));
}

/// A schedule that the exchange found, and its visits.
struct Exchanged {
  ScheduleRow row;
  Visits visits;
};

Exchanged exchanged_by(const Work& work, const char* name, const DesignProblem& problem,
                       const std::vector<StandardSet>& standard) {
  auto visits = searched(work, problem, standard);
  return {predicted_row(work, name, fitted(work, visits)), std::move(visits)};
}

/// The sd of each [SI] that the criteria are relative to.
std::vector<double> reference_of(const Plan& plan, const std::vector<std::string>& names,
                                 const std::optional<Estimate>& own, const std::optional<Estimate>& other) {
  const std::vector<double> none(names.size(), INFINITY);
  auto reference = own ? sds_of(*own, names) : none;
  const auto second = other ? sds_of(*other, names) : none;
  const auto widths = own || other ? limit_widths(plan, own ? *own : *other, names) : std::vector<double>(names.size());
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (!(std::isfinite(reference[k]) && reference[k] > 0.0)) reference[k] = second[k];
    if (widths[k] > 0.0) reference[k] = widths[k];
    if (!(std::isfinite(reference[k]) && reference[k] > 0.0)) reference[k] = 1.0;
  }
  return reference;
}

/// The sd [SI] that a parameter may have: that of the plan as it is, for those with a limit; where none has one, for
/// all. A plan that does not show all parameters is a measure for those with limits only.
std::vector<double> most_allowed(const Work& work, const ScheduleRow& own) {
  std::vector<double> most(work.names.size(), INFINITY);
  if (!own.estimate) return most;
  const auto sds = sds_of(with_prior_if_any(*own.estimate), work.names);
  std::vector<bool> limited;
  for (const auto& name : work.names)
    limited.push_back(std::ranges::find(work.plan.limits, name, &LimitEntry::parameter) != work.plan.limits.end());
  const bool any = std::ranges::find(limited, true) != limited.end();
  const bool shows_all = std::ranges::none_of(sds, [](double sd) { return std::isinf(sd); });
  for (std::size_t k = 0; k < most.size(); ++k)
    if (any ? limited[k] : shows_all) most[k] = sds[k];
  return most;
}

/// The D-optimal and the A-optimal schedule by the information of the terms.
std::pair<Exchanged, Exchanged> exchanged(const Work& work, const std::vector<StandardSet>& standard,
                                          const ScheduleRow& as_it_is) {
  const double dwell =
      std::max(10.0 / work.plan.sample_rate, 0.25 * work.time / static_cast<double>(work.terms.size()));
  const auto space = design_space(work.plan, work.all, outputs_of(work), work.time, dwell);
  auto problem = design_problem(work, space);
  weigh_for_d(space, problem);
  auto d = exchanged_by(work, "D-optimal", problem, standard);
  weigh_for_a(work, space, reference_of(work.plan, work.terms, by_terms(work, as_it_is), by_terms(work, d.row)),
              problem);
  auto a = exchanged_by(work, "A-optimal", problem, standard);
  return {std::move(d), std::move(a)};
}

/// The better of what was found and all others.
ScheduleRow better(ScheduleRow found, const std::vector<ScheduleRow>& others, const Goal& goal) {
  for (const auto& one : others)
    if (standing_of(one, goal) < standing_of(found, goal)) {
      found.schedule = one.schedule;
      found.estimate = one.estimate;
      found.refused = one.refused;
    }
  return found;
}

/// Searches on from what was found by what is predicted, which the exchange only approximates: it counts slow noise as
/// drawn anew at every visit, and knows the terms of the model but not the parameters of a method.
ScheduleRow improved(const Work& work, const Exchanged& found, const ScheduleRow& own, const Goal& goal, int steps) {
  const double size = static_cast<double>(work.plan.schedule.size() * work.names.size());
  const int affordable = is_quick(work) ? std::max(few_steps, static_cast<int>(work_of_search / size)) : few_steps;
  Improving search{work.plan, goal, work.all.size(), std::min(steps, affordable), {}, {}};
  const std::string& name = found.row.name;
  search.row = [&](Schedule schedule) { return predicted_row(work, name, std::move(schedule)); };
  search.fitted = [&](Visits changed) -> std::optional<Schedule> {
    auto schedule = fitted(work, std::move(changed));
    if (too_long(work, schedule)) return std::nullopt;
    return schedule;
  };
  const RandomStream random(seed);
  std::vector<ScheduleRow> others;
  if (own.estimate) others.push_back(with_better_times(search, own, random.split("times")));
  if (!found.visits.empty())
    others.push_back(with_better_visits(search, found.row, found.visits, random.split("visits")));
  return better(found.row, others, goal);
}

/// The answer: what was found where it is allowed and better, else the plan as it is.
Optimised told(const Work& work, ScheduleRow chosen, const std::vector<ScheduleRow>& rows, const ScheduleRow& own,
               const Goal& goal) {
  const Plan& plan = work.plan;
  const auto standing = standing_of(chosen, goal), before = standing_of(own, goal);
  const bool kept = own.estimate && (!is_allowed(standing) || standing.value > worth_it * before.value);
  if (kept) chosen.schedule = own.schedule, chosen.estimate = own.estimate;
  if (!chosen.estimate)
    throw Error(Error::Kind::bad_input, say("{}: no schedule was found in {}: {}", Name{plan.file},
                                            Name{say_seconds(work.time)}, chosen.refused));
  Optimised out{described(plan, chosen, rows, work.names, goal.reference), chosen.schedule};
  if (kept) out.estimate.findings.push_back({Finding::Severity::info, "no_better_schedule", {}});
  return out;
}

}  // namespace

Optimised optimise(const Plan& given, const OptimiseOptions& options, const Progress& progress) {
  refuse_impossible(given, options);
  Plan plan = given;
  read_prior(plan);
  report(progress, 0.0, "searching the motions of the rig");
  Work work = prepare(plan, options);
  const auto as_it_is = predicted_row(work, "plan as it is", plan.schedule);
  const auto own = predicted_row(work, "plan in this time", own_in_time(work));
  name_parameters(work, as_it_is);
  report(progress, 0.2, "usual schedules");
  const auto standard = standard_sets(work.all);
  const auto usual = is_quick(work) ? usual_rows(work, standard) : std::vector<ScheduleRow>();
  report(progress, 0.3, "D-optimal and A-optimal exchange");
  auto [d, a] = exchanged(work, standard, as_it_is);

  report(progress, 0.5, "searching on by what is predicted");
  const Goal goal{work.names, reference_of(plan, work.names, as_it_is.estimate, d.row.estimate),
                  most_allowed(work, own), options.criterion};
  const bool wants_d = options.criterion == DesignCriterion::D;
  auto& wanted = wants_d ? d : a;
  // Each search may have stopped at what is best nearby only: another schedule may be better.
  auto others = usual;
  others.push_back((wants_d ? a : d).row);
  others.push_back(own);
  wanted.row = better(improved(work, wanted, own, goal, options.steps), others, goal);

  std::vector<ScheduleRow> rows{as_it_is};
  if (total_of(own.schedule) != total_of(as_it_is.schedule)) rows.push_back(own);
  rows.insert(rows.end(), usual.begin(), usual.end());
  rows.push_back(d.row);
  rows.push_back(a.row);
  auto out = told(work, wanted.row, rows, own, goal);
  report(progress, 1.0, "done");
  return out;
}

std::string plan_with_schedule(const Plan& plan, const Schedule& schedule) {
  return plan_file::with_schedule(read_text_file(plan.file), plan.file,
                                  plan_file::schedule_text(schedule, find_rig(plan.rig_kind).axes()));
}

}  // namespace tumble
