#include "tumble/math/population/drift.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/bisection.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/square.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr double largest_step_sd = 3.0;  ///< [sd] of both visits, by which a walk may have gone farther than they show

void require_visits(const UnitHistory& history) {
  Problems problems;
  double last = 0.0;
  for (const auto& visit : history.visits) {
    if (!std::isfinite(visit.value) || !(visit.sd > 0.0) || !std::isfinite(visit.sd))
      problems.push_back(say("the visit at {:g} s has no value, or no uncertainty above zero", visit.time));
    if (!(visit.time >= last)) problems.push_back(say("the visit at {:g} s is not in order of time", visit.time));
    last = visit.time;
  }
  if (history.visits.empty()) problems.push_back("a history without a visit");
  if (history.shared.columns > 0 && history.shared.rows != history.visits.size())
    problems.push_back("the shared errors of a history have another number of rows than it has visits");
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

/// A history solved for offset and trend at one random walk.
struct Solved {
  Cholesky factor;                   ///< of V
  Matrix design;                     ///< columns 1 and t
  Matrix covariance;                 ///< of a and b
  std::vector<double> coefficients;  ///< a and b
  std::vector<double> whitened;      ///< V^-1 of the residuals
  double log_likelihood = 0.0;       ///< restricted, without constants
};

Solved solved(const UnitHistory& history, double walk) {
  const auto& visits = history.visits;
  const auto n = visits.size();
  Matrix v(n, n);
  std::vector<double> y;
  Solved out;
  out.design = Matrix(n, 2);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      v(i, j) = square(walk) * std::min(visits[i].time, visits[j].time);
      for (std::size_t k = 0; k < history.shared.columns; ++k) v(i, j) += history.shared(i, k) * history.shared(j, k);
    }
    v(i, i) += square(visits[i].sd);
    out.design(i, 0) = 1.0;
    out.design(i, 1) = visits[i].time;
    y.push_back(visits[i].value - history.rate * visits[i].time);
  }
  out.factor = cholesky(v);
  const Matrix weighted = solve(out.factor, out.design);
  Matrix information = transposed(out.design) * weighted;
  const bool known = history.rate_sd == 0.0;  // the trend is that of the model
  if (known) information(0, 1) = information(1, 0) = 0.0, information(1, 1) = 1.0;
  if (!known && std::isfinite(history.rate_sd)) information(1, 1) += 1.0 / square(history.rate_sd);
  out.covariance = inverse_symmetric(information);
  std::vector<double> right{dot(column(weighted, 0), y), known ? 0.0 : dot(column(weighted, 1), y)};
  out.coefficients = out.covariance * right;
  if (known) out.covariance(1, 1) = 0.0;
  auto residual = y;
  for (std::size_t i = 0; i < n; ++i) residual[i] -= out.coefficients[0] + out.coefficients[1] * visits[i].time;
  out.whitened = solve(out.factor, residual);
  const double of_trend =
      known || !std::isfinite(history.rate_sd) ? 0.0 : square(out.coefficients[1] / history.rate_sd);
  out.log_likelihood =
      -0.5 * (out.factor.log_determinant + std::log(determinant(information)) + dot(residual, out.whitened) + of_trend);
  out.coefficients[1] += history.rate;
  return out;
}

/// A random walk that is larger than any the visits allow [u/sqrt(s)].
double largest_walk(std::span<const UnitHistory> histories) {
  double most = 0.0;
  for (const auto& history : histories)
    for (std::size_t i = 1; i < history.visits.size(); ++i) {
      const auto &a = history.visits[i - 1], &b = history.visits[i];
      if (b.time > a.time)
        most = std::max(most,
                        (std::abs(b.value - a.value) + largest_step_sd * (a.sd + b.sd)) / std::sqrt(b.time - a.time));
    }
  return 3.0 * most;
}

