#include "tumble/math/population/components.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <span>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/square.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// Levels numbered from 0 in the order of their first result.
std::vector<std::size_t> numbered(const std::vector<std::size_t>& levels) {
  std::map<std::size_t, std::size_t> known;
  std::vector<std::size_t> out;
  for (const auto level : levels) out.push_back(known.try_emplace(level, known.size()).first->second);
  return out;
}

std::size_t count_of(const std::vector<std::size_t>& levels) {
  return levels.empty() ? 0 : std::ranges::max(levels) + 1;
}

void require_separable(const ManyResults& results) {
  const auto n = results.values.size();
  std::vector<std::string> problems;
  if (n < 4) problems.push_back(fmt::format("components need at least four results; here {} given", n));
  for (std::size_t a = 0; a < results.factors.size(); ++a) {
    const auto& factor = results.factors[a];
    const auto levels = numbered(factor.level);
    const auto count = count_of(levels);
    if (count < 2)
      problems.push_back(fmt::format("all results are of one {}: what it adds cannot be seen", factor.name));
    if (count == n)
      problems.push_back(fmt::format("every {0} has one result: {0} and repeat cannot be separated", factor.name));
    for (std::size_t b = 0; b < a; ++b)
      if (numbered(results.factors[b].level) == levels)
        problems.push_back(
            fmt::format("{0} and {1} change together: they cannot be separated", results.factors[b].name, factor.name));
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

/// The model at given variances: likelihood, scores and information (8.7).
struct AtVariances {
  double log_likelihood = 0.0, mean = 0.0, mean_variance = 0.0;
  std::vector<double> score;
  Matrix information;
  std::vector<double> weights;  ///< V^-1 1
};

struct Model {
  std::span<const double> values;
  Matrix fixed;                                  ///< u^2 and shared errors [n x n]
  std::vector<std::vector<std::size_t>> levels;  ///< of each component; the last has one result a level
  std::vector<std::size_t> counts;
};

Model model_of(const ManyResults& results) {
  const auto n = results.values.size();
  Model model{results.values, Matrix(n, n), {}, {}};
  for (std::size_t i = 0; i < n; ++i) {
    model.fixed(i, i) = square(results.sds[i]);
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t k = 0; k < results.shared.columns; ++k)
        model.fixed(i, j) += results.shared(i, k) * results.shared(j, k);
  }
  for (const auto& factor : results.factors) model.levels.push_back(numbered(factor.level));
  auto& each = model.levels.emplace_back(n);
  std::iota(each.begin(), each.end(), std::size_t{0});
  for (const auto& levels : model.levels) model.counts.push_back(count_of(levels));
  return model;
}

/// Z_a' P Z_b [levels of a x levels of b].
Matrix grouped(const Matrix& p, const Model& model, std::size_t a, std::size_t b) {
  Matrix out(model.counts[a], model.counts[b]);
  for (std::size_t j = 0; j < model.values.size(); ++j)
    for (std::size_t i = 0; i < model.values.size(); ++i) out(model.levels[a][i], model.levels[b][j]) += p(i, j);
  return out;
}

double sum_of_squares(const Matrix& a) {
  double sum = 0.0;
  for (std::size_t j = 0; j < a.columns; ++j)
    for (std::size_t i = 0; i < a.rows; ++i) sum += square(a(i, j));
  return sum;
}

void add_scores(const Model& model, const Matrix& p, const std::vector<double>& py, AtVariances& out) {
  const auto n = model.values.size(), components = model.levels.size();
  out.information = Matrix(components, components);
  for (std::size_t c = 0; c < components; ++c) {
    std::vector<double> sums(model.counts[c]);
    for (std::size_t i = 0; i < n; ++i) sums[model.levels[c][i]] += py[i];
    out.score.push_back(0.5 * (dot(sums, sums) - trace(grouped(p, model, c, c))));
    for (std::size_t d = 0; d <= c; ++d)
      out.information(c, d) = out.information(d, c) = 0.5 * sum_of_squares(grouped(p, model, c, d));
  }
}

AtVariances at(const Model& model, const std::vector<double>& variances, bool derivatives) {
  const auto n = model.values.size();
  Matrix v = model.fixed;
  for (std::size_t c = 0; c < variances.size(); ++c)
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t i = 0; i < n; ++i)
        if (model.levels[c][i] == model.levels[c][j]) v(i, j) += variances[c];
  const auto factor = cholesky(v);
  AtVariances out;
  if (!factor.positive) {
    out.log_likelihood = -INFINITY;
    return out;
  }
  out.weights = solve(factor, std::vector<double>(n, 1.0));
  const double sum = std::accumulate(out.weights.begin(), out.weights.end(), 0.0);
  out.mean_variance = 1.0 / sum;
  out.mean = dot(out.weights, model.values) / sum;
  std::vector<double> residual(model.values.begin(), model.values.end());
  for (auto& value : residual) value -= out.mean;
  const auto py = solve(factor, residual);  // P y
  out.log_likelihood = -0.5 * (factor.log_determinant + std::log(sum) + dot(residual, py));
  if (!derivatives) return out;
  Matrix p = solve(factor, identity(n));
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t i = 0; i < n; ++i) p(i, j) -= out.weights[i] * out.weights[j] / sum;
  add_scores(model, p, py, out);
  return out;
}

struct Maximum {
  std::vector<double> variances;
  AtVariances at;
};

