#include "tumble/math/population/components.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <numeric>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/population/components/likelihood.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/square.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr int most_climbs = 200;
constexpr double least_share_of_step = 1e-6;  ///< [1] a shorter step changes nothing
constexpr double same_end = 1e-6;             ///< [1] of an end of an interval
constexpr double likely_within = 3.8415;      ///< chi-square of one degree of freedom at 0.95
constexpr double first_width = 2.2;           ///< [sd] of the first step from the top: a little beyond the end, 1.96
constexpr double least_first_width = 1e-3, farthest_end = 1e6;        ///< [largest spread] of a step, and of an end
constexpr double least_gain_of_profile = 1e-6, greatest_ratio = 1e6;  ///< of the log-likelihood

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
  Problems problems;
  if (n < 4) problems.push_back(say("components need at least four results; here {} given", n));
  for (std::size_t a = 0; a < results.factors.size(); ++a) {
    const auto& factor = results.factors[a];
    const auto levels = numbered(factor.level);
    const auto count = count_of(levels);
    if (count < 2) problems.push_back(say("all results are of one {}: what it adds cannot be seen", Name{factor.name}));
    if (count == n)
      problems.push_back(say("every {0} has one result: {0} and repeat cannot be separated", Name{factor.name}));
    for (std::size_t b = 0; b < a; ++b)
      if (numbered(results.factors[b].level) == levels)
        problems.push_back(say("{0} and {1} change together: they cannot be separated", Name{results.factors[b].name},
                               Name{factor.name}));
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

using components::AtVariances;
using components::Model;

/// The restricted likelihood of a model as a function of the variances.
using Likelihood = std::function<AtVariances(const std::vector<double>& variances)>;

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

/// The restricted likelihood climbed from `variances`, with component `held` (if it is one) at its value, until a step
/// promises less than `least_gain`.
Maximum climbed(const Likelihood& at, std::vector<double> variances, std::size_t held, double least_gain) {
  auto here = at(variances);
  for (int pass = 0; pass < most_climbs && std::isfinite(here.log_likelihood); ++pass) {
    const auto step = step_of(here, variances, held);
    if (0.5 * dot(step, here.score) < least_gain) break;
    double gain = 0.0;
    for (double share = 1.0; share > least_share_of_step; share *= 0.5) {
      auto next = variances;
      for (std::size_t c = 0; c < next.size(); ++c) next[c] = std::max(0.0, next[c] + share * step[c]);
      auto there = at(next);
      gain = there.log_likelihood - here.log_likelihood;
      if (!(gain > 0.0)) continue;
      variances = std::move(next);
      here = std::move(there);
      break;
    }
    if (!(gain > least_gain)) break;
  }
  return {variances, here};
}

bool close_enough(double a, double b) { return std::abs(b - a) <= same_end * (std::abs(a) + std::abs(b)); }

constexpr std::size_t none = static_cast<std::size_t>(-1);

Maximum most_likely(const Likelihood& at, std::size_t components, double variance_of_all) {
  std::vector<Maximum> found;
  for (const double part : {0.8, 0.2})
    found.push_back(climbed(at, std::vector<double>(components, square(part) * variance_of_all), none, 1e-12));
  return std::ranges::max(found, {}, [](const Maximum& one) { return one.at.log_likelihood; });
}

/// Interval (8.8) of component c: steps outwards in units of its standard deviation, then the root.
void add_interval(const Likelihood& at, const Maximum& best, std::size_t c, double largest, ComponentOfSpread& out) {
  const double variance = best.variances[c];
  const double information = inverse_symmetric(best.at.information)(c, c);
  out.degrees_of_freedom = std::max(1.0, information > 0.0 ? 2.0 * square(variance) / information : 1.0);
  const double limit = likely_within * (1.0 + 1.0 / (3.0 * out.degrees_of_freedom));
  const double step = std::clamp(first_width * std::sqrt(std::max(information, 0.0)) / (2.0 * out.sd),
                                 least_first_width * largest, largest);
  auto near = best.variances;
  const auto excess = [&](double sd) {  // of the root of the likelihood ratio, almost a straight line, over its limit
    near[c] = square(sd);
    const auto profile = climbed(at, near, c, least_gain_of_profile);
    near = profile.variances;
    const double ratio = 2.0 * (best.at.log_likelihood - profile.at.log_likelihood);
    return std::sqrt(std::clamp(ratio, 0.0, greatest_ratio)) - std::sqrt(limit);
  };
  const auto end = [&](double direction) {
    near = best.variances;
    double inside = out.sd, inner = -std::sqrt(limit);
    for (double away = step;; away *= 2.0) {
      const double outside = std::max(0.0, out.sd + direction * away);
      const double outer = excess(outside);
      if (outer >= 0.0) {
        std::uintmax_t most = 40;
        const auto [from, to] =
            direction > 0.0
                ? boost::math::tools::toms748_solve(excess, inside, outside, inner, outer, close_enough, most)
                : boost::math::tools::toms748_solve(excess, outside, inside, outer, inner, close_enough, most);
        return 0.5 * (from + to);
      }
      if (outside == 0.0 || away > farthest_end * largest) return outside;
      inside = outside, inner = outer;
    }
  };
  out.lower = out.sd > 0.0 ? end(-1.0) : 0.0;
  out.upper = end(1.0);
}

void add_mean(const Model& model, const Maximum& best, SpreadComponents& out) {
  const double sum = 1.0 / best.at.mean_variance;
  std::vector<double> change;  // of the variance of the mean with each component
  for (std::size_t c = 0; c < model.levels.size(); ++c) {
    std::vector<double> sums(model.counts[c]);
    for (std::size_t i = 0; i < model.values.size(); ++i) sums[model.levels[c][i]] += best.at.weights[i];
    change.push_back(dot(sums, sums) / square(sum));
  }
  change.push_back(dot(best.at.weights, best.at.weights) / square(sum));
  const double spread = quadratic_form(change, inverse_symmetric(best.at.information));
  out.mean = best.at.mean, out.mean_sd = std::sqrt(best.at.mean_variance);
  out.degrees_of_freedom = std::max(1.0, 2.0 * square(best.at.mean_variance) / spread);
  const double half = student_quantile(two_sided_95, out.degrees_of_freedom) * out.mean_sd;
  out.mean_lower = out.mean - half, out.mean_upper = out.mean + half;
}

Likelihood likelihood_of(const Model& model, double variance_of_all) {
  if (model.values.size() < components::many)
    return [&model](const std::vector<double>& variances) { return components::dense_at(model, variances); };
  const auto sparse = std::make_shared<components::SparseLikelihood>(model, variance_of_all);
  return [sparse](const std::vector<double>& variances) { return sparse->at(variances); };
}

}  // namespace

