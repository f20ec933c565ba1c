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
#include "tumble/tasks/optimisation/order.hpp"
#include "tumble/tasks/optimisation/points.hpp"
#include "tumble/tasks/optimisation/report.hpp"
#include "tumble/tasks/optimisation/standard.hpp"
#include "tumble/tasks/plan_file/write_schedule.hpp"
#include "tumble/tasks/prior.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using namespace prediction;
using namespace optimisation;

using Visits = std::vector<CandidateVisit>;

constexpr std::uint64_t seed = 20150917;
constexpr int starts = 4;                ///< besides the usual schedules
constexpr double quanta = 100.0;         ///< in the time of a power-up
constexpr std::size_t first_look = 120;  ///< candidates, evenly taken, that say which terms can be shown at all
constexpr double shortest_dwell = 1.0;   ///< [s]

/// A plan being optimised.
struct Work {
  Plan plan;
  bool from_terms = false;         ///< predicted from the table of terms, not by the plan's method
  bool instead_of_method = false;  ///< although the method could
  std::vector<std::string> only;   ///< terms asked for
  std::vector<int> runs;           ///< power-ups, each of which carries the same schedule out
  double time = 0.0;               ///< [s] of one power-up
  bool closing = false;            ///< the first position is repeated at the end
  double settling = 0.0;
  std::vector<Candidate> all;
  std::vector<std::string> terms;  ///< that can be told
};

Plan with(const Plan& plan, Schedule schedule) {
  Plan out = plan;
  out.schedule = std::move(schedule);
  return out;
}

Estimate evaluate(const Work& work, const Plan& plan) {
  if (!work.from_terms) return predict(plan);
  return predict_model(plan, work.only, false);
}

/// The schedule in every power-up.
Schedule in_all_runs(const Schedule& one, const std::vector<int>& runs) {
  Schedule out;
  for (const int run : runs)
    for (auto segment : one) {
      segment.run = run;
      out.push_back(std::move(segment));
    }
  return out;
}

double total_of(const Schedule& schedule) {
  double sum = 0.0;
  for (const auto& segment : schedule) sum += segment.duration;
  return sum;
}

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

/// Candidates spread over all there are, one schedule: what this does not show nothing shows.
Estimate everything(const Work& work) {
  Visits visits;
  const std::size_t stride = std::max<std::size_t>(1, work.all.size() / first_look);
  for (std::size_t j = 0; j < work.all.size(); ++j)
    if (j % stride == 0 || work.all[j].felt.size() > 1) visits.push_back({j, std::max(100.0, work.all[j].least)});
  return evaluate(work, with(work.plan, schedule_of(work.plan, work.all, visits, work.settling)));
}

/// The terms that can be told; `others` becomes whether there are parameters that are no terms.
std::vector<std::string> terms_told(const Work& work, bool& others) {
  std::vector<std::string> out;
  const auto estimate = everything(work);
  for (const auto& output : find_model(work.plan.instrument_model).outputs(work.plan.truth))
    for (const auto& term : output.terms)
      if (find_parameter(estimate, term.name)) out.push_back(term.name);
  others = out.size() < estimate.parameters.size();
  return out;
}

Work prepare(const Plan& plan, const OptimiseOptions& options) {
  Work work;
  work.plan = plan;
  const auto* method = plan.method.empty() ? nullptr : &find_method(plan.method);
  work.from_terms = !method || !method->predict || !options.terms.empty();
  work.only = options.terms;
  for (const auto& segment : plan.schedule)
    if (std::ranges::find(work.runs, segment.run) == work.runs.end()) work.runs.push_back(segment.run);
  work.time = options.total_time.value_or(total_of(plan.schedule)) / static_cast<double>(work.runs.size());
  work.closing = plan.schedule.size() > 2 && same_motions(plan.schedule.front(), plan.schedule.back());
  if (plan.settings.texts().contains("settling")) work.settling = plan.settings.number("settling");
  work.all = candidates(plan, range_of(plan, options.step));
  std::erase_if(work.all, [&](const Candidate& one) {
    return one.setup + work.settling + std::max(one.least, shortest_dwell) > 0.5 * work.time;
  });
  if (work.all.empty())
    throw Error(Error::Kind::bad_input, say("{}: {} is too short for any two motions of the rig {} with its settling",
                                            Name{plan.file}, Name{say_seconds(work.time)}, Name{plan.rig_kind}));
  bool others = false;
  work.terms = terms_told(work, others);
  if (others && !work.from_terms) {  // the method's parameters are not the terms of which the information is known
    work.from_terms = work.instead_of_method = true;
    work.terms = terms_told(work, others);
  }
  work.only = work.terms;
  return work;
}

