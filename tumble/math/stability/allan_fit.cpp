#include "tumble/math/stability/allan_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/regression/least_squares.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Active = std::vector<bool>;

MatrixXd to_eigen(const Matrix& m) {
  return Eigen::Map<const MatrixXd>(m.values.data(), static_cast<Eigen::Index>(m.rows),
                                    static_cast<Eigen::Index>(m.columns));
}

struct State {
  VectorXd c;  ///< squared coefficients, one a term, zero where not active
  MatrixXd v;  ///< covariance of the observations under c, model error included
  double chi_square = 0.0;
};

/// The observations and what may explain them.
class Problem {
 public:
  Problem(const std::vector<AllanObservation>& observations, AllanCovariance covariance, std::size_t samples)
      : covariance_(std::move(covariance)), design_(to_eigen(covariance_.design())) {
    const auto n = static_cast<Eigen::Index>(observations.size());
    y_.resize(n);
    thinning_.resize(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto& one = observations[static_cast<std::size_t>(i)];
      y_[i] = one.variance;
      const double whole = static_cast<double>(samples + 1 - 2 * one.factor);
      thinning_[i] = one.count == 0 ? 1.0 : std::sqrt(std::max(1.0, whole / static_cast<double>(one.count)));
    }
  }

  Eigen::Index terms() const { return design_.cols(); }
  const VectorXd& y() const { return y_; }
  const MatrixXd& design() const { return design_; }
  std::size_t factor(Eigen::Index i) const { return covariance_.factors()[static_cast<std::size_t>(i)]; }
  const std::vector<UnitTerm>& units() const { return covariance_.terms(); }

  /// Covariance of the observations under the model c. Gaps thin out the differences: taken as independent of them.
  MatrixXd covariance(const VectorXd& c, double model_error) const {
    MatrixXd v = to_eigen(covariance_.at({c.data(), c.data() + c.size()}));
    v.array() *= (thinning_ * thinning_.transpose()).array();
    v.diagonal().array() *= 1.0 + 1e-10;
    v.diagonal().array() += (model_error * (design_ * c)).array().square();
    return v;
  }

  /// Before any model: every averaging time with the same relative error.
  State start() const { return {VectorXd::Zero(terms()), MatrixXd(y_.array().square().matrix().asDiagonal())}; }

 private:
  AllanCovariance covariance_;
  MatrixXd design_;
  VectorXd y_, thinning_;
};

std::vector<Eigen::Index> listed(const Active& active) {
  std::vector<Eigen::Index> list;
  for (std::size_t t = 0; t < active.size(); ++t)
    if (active[t]) list.push_back(static_cast<Eigen::Index>(t));
  return list;
}

/// What least squares gives for the terms in `list`, signs free.
struct Solution {
  VectorXd c;           ///< one a listed term
  MatrixXd covariance;  ///< of c
  double chi_square = 0.0;
};

/// Observations and design made white and scaled once, then solved for any choice of terms.
class Whitened {
 public:
  Whitened(const MatrixXd& design, const VectorXd& y, const MatrixXd& v) : cholesky_(v) {
    if (cholesky_.info() != Eigen::Success)
      throw Error(Error::Kind::internal, "the covariance of the Allan variances is not positive definite");
    x_ = cholesky_.matrixL().solve(design);
    scale_ = x_.colwise().norm().cwiseInverse();
    x_ = x_ * scale_.asDiagonal();
    y_ = cholesky_.matrixL().solve(y);
    gram_ = x_.transpose() * x_;
    right_ = x_.transpose() * y_;
  }

  Solution solve(const std::vector<Eigen::Index>& list) const {
    const MatrixXd gram = gram_(list, list);
    const VectorXd right = right_(list), scale = scale_(list);
    const MatrixXd inverse = gram.ldlt().solve(MatrixXd::Identity(gram.rows(), gram.cols()));
    const VectorXd b = inverse * right;
    return {scale.cwiseProduct(b), scale.asDiagonal() * inverse * scale.asDiagonal(),
            (y_ - x_(Eigen::all, list) * b).squaredNorm()};
  }

  /// One row a listed term: c = weights * y.
  MatrixXd weights(const std::vector<Eigen::Index>& list) const {
    const MatrixXd x = x_(Eigen::all, list);
    const MatrixXd solved = (x.transpose() * x).ldlt().solve(x.transpose());
    const VectorXd scale = scale_(list);
    return scale.asDiagonal() * cholesky_.matrixU().solve(solved.transpose()).transpose();
  }

