#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/parallel.hpp"
#include "tumble/math/random.hpp"
#include "tumble/math/regression/optimal_design.hpp"
#include "tumble/math/regression/optimal_design/worth.hpp"
#include "tumble/math/rounding_share.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using optimal_design::State;
using optimal_design::Visit;
using optimal_design::Visits;
using optimal_design::Worth;

constexpr double worth_it = 1e-7;  ///< smallest relative (A) or absolute (D) gain that counts
constexpr double rounding = 1e-10;
constexpr int most_passes = 60;

class Search {
 public:
  explicit Search(const DesignProblem& problem) : problem_(problem), quantum_(problem.quantum), worth_(problem) {}

  Visits greedy(const RandomStream& random, int start) const;
  Visits quantised(const Design& design) const;
  void improve(Visits& visits) const;
  double value(const Visits& visits) const { return worth_.value(visits); }
  bool possible() const {
    for (std::size_t j = 0; j < problem_.points.size(); ++j)
      if (affordable(problem_.effort, j) > 0) return true;
    return false;
  }

 private:
  bool better(double now, double before) const {
    const double least = problem_.criterion == DesignCriterion::A ? worth_it * std::abs(before) : worth_it;
    return now < before - least;
  }
  double cost(const Visit& visit) const {
    return problem_.points[visit.point].setup + quantum_ * static_cast<double>(visit.quanta);
  }
  double left(const Visits& visits) const {
    double effort = problem_.effort;
    for (const auto& visit : visits) effort -= cost(visit);
    return effort;
  }
  long least(std::size_t point) const {
    return std::max(1L, static_cast<long>(std::ceil(problem_.points[point].least / quantum_ - rounding_share)));
  }
  /// Quanta that `effort` pays for at a point, its setup taken off; 0 where that is too little for a visit.
  long affordable(double effort, std::size_t point) const {
    const double quanta = std::floor((effort - problem_.points[point].setup) / quantum_ + rounding_share);
    return quanta >= static_cast<double>(least(point)) ? static_cast<long>(quanta) : 0L;
  }

  bool replace(Visits& visits, double& now) const;
  Visits with_more(const Visits& visits, long quanta, double& then) const;
  bool drop(Visits& visits, double& now) const;
  bool split(Visits& visits, double& now) const;
  bool balance(Visits& visits, double& now) const;
  Visit best_addition(const State& base, double effort, double& value) const;

  const DesignProblem& problem_;
  double quantum_;
  Worth worth_;
};

/// The visit that is worth most of all that cost up to `effort`; quanta 0: there is none. `value` is what it leads to.
Visit Search::best_addition(const State& base, double effort, double& value) const {
  Visit best{0, 0};
  value = std::numeric_limits<double>::infinity();
  for (std::size_t j = 0; j < problem_.points.size(); ++j) {
    const long quanta = affordable(effort, j);
    if (quanta < 1) continue;
    const double then = base.value - worth_.gain(base, worth_.root(j, quanta));
    if (then < value) value = then, best = {j, quanta};
  }
  return best;
}

/// The most telling visit for its cost, time and again. Every search sees all points (the first) or a random half of
/// them, and begins with visits of another length.
Visits Search::greedy(const RandomStream& random, int start) const {
  double setup = 0.0;
  for (const auto& point : problem_.points) setup += point.setup / static_cast<double>(problem_.points.size());
  const double interest = static_cast<double>(worth_.interest());
  const double wanted = interest * (1.0 + start % 4);
  const long quanta = std::max(1L, std::lround((problem_.effort / wanted - setup) / quantum_));
  Visits visits;
  for (;;) {
    const State base = worth_.state(visits);
    const double effort = left(visits);
    double most = 0.0;
    Visit best{0, 0};
    for (std::size_t j = 0; j < problem_.points.size(); ++j) {
      if (start > 0 && random.uniform(j) < 0.5) continue;
      const Visit visit{j, std::min(std::max(quanta, least(j)), affordable(effort, j))};
      if (visit.quanta < 1) continue;
      const double worth = worth_.gain(base, worth_.root(j, visit.quanta)) / cost(visit);
      if (worth > most) most = worth, best = visit;
    }
    if (best.quanta < 1) return visits;
    visits.push_back(best);
  }
}

/// The visits of a design as far as the effort goes.
Visits Search::quantised(const Design& design) const {
  Visits visits;
  for (const auto& visit : design) {
    const long wanted =
        std::max(least(visit.point), static_cast<long>(std::floor(visit.effort / quantum_ + rounding_share)));
    const long quanta = std::min(wanted, affordable(left(visits), visit.point));
    if (quanta > 0) visits.push_back({visit.point, quanta});
  }
  return visits;
}

/// Each visit for the best other one of the same cost.
bool Search::replace(Visits& visits, double& now) const {
  bool changed = false;
  for (std::size_t v = 0; v < visits.size(); ++v) {
    const double effort = left(visits) + cost(visits[v]);
    Visits others = visits;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(v));
    double then = 0.0;
    const Visit best = best_addition(worth_.state(others), effort, then);
    if (best.quanta < 1 || !better(then, now)) continue;
    visits[v] = best;
    now = value(visits);
    changed = true;
  }
  return changed;
}

/// The design with `quanta` more at the visit where they help most; the most promising few are tried.
Visits Search::with_more(const Visits& visits, long quanta, double& then) const {
  const State base = worth_.state(visits);
  std::vector<std::pair<double, std::size_t>> promise;
  for (std::size_t u = 0; u < visits.size(); ++u)
    promise.emplace_back(-worth_.gain(base, worth_.root(visits[u].point, quanta)), u);
  std::ranges::sort(promise);
  Visits best;
  then = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < std::min<std::size_t>(3, promise.size()); ++k) {
    Visits trial = visits;
    trial[promise[k].second].quanta += quanta;
    if (const double now = value(trial); now < then) then = now, best = std::move(trial);
  }
  return best;
}