/// Visits as a schedule of exactly the time there is: what moves leave is shared out in proportion to the dwells.
Schedule fitted(const Work& work, Visits visits) {
  if (work.closing && visits.size() > 1) {
    visits.front().dwell *= 0.5;
    visits.push_back(visits.front());
  }
  const double interval = 1.0 / work.plan.sample_rate;
  Schedule schedule;
  for (int pass = 0; pass < 4; ++pass) {
    schedule = schedule_of(work.plan, work.all, visits, work.settling);
    const double dwell = std::accumulate(visits.begin(), visits.end(), 0.0,
                                         [](double sum, const auto& visit) { return sum + visit.dwell; });
    const double wanted = dwell + work.time - total_of(schedule);
    if (std::abs(wanted - dwell) < 0.5 * interval) break;
    for (auto& visit : visits)
      visit.dwell =
          std::max({visit.dwell * std::max(wanted, 0.0) / dwell, shortest_dwell, work.all[visit.candidate].least});
  }
  // What rounding to samples left goes to, or comes from, the longest.
  const double over = std::round((total_of(schedule) - work.time) / interval) * interval;
  auto longest = std::ranges::max_element(schedule, {}, &Segment::duration);
  if (longest != schedule.end() && longest->duration > 2.0 * over) longest->duration -= over;
  return in_all_runs(schedule, work.runs);
}

/// Half a sample for each segment may be over.
bool too_long(const Work& work, const Schedule& schedule) {
  const double each = total_of(schedule) / static_cast<double>(work.runs.size());
  return each > work.time * (1.0 + 1e-9) + static_cast<double>(schedule.size()) / work.plan.sample_rate;
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
  auto outputs =
      output_problems(with(work.plan, schedule_of(work.plan, work.all, Visits(1), 0.0)), felt_of(work.all), work.terms);
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

Schedule searched(const Work& work, const DesignProblem& problem, const std::vector<StandardSet>& standard) {
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
  return fitted(work, ordered(work.plan, work.all, std::move(visits), drifts(work.plan), seed));
}

/// A schedule with its prediction; what a method refuses is told instead.
ScheduleRow row(const Work& work, const std::string& name, Schedule schedule) {
  ScheduleRow out{name, std::move(schedule), {}, {}};
  try {
    out.estimate = evaluate(work, with(work.plan, out.schedule));
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_data && error.kind != Error::Kind::bad_input) throw;
    out.refused = error.problems.empty() ? reason_of(error) : sentence_of(error.problems.front());
  }
  return out;
}

std::vector<double> reference_of(const Work& work, const ScheduleRow& plan, const ScheduleRow& best) {
  auto own = plan.estimate ? sds_of(*plan.estimate, work.terms) : std::vector<double>(work.terms.size(), INFINITY);
  const auto other = best.estimate ? sds_of(*best.estimate, work.terms) : own;
  const auto widths =
      best.estimate ? limit_widths(work.plan, *best.estimate, work.terms) : std::vector<double>(own.size());
  for (std::size_t k = 0; k < own.size(); ++k) {
    if (std::isinf(own[k])) own[k] = other[k];
    if (widths[k] > 0.0) own[k] = widths[k];
  }
  return own;
}