  double condition(const std::vector<Eigen::Index>& list) const {
    const MatrixXd gram = gram_(list, list);
    const VectorXd values = Eigen::SelfAdjointEigenSolver<MatrixXd>(gram).eigenvalues();
    return std::sqrt(values.maxCoeff() / std::max(values.minCoeff(), 1e-300));
  }

 private:
  Eigen::LLT<MatrixXd> cholesky_;
  MatrixXd x_, gram_;
  VectorXd y_, right_, scale_;
};

/// No coefficient below zero: the best of all subsets whose solution is positive. Weights of a model far from the data
/// may leave none; then by the variances alone, under which a single term is always positive.
State solve_nonnegative(const Problem& problem, const Active& active, const MatrixXd& v) {
  const Whitened whitened(problem.design(), problem.y(), v);
  const auto list = listed(active);
  State best{VectorXd::Zero(problem.terms()), v, std::numeric_limits<double>::infinity()};
  for (unsigned subset = 1; subset < (1u << list.size()); ++subset) {
    std::vector<Eigen::Index> chosen;
    for (std::size_t a = 0; a < list.size(); ++a)
      if ((subset >> a) & 1u) chosen.push_back(list[a]);
    const Solution one = whitened.solve(chosen);
    if (one.c.minCoeff() < 0.0 || one.chi_square >= best.chi_square) continue;
    best.chi_square = one.chi_square;
    best.c.setZero();
    best.c(chosen) = one.c;
  }
  if (std::isinf(best.chi_square) && !v.isDiagonal())
    return solve_nonnegative(problem, active, MatrixXd(v.diagonal().asDiagonal()));
  return best;
}

/// Iterates weights and coefficients to agreement.
State converge(const Problem& problem, const Active& active, double model_error, State state) {
  if (state.c.maxCoeff() > 0.0) state.v = problem.covariance(state.c, model_error);
  for (int iteration = 0; iteration < 40; ++iteration) {
    const State next = solve_nonnegative(problem, active, state.v);
    const VectorXd c = iteration > 8 ? VectorXd(0.5 * (next.c + state.c)) : next.c;
    const VectorXd moved = problem.design() * (c - state.c), fitted = problem.design() * c;
    state = {c, problem.covariance(c, model_error), next.chi_square};
    if ((moved.array() / fitted.array()).abs().maxCoeff() < 1e-6) break;
  }
  return state;
}

double degrees_of_freedom(const Problem& problem, const State& state) {
  return static_cast<double>(problem.y().size() - (state.c.array() > 0.0).count());
}

/// Relative error of each variance that makes chi-square equal its degrees of freedom; zero where chi-square is no
/// larger than chance explains (1 in 1000).
double model_error(const Problem& problem, const Active& active, const State& start) {
  const State plain = converge(problem, active, 0.0, start);
  const double dof = degrees_of_freedom(problem, plain);
  if (dof < 1.0 || chi_square_tail(plain.chi_square / dof, dof) > 1e-3) return 0.0;
  double low = std::log(1e-5), high = std::log(3.0);
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (low + high);
    const State state = converge(problem, active, std::exp(middle), plain);
    (state.chi_square > degrees_of_freedom(problem, state) ? low : high) = middle;
  }
  return std::exp(high);
}

std::vector<Eigen::Index> support(const VectorXd& c) {
  std::vector<Eigen::Index> list;
  for (Eigen::Index t = 0; t < c.size(); ++t)
    if (c[t] > 0.0) list.push_back(t);
  return list;
}

/// One term freely estimated beside the terms of `state` that are above zero, with the weights of `state`.
struct Single {
  double squared, sd;
  double edf;       ///< of the chi-square with the skewness of `squared`
  double positive;  ///< its expectation: the part of `squared` that varies, before what is known is taken off
};

/// Skewness of weights * y. The Cholesky factor splits y into steps from each averaging time to the next longer one,
/// taken as independent and each as skewed as a chi-square with the degrees of freedom of its averaging time.
double skewness(const VectorXd& weights, const VectorXd& fitted, const MatrixXd& v) {
  const MatrixXd factor = Eigen::LLT<MatrixXd>(v).matrixL();
  const VectorXd steps = factor.transpose() * weights;
  const VectorXd edf = 2.0 * fitted.array().square() / v.diagonal().array();
  return (steps.array().cube() * (8.0 / edf.array()).sqrt()).sum() / std::pow(steps.squaredNorm(), 1.5);
}