components::Model components::model_of(const ManyResults& results) {
  Model model;
  model.values = results.values;
  model.shared = results.shared;
  for (const double sd : results.sds) model.own.push_back(square(sd));
  for (const auto& factor : results.factors) {
    model.levels.push_back(numbered(factor.level));
    model.counts.push_back(count_of(model.levels.back()));
  }
  return model;
}

SpreadComponents components_of_spread(const ManyResults& results) {
  require_separable(results);
  const Model model = components::model_of(results);
  const auto n = static_cast<double>(results.values.size());
  const double mean = std::accumulate(results.values.begin(), results.values.end(), 0.0) / n;
  double variance = 0.0;
  for (const double value : results.values) variance += square(value - mean) / (n - 1.0);
  const auto at = likelihood_of(model, variance);
  const auto best = most_likely(at, results.factors.size() + 1, variance);
  SpreadComponents out;
  for (std::size_t c = 0; c <= results.factors.size(); ++c) {
    ComponentOfSpread one{c < results.factors.size() ? results.factors[c].name : "repeat",
                          std::sqrt(best.variances[c])};
    add_interval(at, best, c, std::sqrt(variance), one);
    out.components.push_back(std::move(one));
  }
  add_mean(model, best, out);
  return out;
}

}  // namespace tumble
