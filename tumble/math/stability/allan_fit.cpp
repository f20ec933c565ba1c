#include "tumble/math/stability/allan_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/square.hpp"
#include "tumble/math/stability/model_error.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using Active = std::vector<bool>;
using Terms = std::vector<std::size_t>;

constexpr double added_to_variance = 1e-10;               ///< [1] so that the covariance is positive
constexpr int most_iterations = 40, free_iterations = 8;  ///< after the free ones steps are halved: weights that swing
constexpr double last_move = 1e-6;                        ///< [1] of the curve
constexpr double least_skewness = 1e-3;                   ///< a chi-square of 8e6 degrees of freedom is normal
constexpr int iterations_of_limit = 20;
constexpr double thinned_ratio = 1.9;  ///< of two averaging times: an octave, with times that are not

struct State {
  std::vector<double> c;  ///< squared coefficients, one a term, zero where not active
  Matrix v;               ///< covariance of the observations under c, model error included
  double chi_square = 0.0;
};

/// The observations and what may explain them.
class NoiseProblem {
 public:
  NoiseProblem(const std::vector<AllanObservation>& observations, AllanCovariance covariance, std::size_t samples)
      : covariance_(std::move(covariance)) {
    for (const auto& [factor, variance, count] : observations) {
      y_.push_back(variance);
      const auto most = static_cast<double>(samples + 1 - 2 * factor);
      thinning_.push_back(count == 0 ? 1.0 : std::sqrt(std::max(1.0, most / static_cast<double>(count))));
    }
  }

  std::size_t terms() const { return design().columns; }
  const std::vector<double>& y() const { return y_; }
  const Matrix& design() const { return covariance_.design(); }
  const std::vector<std::size_t>& factors() const { return covariance_.factors(); }
  const std::vector<UnitTerm>& units() const { return covariance_.terms(); }

  /// Covariance of the observations under the model c. Gaps make the differences fewer: taken as independent of them.
  Matrix covariance(const std::vector<double>& c, double model_error) const {
    Matrix v = scaled_columns(scaled_rows(thinning_, covariance_.at(c)), thinning_);
    const auto fitted = design() * c;
    for (std::size_t i = 0; i < v.rows; ++i)
      v(i, i) = v(i, i) * (1.0 + added_to_variance) + square(model_error * fitted[i]);
    return v;
  }

  /// Before any model: every averaging time with one relative error.
  State start() const { return {std::vector<double>(terms()), diagonal(scaled(y_, y_))}; }

 private:
  AllanCovariance covariance_;
  std::vector<double> y_, thinning_;
};

Terms listed(const Active& active) {
  Terms list;
  for (std::size_t t = 0; t < active.size(); ++t)
    if (active[t]) list.push_back(t);
  return list;
}

Cholesky factor_of(const Matrix& v) {
  Cholesky factor = cholesky(v);
  if (factor.positive) return factor;
  throw Error(Error::Kind::internal, "the covariance of the Allan variances is not positive definite");
}

/// What least squares gives for some of the terms, signs free; zeros for the others.
struct Solution {
  std::vector<double> c;
  Matrix covariance;  ///< of c
  double chi_square = 0.0;
};

/// Observations and design made white and scaled once, then solved for any choice of terms.
class Whitened {
 public:
  Whitened(const Matrix& design, const std::vector<double>& y, const Matrix& v)
      : lower_(factor_of(v).lower), x_(solve_lower(lower_, design)), y_(solve_lower(lower_, y)) {
    scale_ = inverses(column_norms(x_));
    x_ = scaled_columns(std::move(x_), scale_);
    gram_ = gram(x_);
    right_ = transposed_product(x_, y_);
  }

  const Matrix& lower() const { return lower_; }

  Solution solve(const Terms& list) const {
    const Matrix inverse = inverse_of(list);
    const auto b = inverse * right_, residual = difference(y_, x_ * b);
    return {scaled(scale_, b), scaled_columns(scaled_rows(scale_, inverse), scale_), dot(residual, residual)};
  }

  /// Weights of the observations in each coefficient: c = weights' y.
  Matrix weights(const Terms& list) const {
    return solve_lower_transposed(lower_, x_ * scaled_columns(inverse_of(list), scale_));
  }

  double condition(const Terms& list) const {
    const auto values = eigenvalues_symmetric(chosen(gram_, list));
    return std::sqrt(values.back() / std::max(values.front(), 1e-300));
  }

 private:
  static Matrix chosen(const Matrix& a, const Terms& list) { return chosen_rows(chosen_columns(a, list), list); }