/// One step of Fisher's scoring over the variances that are free: not held, and not pressed against zero.
std::vector<double> step_of(const AtVariances& at, const std::vector<double>& variances, std::size_t held) {
  std::vector<std::size_t> free;
  for (std::size_t c = 0; c < variances.size(); ++c)
    if (c != held && (variances[c] > 0.0 || at.score[c] > 0.0)) free.push_back(c);
  std::vector<double> step(variances.size(), 0.0), score;
  for (const auto c : free) score.push_back(at.score[c]);
  const auto part = solve_symmetric(chosen_columns(chosen_rows(at.information, free), free), score);
  for (std::size_t k = 0; k < free.size(); ++k) step[free[k]] = part[k];
  return step;
}

/// The restricted likelihood climbed from `variances`, with component `held` (if it is one) at its value.
Maximum climbed(const Model& model, std::vector<double> variances, std::size_t held) {
  auto here = at(model, variances, true);
  for (int pass = 0; pass < 200 && std::isfinite(here.log_likelihood); ++pass) {
    const auto step = step_of(here, variances, held);
    double share = 1.0, gain = 0.0;
    std::vector<double> next;
    AtVariances there;
    for (; share > 1e-6; share *= 0.5) {
      next = variances;
      for (std::size_t c = 0; c < next.size(); ++c) next[c] = std::max(0.0, next[c] + share * step[c]);
      there = at(model, next, false);
      gain = there.log_likelihood - here.log_likelihood;
      if (gain > 0.0) break;
    }
    if (!(gain > 0.0)) break;
    variances = next;
    here = at(model, variances, true);
    if (gain < 1e-12 * (1.0 + std::abs(here.log_likelihood))) break;
  }
  return {variances, here};
}

constexpr std::size_t none = static_cast<std::size_t>(-1);

Maximum most_likely(const Model& model, double variance_of_all) {
  std::vector<Maximum> found;
  for (const double part : {0.8, 0.2})
    found.push_back(climbed(model, std::vector<double>(model.levels.size(), square(part) * variance_of_all), none));
  return std::ranges::max(found, {}, [](const Maximum& one) { return one.at.log_likelihood; });
}

/// Interval (8.8) of component c.
void add_interval(const Model& model, const Maximum& best, std::size_t c, double largest, ComponentOfSpread& out) {
  const double variance = best.variances[c];
  const double information = inverse_symmetric(best.at.information)(c, c);
  out.degrees_of_freedom = std::max(1.0, information > 0.0 ? 2.0 * square(variance) / information : 1.0);
  const double limit = 3.8415 * (1.0 + 1.0 / (3.0 * out.degrees_of_freedom));
  auto near = best.variances;
  const auto excess = [&](double sd) {  // of the likelihood ratio over its limit
    near[c] = square(sd);
    const auto profile = climbed(model, near, c);
    near = profile.variances;
    return std::min(2.0 * (best.at.log_likelihood - profile.at.log_likelihood) - limit, 1e6);
  };
  const auto root = [&](double low, double high) {
    std::uintmax_t most = 40;
    const auto [from, to] =
        boost::math::tools::toms748_solve(excess, low, high, boost::math::tools::eps_tolerance<double>(24), most);
    return 0.5 * (from + to);
  };
  out.lower = excess(0.0) > 0.0 ? root(0.0, out.sd) : 0.0;
  near = best.variances;
  double outside = std::max(2.0 * out.sd, 0.1 * largest);
  while (excess(outside) < 0.0 && outside < 1e6 * largest) outside *= 2.0;
  out.upper = root(out.sd, outside);
}

void add_mean(const Model& model, const Maximum& best, SpreadComponents& out) {
  const double sum = 1.0 / best.at.mean_variance;
  std::vector<double> change;  // of the variance of the mean with each component
  for (std::size_t c = 0; c < model.levels.size(); ++c) {
    std::vector<double> sums(model.counts[c]);
    for (std::size_t i = 0; i < model.values.size(); ++i) sums[model.levels[c][i]] += best.at.weights[i];
    change.push_back(dot(sums, sums) / square(sum));
  }
  const double spread = quadratic_form(change, inverse_symmetric(best.at.information));
  out.mean = best.at.mean, out.mean_sd = std::sqrt(best.at.mean_variance);
  out.degrees_of_freedom = std::max(1.0, 2.0 * square(best.at.mean_variance) / spread);
  const double half = student_quantile(0.975, out.degrees_of_freedom) * out.mean_sd;
  out.mean_lower = out.mean - half, out.mean_upper = out.mean + half;
}

}  // namespace

SpreadComponents components_of_spread(const ManyResults& results) {
  require_separable(results);
  const Model model = model_of(results);
  const auto n = static_cast<double>(results.values.size());
  const double mean = std::accumulate(results.values.begin(), results.values.end(), 0.0) / n;
  double variance = 0.0;
  for (const double value : results.values) variance += square(value - mean) / (n - 1.0);
  const auto best = most_likely(model, variance);
  SpreadComponents out;
  for (std::size_t c = 0; c < model.levels.size(); ++c) {
    ComponentOfSpread one{c < results.factors.size() ? results.factors[c].name : "repeat",
                          std::sqrt(best.variances[c])};
    add_interval(model, best, c, std::sqrt(variance), one);
    out.components.push_back(std::move(one));
  }
  add_mean(model, best, out);
  return out;
}

}  // namespace tumble
