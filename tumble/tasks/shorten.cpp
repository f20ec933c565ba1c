#include "tumble/tasks/shorten.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tumble/core/columns.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/reduce/with_prior.hpp"
#include "tumble/tasks/optimisation/criteria.hpp"
#include "tumble/tasks/prior.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using optimisation::sds_of;

constexpr double accepted = 1.002;       ///< of an uncertainty that is to be reached
constexpr double alien_floor = 1.19;     ///< u/tau at which a unit 6 tau away is seen at 1 % in 9 of 10
constexpr double shortest_share = 0.05;  ///< of the time of the plan
constexpr int halvings = 5;              ///< to 3 % of the time
constexpr int steps_of_one_time = 30;    ///< of the search by predictions: there are a dozen searches

/// What the shorter test must reach.
struct Goal {
  std::vector<std::string> terms;
  std::vector<double> sds;     ///< [SI] of the plan as it is, without prior
  std::vector<double> widest;  ///< [SI] that the result without prior may have
};

double time_of(const Schedule& schedule) {
  double sum = 0.0;
  for (const auto& segment : schedule) sum += segment.duration;
  return sum;
}

/// The plan's own schedule in less time.
Schedule scaled(const Plan& plan, double share) {
  Schedule schedule = plan.schedule;
  for (auto& segment : schedule)
    segment.duration = std::max(1.0, std::round(segment.duration * share * plan.sample_rate)) / plan.sample_rate;
  return schedule;
}

/// The largest sd over what is to be reached [1], or infinite where the result without prior would show too little.
double excess_of(const Estimate& estimate, const Goal& goal) {
  const auto with = sds_of(optimisation::with_prior_if_any(estimate), goal.terms), own = sds_of(estimate, goal.terms);
  double worst = 0.0;
  for (std::size_t k = 0; k < goal.terms.size(); ++k) {
    if (own[k] > accepted * goal.widest[k]) return INFINITY;
    worst = std::max(worst, with[k] / goal.sds[k]);
  }
  return worst;
}

/// The better of what is found for a time.
struct Found {
  Optimised best;
  double excess = INFINITY, time = 0.0;
};

class Search {
 public:
  Search(Plan plan, const OptimiseOptions& options, Goal goal)
      : plan_(std::move(plan)), options_(options), goal_(std::move(goal)) {
    by_terms_ = !options_.terms.empty();
    const auto own = plan_.method.empty() ? Estimate() : tumble::predict(without_prior(plan_));
    for (const auto& term : goal_.terms) by_terms_ = by_terms_ || !find_parameter(own, term);
  }

  static Plan without_prior(Plan plan) {
    plan.prior = {};
    return plan;
  }

  Found at(double time) const {
    Found found;
    consider(found, [&] {
      auto options = options_;
      options.total_time = time;
      options.steps = steps_of_one_time;
      return optimise(plan_, options, {});
    });
    consider(found, [&] { return predicted(scaled(plan_, time / time_of(plan_.schedule))); });
    return found;
  }

  /// A schedule as it is.
  Found with(const Schedule& schedule) const {
    Found found;
    consider(found, [&] { return predicted(schedule); });
    found.time = time_of(schedule);
    return found;
  }

  /// The shortest time that reaches the goal, by halving; the schedule to begin with where nothing shorter does.
  Found shortest(const Schedule& from, const std::function<void()>& step) const {
    Found best = with(from);
    const double full = best.time;
    double low = shortest_share * full, high = full;
    for (int i = 0; i < halvings; ++i) {
      const double time = 0.5 * (low + high);
      Found found = at(time);
      found.time = time_of(found.best.schedule);
      step();
      if (found.excess <= accepted)
        high = time, best = std::move(found);
      else
        low = time;
    }
    return best;
  }

 private:
  Optimised predicted(const Schedule& schedule) const {
    Plan plan = plan_;
    plan.schedule = schedule;
    return {by_terms_ ? predict_model(plan, goal_.terms, false) : tumble::predict(plan), schedule};
  }

  void consider(Found& found, const std::function<Optimised()>& work) const try {
    auto one = work();
    const double excess = excess_of(one.estimate, goal_);
    if (excess < found.excess) found = {std::move(one), excess, 0.0};
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_input && error.kind != Error::Kind::bad_data) throw;
  }

  Plan plan_;
  OptimiseOptions options_;
  Goal goal_;
  bool by_terms_ = false;  ///< the terms compared are not those of the method
};

/// From the table of the plan as it is.
Goal goal_of(const Plan& plan, const Estimate& optimised) {
  const Table* table = find_table(optimised, "schedule_sd");
  Goal goal;
  for (const auto& row : table->rows) {
    if (std::get<std::string>(row[0]) != "plan as it is") continue;
    for (std::size_t k = 1; k < row.size(); ++k) {
      const auto* sd = std::get_if<double>(&row[k]);
      if (!sd) continue;
      goal.terms.push_back(table->columns[k].name);
      goal.sds.push_back(*sd);
    }
  }
  if (goal.terms.empty())
    throw Error(Error::Kind::bad_input,
                say("{}: the schedule determines no term that a shorter one could reach", Name{plan.file}));
  const Estimate& population = *plan.prior.population;
  for (std::size_t t = 0; t < goal.terms.size(); ++t) {
    double widest = goal.sds[t];
    for (std::size_t k = 0; k < population.parameters.size(); ++k)
      if (population.parameters[k].name == goal.terms[t])
        widest = std::max(widest, alien_floor * unit_to_unit_sd(population, k));
    goal.widest.push_back(widest);
  }
  return goal;
}

Table shorter_table(double full, const Found& positions, const Found& prior) {
  struct Row {
    const char* test;
    double time, worst;
  };
  const std::vector<Row> rows{{"plan as it is", full, 1.0},
                              {"other motions", positions.time, positions.excess},
                              {"other motions and prior", prior.time, prior.excess}};
  return tabulate(
      "shorter_tests",
      "the shortest tests that reach the uncertainties of the plan as it is; worst: largest uncertainty over "
      "that of the plan",
      rows,
      {{"test", &Row::test},
       {"time", "min", &Row::time},
       {"saved", "%", [full](const Row& r) { return 1.0 - r.time / full; }},
       {"worst", &Row::worst}});
}

}  // namespace

Optimised shorten(const Plan& given, const OptimiseOptions& options, const Progress& progress) {
  Plan plan = given;
  read_prior(plan);
  if (!plan.prior.population) throw Error(Error::Kind::bad_input, say("{}: the plan has no prior", Name{plan.file}));
  int done = 0;
  const auto step = [&] {
    report(progress, static_cast<double>(++done) / (2.0 * halvings + 1.0), "searching shorter tests");
  };
  const Plan alone = Search::without_prior(plan);
  const double full = time_of(plan.schedule);
  auto few = options;
  few.steps = 0;
  const auto goal = goal_of(plan, optimise(alone, few, {}).estimate);
  step();
  auto alone_goal = goal;
  alone_goal.widest = goal.sds;
  const Found positions = Search(alone, options, alone_goal).shortest(plan.schedule, step);
  const Found prior = Search(plan, options, goal).shortest(positions.best.schedule, step);
  Optimised out = prior.best;
  out.estimate.tables.insert(out.estimate.tables.begin(), shorter_table(full, positions, prior));
  out.estimate.findings.push_back({Finding::Severity::info,
                                   "shorter_test",
                                   {{"time", prior.time, "min"},
                                    {"full", full, "min"},
                                    {"by_prior", 100.0 * (positions.time - prior.time) / full},
                                    {"by_motions", 100.0 * (full - positions.time) / full}}});
  return out;
}

}  // namespace tumble