  Matrix inverse_of(const Terms& list) const {
    const Matrix part = inverse_symmetric(chosen(gram_, list));
    Matrix inverse(gram_.rows, gram_.rows);
    for (std::size_t i = 0; i < list.size(); ++i)
      for (std::size_t j = 0; j < list.size(); ++j) inverse(list[i], list[j]) = part(i, j);
    return inverse;
  }

  Matrix lower_, x_, gram_;
  std::vector<double> y_, right_, scale_;
};

/// The best of all subsets of the active terms whose solution is positive.
Solution best_subset(const NoiseProblem& problem, const Active& active, const Matrix& v) {
  const Whitened whitened(problem.design(), problem.y(), v);
  const auto list = listed(active);
  Solution best{std::vector<double>(problem.terms()), {}, std::numeric_limits<double>::infinity()};
  for (unsigned subset = 1; subset < (1u << list.size()); ++subset) {
    Terms subset_list;
    for (std::size_t a = 0; a < list.size(); ++a)
      if ((subset >> a) & 1u) subset_list.push_back(list[a]);
    Solution solution = whitened.solve(subset_list);
    if (*std::ranges::min_element(solution.c) >= 0.0 && solution.chi_square < best.chi_square)
      best = std::move(solution);
  }
  return best;
}

/// No coefficient below zero. Weights of a model far from the data may allow no such solution; then by the variances
/// alone, under which a single term is always positive.
Solution solve_nonnegative(const NoiseProblem& problem, const Active& active, const Matrix& v) {
  Solution best = best_subset(problem, active, v);
  return std::isinf(best.chi_square) ? best_subset(problem, active, diagonal(diagonal_of(v))) : best;
}

/// Iterates weights and coefficients to agreement.
State converge(const NoiseProblem& problem, const Active& active, double model_error, State state) {
  if (std::ranges::max(state.c) > 0.0) state.v = problem.covariance(state.c, model_error);
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const Solution next = solve_nonnegative(problem, active, state.v);
    const auto c = iteration > free_iterations ? scaled(0.5, scaled_sum(next.c, 1.0, state.c)) : next.c;
    const auto moved = problem.design() * difference(c, state.c), fitted = problem.design() * c;
    state = {c, problem.covariance(c, model_error), next.chi_square};
    if (std::ranges::equal(moved, fitted, [](double m, double f) { return std::abs(m) < last_move * std::abs(f); }))
      break;
  }
  return state;
}

Terms support(const std::vector<double>& c) {
  Terms list;
  for (std::size_t t = 0; t < c.size(); ++t)
    if (c[t] > 0.0) list.push_back(t);
  return list;
}

double degrees_of_freedom(const NoiseProblem& problem, const State& state) {
  return static_cast<double>(problem.y().size()) - static_cast<double>(support(state.c).size());
}

/// Relative error of each variance that makes chi-square equal its degrees of freedom; zero where chi-square is no
/// larger than chance explains (1 in 1000).
double model_error(const NoiseProblem& problem, const Active& active, const State& start) {
  const State statistical = converge(problem, active, 0.0, start);
  const double dof = degrees_of_freedom(problem, statistical);
  if (!has_model_error(statistical.chi_square, dof)) return 0.0;
  return model_error_where([&](double error) {
    const State state = converge(problem, active, error, statistical);
    return state.chi_square > degrees_of_freedom(problem, state);
  });
}

/// One term freely estimated beside the terms of `state` that are above zero, with the weights of `state`.
struct Single {
  double squared, sd;
  double edf;       ///< of the chi-square with the skewness of `squared`
  double positive;  ///< its expectation: the part of `squared` that varies, before what is known is subtracted
};

/// Skewness of weights' y. The Cholesky factor of the covariance V splits y into steps from each averaging time to the
/// next longer one, taken as independent and each as skewed as a chi-square with the degrees of freedom of its time.
double skewness(std::span<const double> weights, const std::vector<double>& fitted, const Matrix& v,
                const Matrix& lower) {
  const auto steps = transposed_product(lower, weights);
  double sum = 0.0;
  for (std::size_t i = 0; i < steps.size(); ++i)
    sum += steps[i] * square(steps[i]) * 2.0 * std::sqrt(v(i, i)) / fitted[i];
  return sum / std::pow(dot(steps, steps), 1.5);
}

