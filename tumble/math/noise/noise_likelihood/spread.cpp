#include "tumble/math/noise/noise_likelihood/spread.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "tumble/math/eigen/view.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/stability/allan_fit.hpp"

namespace tumble::noise_likelihood {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// P(estimate of one coefficient <= `estimate`) if it were c: the estimate as a sum of mean squares, of which variance
/// and third moment make a shifted chi-square.
double chance_below(const BandData& data, const MatrixXd& x, const VectorXd& fitted, Index column, double estimate,
                    double c, double widening) {
  const VectorXd s = (fitted + (c - estimate) * x.col(column)).cwiseMax(1e-6 * fitted);
  const VectorXd weight = (0.5 * data.count).cwiseSqrt().cwiseQuotient(s);
  MatrixXd weighted = weight.asDiagonal() * x;
  const VectorXd scale = weighted.colwise().norm().cwiseInverse();
  weighted = weighted * scale.asDiagonal();
  const VectorXd row = (weighted.transpose() * weighted).ldlt().solve(VectorXd::Unit(x.cols(), column));
  const double sd = scale[column] * std::sqrt(row[column]);
  const VectorXd gain = scale[column] * (weight.asDiagonal() * (weighted * row));
  const double third = (gain.array().cube() * 8.0 * s.array().cube() / data.count.array().square()).sum();
  const double skew = third / (sd * sd * sd), edf = 8.0 / std::max(skew * skew, 1e-6);
  const double off = (estimate - c) / (widening * sd * std::sqrt(0.5 * edf));
  return skew > 0.0 ? 1.0 - chi_square_tail(1.0 + off, edf) : chi_square_tail(1.0 - off, edf);
}

/// Degrees of freedom of the Student factor at which 5 % of intervals miss.
double freedom_for(const std::function<double(double)>& missed) {
  constexpr double most = 1e4;
  const double normal = student_quantile(0.975, most);
  double low = normal, high = student_quantile(0.975, 1.0);
  if (missed(low) <= 0.05) return std::numeric_limits<double>::infinity();
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (low + high);
    (missed(middle) > 0.05 ? low : high) = middle;
  }
  double few = 0.0, many = std::log(most);
  for (int i = 0; i < 20; ++i) {
    const double middle = 0.5 * (few + many);
    (student_quantile(0.975, std::exp(middle)) > high ? few : many) = middle;
  }
  return std::exp(0.5 * (few + many));
}

}  // namespace

LinearNoise linear(const BandData& data, const TriedTerms& chosen) {
  LinearNoise result;
  const MatrixXd x = columns(data, chosen.terms);
  Index column = 0;
  std::vector<Index> list;
  std::vector<VectorXd> slopes;
  for (std::size_t t = 0; t < power_laws; ++t) {
    if (!chosen.terms.used[t]) continue;
    if (chosen.fit.c[column] > 0.0) {
      list.push_back(column);
      result.terms.push_back(t);
    }
    ++column;
  }
  for (std::size_t m = 0; m < chosen.terms.times.size(); ++m, ++column) {
    list.push_back(column);
    result.terms.push_back(power_laws + m);
    result.processes.push_back(m);
    constexpr double h = 1e-3;
    const double time = chosen.terms.times[m];
    slopes.push_back(chosen.fit.c[column] * (data.markov(time * std::exp(h)) - data.markov(time * std::exp(-h))) /
                     (2.0 * h));
  }
  result.x.resize(x.rows(), at(list.size() + slopes.size()));
  result.x.leftCols(at(list.size())) = x(Eigen::all, list);
  for (std::size_t m = 0; m < slopes.size(); ++m) result.x.col(at(list.size() + m)) = slopes[m];
  return result;
}

std::vector<WeightedTerm> weighted_terms(const TriedTerms& chosen) {
  std::vector<WeightedTerm> terms;
  Index column = 0;
  for (std::size_t t = 0; t < power_laws; ++t)
    if (chosen.terms.used[t]) terms.push_back({{power_law_terms[t]}, chosen.fit.c[column++]});
  for (const double time : chosen.terms.times) terms.push_back({{NoiseTerm::markov, time}, chosen.fit.c[column++]});
  return terms;
}