/// The usual schedules that fit into the time.
std::vector<ScheduleRow> usual_rows(const Work& work, const std::vector<StandardSet>& standard) {
  std::vector<ScheduleRow> rows;
  for (const auto& set : standard) {
    Visits visits;
    for (const auto j : set.candidates) visits.push_back({j, work.time / static_cast<double>(set.candidates.size())});
    auto schedule = fitted(work, std::move(visits));
    if (!too_long(work, schedule)) rows.push_back(row(work, set.name, std::move(schedule)));
  }
  return rows;
}

/// What was found, or the best of the others where that is better still: the search counts slow noise as drawn anew at
/// every visit, the prediction as it is.
ScheduleRow better(ScheduleRow found, const std::vector<ScheduleRow>& others, const Work& work,
                   const std::vector<double>& reference, double Criteria::*criterion) {
  const auto value = [&](const ScheduleRow& one) {
    return one.estimate ? criteria_of(with_prior_if_any(*one.estimate), work.terms, reference).*criterion
                        : std::numeric_limits<double>::infinity();
  };
  for (const auto& one : others)
    if (value(one) < value(found)) {
      found.schedule = one.schedule;
      found.estimate = one.estimate;
    }
  return found;
}

/// The answer, and where the method's own prediction was not used.
Optimised told(const Work& work, const ScheduleRow& chosen, const std::vector<ScheduleRow>& rows,
               const std::vector<double>& reference) {
  const Plan& plan = work.plan;
  if (!chosen.estimate)
    throw Error(Error::Kind::bad_input, say("{}: no schedule was found in {}: {}", Name{plan.file},
                                            Name{say_seconds(work.time)}, chosen.refused));
  Optimised out{described(plan, chosen, rows, work.terms, reference), chosen.schedule};
  if (work.instead_of_method)
    out.estimate.findings.push_back({Finding::Severity::warning,
                                     "terms_instead_of_parameters",
                                     {{"method", plan.method},
                                      {"model", plan.instrument_model},
                                      {"terms", fmt::format("{}", fmt::join(work.terms, ", "))}}});
  return out;
}

}  // namespace

Optimised optimise(const Plan& given, const OptimiseOptions& options, const Progress& progress) {
  refuse_impossible(given, options);
  Plan plan = given;
  read_prior(plan);
  report(progress, 0.0, "searching the motions of the rig");
  const Work work = prepare(plan, options);
  const double dwell = std::max(10.0 / plan.sample_rate, 0.25 * work.time / static_cast<double>(work.terms.size()));
  const auto space = design_space(plan, work.all, outputs_of(work), work.time, dwell);
  const auto standard = standard_sets(work.all);
  auto problem = design_problem(work, space);

  report(progress, 0.3, "usual schedules");
  const auto own = row(work, "plan as it is", plan.schedule);
  const auto usual = usual_rows(work, standard);

  report(progress, 0.4, "D-optimal exchange");
  weigh_for_d(space, problem);
  auto d = row(work, "D-optimal", searched(work, problem, standard));
  const auto reference = reference_of(work, own, d);

  report(progress, 0.6, "A-optimal exchange");
  weigh_for_a(work, space, reference, problem);
  auto a = row(work, "A-optimal", searched(work, problem, standard));

  // Each search may have stopped at what is best nearby only: the other's schedule or a usual one may be better.
  auto others = usual;
  others.push_back(a);
  others.push_back(d);
  d = better(std::move(d), others, work, reference, &Criteria::determinant);
  a = better(std::move(a), others, work, reference, &Criteria::trace);

  std::vector<ScheduleRow> rows{own};
  rows.insert(rows.end(), usual.begin(), usual.end());
  rows.push_back(d);
  rows.push_back(a);
  auto out = told(work, options.criterion == DesignCriterion::D ? d : a, rows, reference);
  report(progress, 1.0, "done");
  return out;
}

std::string plan_with_schedule(const Plan& plan, const Schedule& schedule) {
  return plan_file::with_schedule(read_text_file(plan.file), plan.file,
                                  plan_file::schedule_text(schedule, find_rig(plan.rig_kind).axes()));
}

}  // namespace tumble