Single single(const NoiseProblem& problem, const State& state, std::size_t term) {
  auto list = support(state.c);
  if (!(state.c[term] > 0.0)) list.push_back(term);
  const Whitened whitened(problem.design(), problem.y(), state.v);
  const Solution solution = whitened.solve(list);
  const Matrix weights = whitened.weights(list);
  const double sd = std::sqrt(solution.covariance(term, term));
  const double skew = skewness(column(weights, term), problem.design() * state.c, state.v, whitened.lower());
  const double edf = 8.0 / square(std::max(skew, least_skewness));
  return {solution.c[term], sd, edf, sd * std::sqrt(0.5 * edf)};
}

/// Of the observations as Gaussian variates, up to a constant.
double minus_twice_log_likelihood(const NoiseProblem& problem, const State& state) {
  const Cholesky factor = factor_of(state.v);
  const auto residual = solve_lower(factor.lower, difference(problem.y(), problem.design() * state.c));
  return dot(residual, residual) + factor.log_determinant;
}

/// Is this term needed beside `others`? Judged with the weights of the model without it.
void test_term(const NoiseProblem& problem, const Active& others, double error, const State& start, std::size_t term,
               FittedTerm& result) {
  if (listed(others).empty()) {
    result.z = std::numeric_limits<double>::infinity();
    result.chance = 0.0;
    return;
  }
  const State state = converge(problem, others, error, start);
  const Single one = single(problem, state, term);
  result.z = one.squared / one.sd;
  result.chance = chi_square_tail(1.0 + one.squared / one.positive, one.edf);
  if (result.kept) {
    const double with = minus_twice_log_likelihood(problem, start);
    result.improvement = minus_twice_log_likelihood(problem, state) - with;
    result.chance = std::min(1.0, 2.0 * std::min(result.chance, 0.5 * chi_square_tail(result.improvement, 1.0)));
    return;
  }
  result.squared = one.squared;
  result.squared_sd = one.sd;
}

/// The squared coefficient that would give less than the record does once in 20 times. Below zero counts as zero, so
/// that a curve that dips by chance promises no more than the record can show.
double upper_limit(const NoiseProblem& problem, const State& state, double error, std::size_t term) {
  const Single measured = single(problem, state, term);
  double limit = std::max(measured.squared, 0.0) + normal_one_sided_95 * measured.sd;
  for (int i = 0; i < iterations_of_limit; ++i) {
    State with = state;
    with.c[term] = limit;
    with.v = problem.covariance(with.c, error);
    const Single one = single(problem, with, term);
    const double below = one.positive * (1.0 - chi_square_quantile(missed_by_95, one.edf) / one.edf);
    limit = 0.5 * (limit + std::max(one.squared, 0.0) + below);
  }
  return limit;
}

struct Selected {
  State state;
  Active active;
  std::vector<FittedTerm> terms;
};

/// Removes, one after the other, the term that chance explains best.
Selected select(const NoiseProblem& problem, double error, const State& start, const AllanFitOptions& options) {
  Selected result{start, Active(problem.terms(), true), {}};
  result.terms.resize(result.active.size());
  for (;;) {
    result.state = converge(problem, result.active, error, start);
    std::size_t weakest = 0;
    double chance = -1.0;
    for (std::size_t t = 0; t < result.terms.size(); ++t) {
      const bool positive = result.state.c[t] > 0.0;
      result.terms[t].unit = problem.units()[t];
      result.terms[t].kept = positive && result.active[t];
      Active others = result.active;
      others[t] = false;
      test_term(problem, others, error, result.state, t, result.terms[t]);
      if (result.terms[t].kept && result.terms[t].chance > chance) {
        chance = result.terms[t].chance;
        weakest = t;
      }
    }
    if (!options.select || chance <= options.significance) return result;
    result.active[weakest] = false;
  }
}

void describe_terms(const NoiseProblem& problem, const State& state, double error, std::vector<FittedTerm>& terms) {
  for (std::size_t t = 0; t < terms.size(); ++t) {
    if (terms[t].kept) {
      const Single estimate = single(problem, state, t);
      terms[t].squared = state.c[t];
      terms[t].squared_sd = estimate.sd;
      terms[t].degrees_of_freedom =
          root_interval_degrees_of_freedom(estimate.edf, terms[t].squared / estimate.positive);
    }
    terms[t].upper_limit = upper_limit(problem, state, error, t);
  }
}