double outside(const Forecast& at, double lower, double upper) {
  const double sd = std::sqrt(std::max(at.variance, 1e-300));
  return normal_below((lower - at.value) / sd) + normal_above((upper - at.value) / sd);
}

/// First time after the last visit at which `probability` exceeds the risk, at most `longest`.
template <class Probability>
double first_time(const Probability& probability, double begin, double risk, double longest) {
  if (probability(begin) > risk) return 0.0;
  constexpr int cells = 200;
  double low = 0.0;
  for (int i = 1; i <= cells; ++i) {
    const double high = longest * i / cells;
    if (probability(begin + high) <= risk) {
      low = high;
      continue;
    }
    constexpr int halvings = 40;  // to 1e-12 of a cell
    return bisected(low, high, halvings, [&](double time) { return !(probability(begin + time) > risk); }).low;
  }
  return longest;
}

double quantile_of(const WalkDensity& walks, double probability) {
  double sum = 0.0;
  for (std::size_t i = 0; i < walks.walk.size(); ++i)
    if ((sum += walks.weight[i]) >= probability) return walks.walk[i];
  return walks.walk.back();
}

}  // namespace

WalkDensity walk_of_units(std::span<const UnitHistory> histories) {
  for (const auto& history : histories) require_visits(history);
  const double largest = largest_walk(histories);
  if (!(largest > 0.0))
    throw Error(Error::Kind::bad_data, "no unit has two visits at different times: nothing is seen of its drift");
  constexpr int nodes = 400;
  WalkDensity out;
  std::vector<double> logs;
  for (int i = 0; i < nodes; ++i) {
    out.walk.push_back(largest * square((i + 0.5) / nodes));  // dense near zero
    double sum = std::log((i + 0.5) / nodes);                 // the prior is flat in q
    for (const auto& history : histories)
      if (history.visits.size() > 1) sum += solved(history, out.walk.back()).log_likelihood;
    logs.push_back(sum);
  }
  const double most = std::ranges::max(logs);
  double total = 0.0;
  for (const double one : logs) total += out.weight.emplace_back(std::exp(one - most));
  for (auto& weight : out.weight) weight /= total;
  return out;
}

Forecast forecast(const UnitHistory& history, double walk, double time) {
  require_visits(history);
  const auto fit = solved(history, walk);
  const auto n = history.visits.size();
  std::vector<double> shared;
  for (const auto& visit : history.visits) shared.push_back(square(walk) * std::min(visit.time, time));
  const auto weights = solve(fit.factor, shared);
  std::vector<double> design{1.0, time};
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < 2; ++k) design[k] -= weights[i] * fit.design(i, k);
  return {fit.coefficients[0] + fit.coefficients[1] * time + dot(shared, fit.whitened),
          square(walk) * time - dot(shared, weights) + quadratic_form(design, fit.covariance)};
}

DriftRate drift_rate(const UnitHistory& history, double walk) {
  require_visits(history);
  const auto fit = solved(history, walk);
  return {fit.coefficients[1], std::sqrt(std::max(0.0, fit.covariance(1, 1)))};
}

RecalibrationInterval recalibration_interval(const UnitHistory& history, const WalkDensity& walks, double lower,
                                             double upper, double risk, double longest) {
  require_visits(history);
  const double begin = history.visits.back().time;
  const double least_weight = 1e-6 * std::ranges::max(walks.weight);
  const auto averaged = [&](double time) {
    double sum = 0.0;
    for (std::size_t i = 0; i < walks.walk.size(); ++i)
      if (walks.weight[i] > least_weight)
        sum += walks.weight[i] * outside(forecast(history, walks.walk[i], time), lower, upper);
    return sum;
  };
  const auto at = [&](double probability) {
    const double walk = quantile_of(walks, probability);
    const auto alone = [&](double time) { return outside(forecast(history, walk, time), lower, upper); };
    return first_time(alone, begin, risk, longest);
  };
  return {first_time(averaged, begin, risk, longest), at(0.95), at(0.05)};
}

}  // namespace tumble