Single single(const Problem& problem, const State& state, Eigen::Index term) {
  auto list = support(state.c);
  auto at = std::find(list.begin(), list.end(), term);
  const auto index = static_cast<Eigen::Index>(at - list.begin());
  if (at == list.end()) list.push_back(term);
  const Whitened whitened(problem.design(), problem.y(), state.v);
  const Solution solution = whitened.solve(list);
  const VectorXd weights = whitened.weights(list).row(index).transpose();
  const double sd = std::sqrt(solution.covariance(index, index));
  const double skew = std::max(skewness(weights, problem.design() * state.c, state.v), 1e-3);
  const double edf = 8.0 / (skew * skew);
  return {solution.c[index], sd, edf, sd * std::sqrt(0.5 * edf)};
}

/// Of the observations as Gaussian variates, up to a constant.
double minus_twice_log_likelihood(const Problem& problem, const State& state) {
  const Eigen::LLT<MatrixXd> cholesky(state.v);
  const VectorXd residual = cholesky.matrixL().solve(problem.y() - problem.design() * state.c);
  return residual.squaredNorm() + 2.0 * MatrixXd(cholesky.matrixL()).diagonal().array().log().sum();
}

/// Is this term needed beside `others`? Judged with the weights of the model without it.
void test_term(const Problem& problem, const Active& others, double error, const State& start, Eigen::Index term,
               FittedTerm& result) {
  if (std::none_of(others.begin(), others.end(), [](bool one) { return one; })) {
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

/// The squared coefficient that would have given less than what was seen once in 20 times. Below zero counts as zero,
/// so that a curve that dips by chance does not promise more than the record can show.
double upper_limit(const Problem& problem, const State& state, double error, Eigen::Index term) {
  const Single seen = single(problem, state, term);
  double limit = std::max(seen.squared, 0.0) + 1.645 * seen.sd;
  for (int i = 0; i < 20; ++i) {
    State with = state;
    with.c[term] = limit;
    with.v = problem.covariance(with.c, error);
    const Single one = single(problem, with, term);
    const double below = one.positive * (1.0 - chi_square_quantile(0.05, one.edf) / one.edf);
    limit = 0.5 * (limit + std::max(one.squared, 0.0) + below);
  }
  return limit;
}

struct Selected {
  State state;
  Active active;
  std::vector<FittedTerm> terms;
};

/// Takes out, one after the other, the term that chance explains best.
Selected select(const Problem& problem, double error, const State& start, const AllanFitOptions& options) {
  Selected result{start, Active(static_cast<std::size_t>(problem.terms()), true), {}};
  result.terms.resize(result.active.size());
  for (;;) {
    result.state = converge(problem, result.active, error, start);
    std::size_t weakest = 0;
    double chance = -1.0;
    for (std::size_t t = 0; t < result.terms.size(); ++t) {
      const bool positive = result.state.c[static_cast<Eigen::Index>(t)] > 0.0;
      result.terms[t].unit = problem.units()[t];
      result.terms[t].kept = positive && result.active[t];
      Active others = result.active;
      others[t] = false;
      test_term(problem, others, error, result.state, static_cast<Eigen::Index>(t), result.terms[t]);
      if (result.terms[t].kept && result.terms[t].chance > chance) {
        chance = result.terms[t].chance;
        weakest = t;
      }
    }
    if (!options.select || chance <= options.significance) return result;
    result.active[weakest] = false;
  }
}

void describe_terms(const Problem& problem, const State& state, double error, std::vector<FittedTerm>& terms) {
  for (std::size_t t = 0; t < terms.size(); ++t) {
    const auto index = static_cast<Eigen::Index>(t);
    if (terms[t].kept) {
      const Single one = single(problem, state, index);
      terms[t].squared = state.c[index];
      terms[t].squared_sd = one.sd;
      terms[t].degrees_of_freedom = root_interval_degrees_of_freedom(one.edf, terms[t].squared / one.positive);
    }
    terms[t].upper_limit = upper_limit(problem, state, error, index);
  }
}

/// The design and, last, its derivative by the correlation time of a Markov process that is in the model.
MatrixXd with_markov_time(const Problem& problem, const VectorXd& c) {
  const Eigen::Index markov = problem.terms() - 1;
  if (problem.units().back().term != NoiseTerm::markov || c[markov] == 0.0) return problem.design();
  MatrixXd design(problem.y().size(), problem.terms() + 1);
  const UnitTerm unit = problem.units().back();
  for (Eigen::Index i = 0; i < design.rows(); ++i)
    design(i, markov + 1) = c[markov] * allan_variance_by_markov_time(unit, static_cast<double>(problem.factor(i)));
  design.leftCols(problem.terms()) = problem.design();
  return design;
}

std::vector<double> to_vector(const VectorXd& v) { return {v.data(), v.data() + v.size()}; }

/// Covariances, the correlation time of a Markov process counted as unknown; `missed`: variances by model error.
void add_covariance(const Problem& problem, const State& state, const VectorXd& missed, const AllanFitOptions& options,
                    AllanFit& fit) {
  const auto terms = problem.terms();
  const MatrixXd design = with_markov_time(problem, state.c);
  const bool timed = design.cols() > terms;
  auto list = support(state.c);
  const Whitened whitened(design, problem.y(), state.v);
  fit.condition = whitened.condition(list);
  if (!options.select) list = listed(Active(fit.terms.size(), true));
  if (timed) list.push_back(terms);
  MatrixXd whole = MatrixXd::Zero(terms + 1, terms + 1);
  whole(list, list) = whitened.solve(list).covariance;
  VectorXd by_error = VectorXd::Zero(terms + 1);
  by_error(list) = whitened.weights(list).array().square().matrix() * missed;
  fit.model_error_variance = to_vector(by_error.head(terms));
  fit.covariance = Matrix(fit.terms.size(), fit.terms.size());
  Eigen::Map<MatrixXd>(fit.covariance.values.data(), terms, terms) = whole.topLeftCorner(terms, terms);
  if (!timed) return;
  fit.markov_time_covariance = to_vector(whole.col(terms));
  fit.degrees_of_freedom -= 1.0;
  for (Eigen::Index t = 0; t < terms; ++t)
    if (whole(t, t) > 0.0) fit.terms[static_cast<std::size_t>(t)].squared_sd = std::sqrt(whole(t, t));
}

AllanFit described(const Problem& problem, Selected selected, double error, const AllanFitOptions& options) {
  const State& state = selected.state;
  describe_terms(problem, state, error, selected.terms);
  AllanFit fit;
  fit.terms = std::move(selected.terms);
  fit.squared = to_vector(state.c);
  fit.model_error = error;
  const VectorXd fitted = problem.design() * state.c;
  const MatrixXd statistical = problem.covariance(state.c, 0.0);
  fit.fitted = to_vector(fitted);
  fit.residual = to_vector((problem.y().array() / fitted.array() - 1.0).matrix());
  fit.residual_sd = to_vector((statistical.diagonal().array().sqrt() / fitted.array()).matrix());
  const auto kept = support(state.c);
  const Solution free = Whitened(problem.design(), problem.y(), statistical).solve(kept);
  fit.chi_square = free.chi_square;
  fit.minus_twice_log_likelihood = minus_twice_log_likelihood(problem, {state.c, statistical, 0.0});
  fit.degrees_of_freedom = degrees_of_freedom(problem, state);
  add_covariance(problem, state, (state.v - statistical).diagonal(), options, fit);
  return fit;
}

}  // namespace

std::vector<AllanObservation> thinned(const std::vector<AllanObservation>& observations) {
  std::vector<AllanObservation> kept;
  for (auto one = observations.rbegin(); one != observations.rend(); ++one)
    if (kept.empty() || 1.9 * static_cast<double>(one->factor) <= static_cast<double>(kept.back().factor))
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
  const Problem problem(observations, AllanCovariance(units, factors, samples), samples);
  const Active all(units.size(), true);
  // From equal relative weights to the model's own, by steps: the iteration could else settle far from the data.
  State start = problem.start();
  for (const double relative : {1.0, 0.1}) start = converge(problem, all, relative, start);
  const double error = model_error(problem, all, start);
  return described(problem, select(problem, error, converge(problem, all, error, start), options), error, options);
}

}  // namespace tumble