NoiseSpread spread(const BandData& data, const VectorXd& statistical_count, const LinearNoise& model,
                   const TriedTerms& chosen) {
  const ScoringFit& fit = chosen.fit;
  const VectorXd weight = (0.5 * data.count).cwiseSqrt().cwiseQuotient(fit.s);
  const MatrixXd weighted = weight.asDiagonal() * model.x;
  const VectorXd scale = weighted.colwise().norm().cwiseInverse();
  const MatrixXd unit = weighted * scale.asDiagonal(), gram = unit.transpose() * unit;
  const MatrixXd inverse = gram.ldlt().solve(MatrixXd::Identity(gram.rows(), gram.cols()));
  NoiseSpread result;
  const MatrixXd independent = scale.asDiagonal() * inverse * scale.asDiagonal();
  // Weight of each contrast in the derivative.
  const VectorXd each = data.count.cwiseQuotient(statistical_count).cwiseQuotient(fit.s.cwiseAbs2());
  const MatrixXd more = covariance_of_dependence(data.bands, weighted_terms(chosen), each.asDiagonal() * model.x);
  result.covariance = independent + independent * more * independent;
  result.widening = (result.covariance.diagonal().array() / independent.diagonal().array()).sqrt();
  const MatrixXd gain = independent * weighted.transpose() * weight.asDiagonal();  // c = gain z
  const Eigen::ArrayXd s = fit.s.array(), error = 2.0 / data.count.array() - 2.0 / statistical_count.array();
  result.by_error = gain * (s.square() * error).matrix().asDiagonal() * gain.transpose();
  const VectorXd values = Eigen::SelfAdjointEigenSolver<MatrixXd>(gram).eigenvalues();
  result.condition = std::sqrt(values.maxCoeff() / std::max(values.minCoeff(), 1e-300));
  return result;
}

double interval_freedom(const BandData& data, const MatrixXd& x, const VectorXd& s, Index column, double squared,
                        double value, double sd, double widening) {
  return freedom_for([&](double t) {
    const double lower = value - t * sd;
    return chance_below(data, x, s, column, squared, std::pow(value + t * sd, 2), widening) +
           (lower > 0.0 ? 1.0 - chance_below(data, x, s, column, squared, lower * lower, widening) : 0.0);
  });
}

double time_freedom(double sd) {
  const auto below = [](double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); };
  return freedom_for([&](double t) {
    // Greatest share of the truth whose interval ends below it, and least whose interval starts above it.
    double low = 1e-3, high = 1.0;
    for (int i = 0; i < 30; ++i) {
      const double share = 0.5 * (low + high);
      (share + t * sd * std::pow(share, 1.5) < 1.0 ? low : high) = share;
    }
    const double starts = 4.0 / (9.0 * t * t * sd * sd);  // share - t sd share^1.5 is greatest here
    double above = 0.0;
    if (starts > 1.0 && starts - t * sd * std::pow(starts, 1.5) > 1.0) {
      double least = 1.0, most = starts;
      for (int i = 0; i < 30; ++i) {
        const double share = 0.5 * (least + most);
        (share - t * sd * std::pow(share, 1.5) < 1.0 ? least : most) = share;
      }
      above = below(-std::log(most) / sd);
    }
    return below(std::log(low) / sd) + above;
  });
}

double upper_limit(const BandData& data, const MatrixXd& others, const VectorXd& column, bool ramp,
                   const ScoringFit& free, double value, double sd) {
  const auto rise = [&](double c) {
    const VectorXd known = c * column;
    const VectorXd start = free.s + (c - value) * column;
    return fit_by_scoring(data, others, ramp, start.cwiseMax(free.s * 1e-3), &known).minus_twice_log_likelihood -
           free.minus_twice_log_likelihood;
  };
  double low = value, high = value + 1.645 * sd;
  for (int i = 0; i < 30 && rise(high) < 2.71; ++i) {
    low = high;
    high = value + 1.5 * (high - value);
  }
  for (int i = 0; i < 8; ++i) {
    const double middle = 0.5 * (low + high);
    (rise(middle) < 2.71 ? low : high) = middle;
  }
  return high;
}

}  // namespace tumble::noise_likelihood
