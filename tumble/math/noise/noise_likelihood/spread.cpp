#include "tumble/math/noise/noise_likelihood/spread.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "tumble/math/bisection.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/noise/noise_likelihood/excess.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/stability/allan_fit.hpp"

namespace tumble::noise_likelihood {
namespace {

constexpr double least_band_share = 1e-6;   ///< [1] of a band as fitted, for coefficients that would make it negative
constexpr double least_start_share = 1e-3;  ///< [1] of a band as fitted, from which the search for a limit starts

/// A weighted design with columns of length 1.
struct Weighted {
  std::vector<double> weight, scale;
  Matrix unit;  ///< weight x scale
};

Weighted weighted(const BandData& data, const Matrix& x, std::span<const double> s) {
  Weighted out{root_weights(data, s), {}, {}};
  out.unit = scaled_rows(out.weight, x);
  out.scale = inverses(column_norms(out.unit));
  out.unit = scaled_columns(std::move(out.unit), out.scale);
  return out;
}

/// P(estimate of one coefficient <= `estimate`) if it were c: the estimate as a sum of mean squares, of which variance
/// and third moment make a shifted chi-square.
double chance_below(const BandData& data, const Matrix& x, std::span<const double> fitted, std::size_t which,
                    double estimate, double c, double widening) {
  auto s = scaled_sum(fitted, c - estimate, column(x, which));
  for (std::size_t b = 0; b < s.size(); ++b) s[b] = std::max(s[b], least_band_share * fitted[b]);
  const auto [weight, scale, unit] = weighted(data, x, s);
  std::vector<double> chosen(x.columns);
  chosen[which] = scale[which];
  const auto row = solve_symmetric(gram(unit), chosen);
  const double sd = std::sqrt(scale[which] * row[which]);
  const auto gain = scaled(weight, unit * row);
  double third = 0.0;
  for (std::size_t b = 0; b < s.size(); ++b) third += 8.0 * std::pow(gain[b] * s[b], 3) / std::pow(data.count[b], 2);
  const double skew = third / (sd * sd * sd), edf = freedom_of_skewness(skew);
  const double off = (estimate - c) / (widening * sd * std::sqrt(0.5 * edf));
  return skew > 0.0 ? 1.0 - chi_square_tail(1.0 + off, edf) : chi_square_tail(1.0 - off, edf);
}

/// Degrees of freedom of the Student factor at which 5 % of intervals miss.
double freedom_for(const std::function<double(double)>& missed) {
  constexpr double most = 1e4;                                      // more are as good as infinity: 1.9602 for 1.9600
  constexpr int halvings_of_factor = 12, halvings_of_freedom = 20;  // to 0.003 of 12.7; to 1e-5 of the freedom
  const double normal = student_quantile(two_sided_95, most);
  if (missed(normal) <= missed_by_95) return std::numeric_limits<double>::infinity();
  const double factor = bisected(normal, student_quantile(two_sided_95, 1.0), halvings_of_factor, [&](double t) {
                          return missed(t) > missed_by_95;
                        }).high;
  return std::exp(bisected(0.0, std::log(most), halvings_of_freedom, [&](double logarithm) {
                    return student_quantile(two_sided_95, std::exp(logarithm)) > factor;
                  }).middle());
}

/// What dependence adds to the variance of the score. Of all covariances only those of near scales are counted: where
/// they are negative and no variance remains (noise that falls by orders of magnitude between the scales, beyond a
/// filter of second order), those that are below zero are not.
///
/// Given     information   of independent contrasts, of columns of length 1;   scale   of the columns
Matrix possible(const Matrix& information, std::span<const double> scale, const Matrix& more) {
  constexpr double least = 0.05;
  const Cholesky root = cholesky(information);
  if (!root.positive) return more;
  const Matrix half = solve_lower(root.lower, sandwich(diagonal(scale), more));
  const SymmetricEigen in = eigen_symmetric(solve_lower(root.lower, transposed(half)));
  if (in.values.empty() || std::ranges::min(in.values) > least - 1.0) return more;
  std::vector<double> kept;
  for (const double value : in.values) kept.push_back(std::max(value, 0.0));
  const Matrix back = scaled_rows(inverses(scale), root.lower * in.vectors);
  return sandwich(back, kept);
}

}  // namespace

LinearNoise linear(const BandData& data, const TriedTerms& chosen, const SearchRange* range) {
  constexpr double h = 1e-3;
  LinearNoise result;
  std::vector<std::size_t> list;
  std::size_t place = 0;
  double white = 0.0;
  for (std::size_t t = 0; t < power_laws; ++t) {
    if (!chosen.terms.used[t]) continue;
    if (t == 1) white = chosen.fit.c[place];
    if (chosen.fit.c[place] > 0.0) {
      list.push_back(place);
      result.terms.push_back(t);
    }
    ++place;
  }
  Matrix slopes;
  for (std::size_t m = 0; m < chosen.terms.times.size(); ++m, ++place) {
    if (!(chosen.fit.c[place] > 0.0)) continue;
    list.push_back(place);
    result.terms.push_back(power_laws + m);
    const double time = chosen.terms.times[m];
    if (range != nullptr && range->at_bound(time)) continue;
    result.processes.push_back(m);
    const auto change = difference(data.markov(time * std::exp(h)), data.markov(time * std::exp(-h)));
    slopes = beside(slopes, as_column(scaled(chosen.fit.c[place] / (2.0 * h), change)));
  }
  for (int k = 0; white > 0.0 && k < chosen.terms.filter_parameters(); ++k, ++result.filter_parameters) {
    const auto moved = [&](double factor) {
      NoiseFilter filter = chosen.terms.filter;
      (k == 0 ? filter.bandwidth : filter.damping) *= factor;
      return data.filtered(filter);
    };
    slopes = beside(slopes, as_column(scaled(white / (2.0 * h), difference(moved(std::exp(h)), moved(std::exp(-h))))));
  }
  result.x = beside(chosen_columns(columns(data, chosen.terms), list), slopes);
  return result;
}

std::vector<WeightedTerm> weighted_terms(const TriedTerms& chosen) {
  std::vector<WeightedTerm> terms;
  auto squared = chosen.fit.c.begin();
  for (std::size_t t = 0; t < power_laws; ++t)
    if (chosen.terms.used[t])
      terms.push_back({{power_law_terms[t]},
                       *squared++,
                       t == 1 ? filtered_autocovariance(chosen.terms.filter) : std::vector<double>()});
  for (const double time : chosen.terms.times) terms.push_back({{NoiseTerm::markov, time}, *squared++, {}});
  return terms;
}

NoiseSpread spread(const BandData& data, const std::vector<double>& statistical_count, const LinearNoise& model,
                   const TriedTerms& chosen) {
  const auto& s = chosen.fit.s;
  const auto [weight, scale, unit] = weighted(data, model.x, s);
  const Matrix information = gram(unit);
  const Matrix inverse = scaled_columns(inverse_symmetric(information), scale);
  const Matrix independent = scaled_rows(scale, inverse);
  std::vector<double> each, errors;  // weight of each contrast in the derivative; variance by model error
  for (std::size_t b = 0; b < s.size(); ++b) {
    each.push_back(data.count[b] / statistical_count[b] / (s[b] * s[b]));
    errors.push_back(s[b] * s[b] * (2.0 / data.count[b] - 2.0 / statistical_count[b]));
  }
  const auto terms = weighted_terms(chosen);
  const auto excess = excess_scatter(data, terms);
  const Matrix weights = scaled_rows(each, model.x);
  const Matrix more = possible(information, scale,
                               covariance_of_dependence(data.bands, terms, weights) +
                                   covariance_of_excess(data, excess, statistical_count, s, weights));
  NoiseSpread result;
  for (const ExcessScatter& one : excess) result.scatter_ratio = std::max(result.scatter_ratio, one.ratio);
  result.covariance = independent + sandwich(independent, more);
  for (std::size_t i = 0; i < independent.rows; ++i)
    result.widening.push_back(std::sqrt(result.covariance(i, i) / independent(i, i)));
  result.by_error = sandwich(transposed(scaled_rows(weight, unit * inverse)), errors);  // of c = gain z
  const auto values = eigenvalues_symmetric(information);
  result.condition = std::sqrt(values.back() / std::max(values.front(), 1e-300));
  return result;
}

double interval_freedom(const BandData& data, const Matrix& x, const std::vector<double>& s, std::size_t column,
                        double squared, double value, double sd, double widening) {
  return freedom_for([&](double t) {
    const double lower = value - t * sd;
    return chance_below(data, x, s, column, squared, std::pow(value + t * sd, 2), widening) +
           (lower > 0.0 ? 1.0 - chance_below(data, x, s, column, squared, lower * lower, widening) : 0.0);
  });
}

double time_freedom(double sd) {
  return freedom_for([&](double t) {
    // Greatest share of the truth whose interval ends below it, and least whose interval starts above it.
    constexpr double least_share = 1e-3;  // of the truth; a time so short is no estimate of it
    constexpr int halvings = 30;          // to 1e-9
    const double low = bisected(least_share, 1.0, halvings, [&](double share) {
                         return share + t * sd * std::pow(share, 1.5) < 1.0;
                       }).low;
    const double starts = 4.0 / (9.0 * t * t * sd * sd);  // share - t sd share^1.5 is greatest here
    double above = 0.0;
    if (starts > 1.0 && starts - t * sd * std::pow(starts, 1.5) > 1.0) {
      const double most = bisected(1.0, starts, halvings, [&](double share) {
                            return share - t * sd * std::pow(share, 1.5) < 1.0;
                          }).high;
      above = normal_below(-std::log(most) / sd);
    }
    return normal_below(std::log(low) / sd) + above;
  });
}

double logarithm_freedom(double sd) {
  if (!(sd > 0.0)) return std::numeric_limits<double>::infinity();
  const auto beyond = [&](double off) { return normal_above(off / sd); };
  return freedom_for(
      [&](double t) { return beyond(std::log1p(t * sd)) + (t * sd < 1.0 ? beyond(-std::log1p(-t * sd)) : 0.0); });
}

double upper_limit(const BandData& data, const Matrix& others, std::span<const double> column, bool ramp,
                   const ScoringFit& free, double value, double sd) {
  const auto rise = [&](double c) {
    auto start = scaled_sum(free.s, c - value, column);
    for (std::size_t b = 0; b < start.size(); ++b) start[b] = std::max(start[b], least_start_share * free.s[b]);
    return fit_by_scoring(data, others, ramp, start, scaled(c, column)).minus_twice_log_likelihood -
           free.minus_twice_log_likelihood;
  };
  constexpr double rise_at_limit = 2.71;  // chi-square with one degree of freedom: the square of 1.645
  constexpr double widening = 1.5;        // of the interval, until the limit lies within it
  constexpr int most_widenings = 30;      // to 2e5 of the first; without a limit there the last is returned
  constexpr int halvings = 8;             // to 1/256 of the last widening
  double low = value, high = value + normal_one_sided_95 * sd;
  for (int i = 0; i < most_widenings && rise(high) < rise_at_limit; ++i) {
    low = high;
    high = value + widening * (high - value);
  }
  return bisected(low, high, halvings, [&](double c) { return rise(c) < rise_at_limit; }).high;
}

}  // namespace tumble::noise_likelihood