/// A visit given up for the sake of another.
bool Search::drop(Visits& visits, double& now) const {
  bool changed = false;
  for (std::size_t v = 0; v < visits.size() && visits.size() > 1;) {
    Visits others = visits;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(v));
    double then = 0.0;
    Visits best = with_more(others, static_cast<long>(std::floor(left(others) / quantum_ + rounding_share)), then);
    if (!(then < now + rounding * std::abs(now))) {  // as good with a visit less is better
      ++v;
      continue;
    }
    visits = std::move(best);
    now = then;
    changed = true;
  }
  return changed;
}

/// A part of a visit's effort for a new visit elsewhere: half of it, or as little as there can be.
bool Search::split(Visits& visits, double& now) const {
  bool changed = false;
  for (std::size_t v = 0; v < visits.size(); ++v)
    for (const bool half : {true, false}) {
      const long had = visits[v].quanta;
      double setup = 0.0;
      for (const auto& point : problem_.points) setup = std::max(setup, point.setup);
      const long part = half ? had / 2 : static_cast<long>(std::ceil(setup / quantum_)) + 1;
      if (part < 1 || had - part < least(visits[v].point)) continue;
      Visits others = visits;
      others[v].quanta -= part;
      double then = 0.0;
      const Visit best = best_addition(worth_.state(others), left(others), then);
      if (best.quanta < 1 || !better(then, now)) continue;
      visits = std::move(others);
      visits.push_back(best);
      now = value(visits);
      changed = true;
    }
  return changed;
}

/// Effort from where it is missed least to where it helps most; and what is left over.
bool Search::balance(Visits& visits, double& now) const {
  bool changed = false;
  if (const long spare = static_cast<long>(std::floor(left(visits) / quantum_ + rounding_share)); spare > 0) {
    visits = with_more(visits, spare, now);
    changed = true;
  }
  long largest = 1;
  for (const auto& visit : visits) largest = std::max(largest, visit.quanta);
  for (long quanta = largest / 2; quanta >= 1;) {
    std::size_t giver = visits.size();
    double lowest = std::numeric_limits<double>::infinity();
    for (std::size_t v = 0; v < visits.size(); ++v) {
      if (visits[v].quanta - quanta < least(visits[v].point)) continue;
      Visits trial = visits;
      trial[v].quanta -= quanta;
      const double then = value(trial);
      if (then < lowest) lowest = then, giver = v;
    }
    Visits best;
    double then = now;
    if (giver < visits.size()) {
      Visits trial = visits;
      trial[giver].quanta -= quanta;
      best = with_more(trial, quanta, then);
    }
    if (best.empty() || !better(then, now)) {
      quanta /= 2;
      continue;
    }
    visits = std::move(best);
    now = then;
    changed = true;
  }
  return changed;
}

void Search::improve(Visits& visits) const {
  double now = value(visits);
  for (int pass = 0; pass < most_passes; ++pass) {
    bool changed = replace(visits, now);
    changed = balance(visits, now) || changed;
    changed = drop(visits, now) || changed;
    changed = split(visits, now) || changed;
    if (!changed) return;
  }
}

void refuse_misfits(const DesignProblem& problem) {
  Problems problems;
  const auto p = problem.parameters;
  if (p == 0 || problem.weights.size() != p)
    problems.push_back(say("a design needs a weight for each of its {} parameters", p));
  else if (std::ranges::none_of(problem.weights, [](double w) { return w > 0.0; }))
    problems.push_back("a design needs a parameter of interest: one weight above zero");
  if (!(problem.quantum > 0.0)) problems.push_back("the quantum of a design must be above zero");
  if (!problem.prior.empty() && (problem.prior.rows != p || problem.prior.columns != p))
    problems.push_back(say("the prior of a design must be {0} x {0}", p));
  for (std::size_t j = 0; j < problem.points.size(); ++j) {
    const auto& point = problem.points[j];
    if (point.rows.columns != p)
      problems.push_back(say("design point {} has {} columns, not {}", j, point.rows.columns, p));
    if (!point.disturbance.empty() && point.disturbance.rows != point.rows.rows)
      problems.push_back(say("design point {}: rows and disturbance differ in length", j));
    if (!(point.setup >= 0.0 && point.least >= 0.0))
      problems.push_back(say("design point {}: setup and least effort must not be negative", j));
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

}  // namespace

Design exchange(const DesignProblem& problem, std::uint64_t seed, int starts, const std::vector<Design>& from) {
  refuse_misfits(problem);
  const Search search(problem);
  if (!search.possible()) return {};
  const RandomStream random(seed);
  const auto drawn = static_cast<std::size_t>(std::max(1, starts));
  std::vector<Visits> found(drawn + from.size());
  parallel_for(found.size(), [&](std::size_t s) {
    found[s] = s < drawn ? search.greedy(random.split(s), static_cast<int>(s)) : search.quantised(from[s - drawn]);
    search.improve(found[s]);
  });
  std::size_t best = 0;
  std::vector<double> values;
  for (const auto& visits : found) values.push_back(search.value(visits));
  for (std::size_t s = 1; s < values.size(); ++s)
    if (!found[s].empty() && values[s] < values[best]) best = s;
  std::ranges::stable_sort(found[best], {}, &Visit::point);
  Design design;
  for (const auto& visit : found[best])
    design.push_back({visit.point, problem.quantum * static_cast<double>(visit.quanta)});
  return design;
}

}  // namespace tumble