/// The design and, last, its derivative by the correlation time of a Markov process that is in the model.
Matrix with_markov_time(const NoiseProblem& problem, const std::vector<double>& c) {
  const UnitTerm unit = problem.units().back();
  if (unit.term != NoiseTerm::markov || c.back() == 0.0) return problem.design();
  std::vector<double> derivative;
  for (const std::size_t factor : problem.factors())
    derivative.push_back(c.back() * allan_variance_by_markov_time(unit, static_cast<double>(factor)));
  return beside(problem.design(), as_column(derivative));
}

/// Covariances, the correlation time of a Markov process counted as unknown; `missed`: variances by model error.
void add_covariance(const NoiseProblem& problem, const State& state, std::span<const double> missed,
                    const AllanFitOptions& options, AllanFit& fit) {
  const auto terms = problem.terms();
  const Matrix design = with_markov_time(problem, state.c);
  auto list = support(state.c);
  const Whitened whitened(design, problem.y(), state.v);
  fit.condition = whitened.condition(list);
  if (!options.select) list = listed(Active(terms, true));
  const bool timed = design.columns > terms;
  if (timed) list.push_back(terms);
  const Matrix all = whitened.solve(list).covariance, weights = whitened.weights(list);
  for (std::size_t t = 0; t < terms; ++t)
    fit.model_error_variance.push_back(dot(scaled(column(weights, t), column(weights, t)), missed));
  fit.covariance = block(all, 0, terms, 0, terms);
  if (!timed) return;
  const auto by_time = column(all, terms);
  fit.markov_time_covariance.assign(by_time.begin(), by_time.end());
  fit.degrees_of_freedom -= 1.0;
  for (std::size_t t = 0; t < terms; ++t)
    if (all(t, t) > 0.0) fit.terms[t].squared_sd = std::sqrt(all(t, t));
}

AllanFit described(const NoiseProblem& problem, Selected selected, double error, const AllanFitOptions& options) {
  const State& state = selected.state;
  describe_terms(problem, state, error, selected.terms);
  AllanFit fit;
  fit.terms = std::move(selected.terms);
  fit.squared = state.c;
  fit.model_error = error;
  fit.fitted = problem.design() * state.c;
  const Matrix statistical = problem.covariance(state.c, 0.0);
  for (std::size_t i = 0; i < fit.fitted.size(); ++i) {
    fit.residual.push_back(problem.y()[i] / fit.fitted[i] - 1.0);
    fit.residual_sd.push_back(std::sqrt(statistical(i, i)) / fit.fitted[i]);
  }
  fit.chi_square = Whitened(problem.design(), problem.y(), statistical).solve(support(state.c)).chi_square;
  fit.minus_twice_log_likelihood = minus_twice_log_likelihood(problem, {state.c, statistical, 0.0});
  fit.degrees_of_freedom = degrees_of_freedom(problem, state);
  add_covariance(problem, state, diagonal_of(state.v - statistical), options, fit);
  return fit;
}

}  // namespace

std::vector<AllanObservation> thinned(const std::vector<AllanObservation>& observations) {
  std::vector<AllanObservation> kept;
  for (auto one = observations.rbegin(); one != observations.rend(); ++one)
    if (kept.empty() || thinned_ratio * static_cast<double>(one->factor) <= static_cast<double>(kept.back().factor))
      kept.push_back(*one);
  if (!kept.empty() && kept.back().factor != observations.front().factor) kept.push_back(observations.front());
  std::reverse(kept.begin(), kept.end());
  return kept;
}

AllanFit fit_allan(const std::vector<AllanObservation>& observations, std::size_t samples,
                   const AllanFitOptions& options) {
  if (observations.size() < 2) throw Error(Error::Kind::bad_data, "fewer than 2 averaging times to fit");
  std::vector<UnitTerm> units;
  for (const NoiseTerm term : options.terms) units.push_back({term});
  if (options.markov_time > 0.0) units.push_back({NoiseTerm::markov, options.markov_time});
  std::vector<std::size_t> factors;
  for (const auto& one : observations) {
    if (!(one.variance > 0.0)) throw Error(Error::Kind::bad_data, "an Allan variance is not above zero");
    factors.push_back(one.factor);
  }
  const NoiseProblem problem(observations, AllanCovariance(units, factors, samples), samples);
  const Active all(units.size(), true);
  // From equal relative weights to the model's own, by steps: the iteration could else settle far from the data.
  State start = problem.start();
  for (const double relative : {1.0, 0.1}) start = converge(problem, all, relative, start);
  const double error = model_error(problem, all, start);
  return described(problem, select(problem, error, converge(problem, all, error, start), options), error, options);
}

}  // namespace tumble
