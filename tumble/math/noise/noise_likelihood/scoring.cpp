#include "tumble/math/noise/noise_likelihood/scoring.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "tumble/math/eigen/view.hpp"

namespace tumble::noise_likelihood {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Power over that of white noise, averaged over frequencies within a factor of 2 either way.
VectorXd smoothed(const BandData& data) {
  const Index n = data.z.size();
  const VectorXd white = data.design.col(1);
  VectorXd s(n);
  for (Index i = 0; i < n; ++i) {
    const double f = data.bands[static_cast<std::size_t>(i)].frequency;
    double sum = 0.0, count = 0.0;
    for (Index j = 0; j < n; ++j) {
      const double ratio = data.bands[static_cast<std::size_t>(j)].frequency / f;
      if (ratio < 0.5 || ratio > 2.0) continue;
      sum += data.count[j] * data.z[j] / white[j];
      count += data.count[j];
    }
    s[i] = sum / count * white[i];
  }
  return s.cwiseMax(1e-12 * s.maxCoeff());
}

/// min 1/2 c'Gc - b'c for c >= 0: terms leave while they are negative and return while that pays.
VectorXd nonnegative(const MatrixXd& gram, const VectorXd& right) {
  const Index p = right.size();
  std::vector<bool> free(static_cast<std::size_t>(p), true);
  VectorXd c = VectorXd::Zero(p);
  for (int round = 0; round < 4 * static_cast<int>(p) + 4; ++round) {
    std::vector<Index> list;
    for (Index t = 0; t < p; ++t)
      if (free[static_cast<std::size_t>(t)]) list.push_back(t);
    c.setZero();
    if (!list.empty()) {
      const MatrixXd part = gram(list, list);
      const VectorXd solved = part.ldlt().solve(VectorXd(right(list)));
      c(list) = solved;
    }
    Index worst = 0;
    if (p > 0 && c.minCoeff(&worst) < 0.0) {
      free[static_cast<std::size_t>(worst)] = false;
      continue;
    }
    const VectorXd gradient = right - gram * c;
    Index best = -1;
    for (Index t = 0; t < p; ++t)
      if (!free[static_cast<std::size_t>(t)] && gradient[t] > 1e-9 && (best < 0 || gradient[t] > gradient[best]))
        best = t;
    if (best < 0) break;
    free[static_cast<std::size_t>(best)] = true;
  }
  return c.cwiseMax(0.0);
}

VectorXd about_ramp(const BandData& data, double slope) {
  return data.z.array() - 2.0 * slope * data.with_ramp.array() + slope * slope * data.ramp_square.array();
}

double minus_twice(const BandData& data, const VectorXd& s, bool ramp, RampFit& fitted) {
  if (!ramp) return (data.count.array() * (s.array().log() + data.z.array() / s.array())).sum();
  fitted = fit_ramp(data, s);
  return (data.count.array() * (s.array().log() + about_ramp(data, fitted.slope).array() / s.array())).sum() -
         std::log(fitted.variance);
}

VectorXd step(const BandData& data, const MatrixXd& x, const VectorXd& rest, const VectorXd& s) {
  const VectorXd weight = (0.5 * data.count).cwiseSqrt().cwiseQuotient(s);
  MatrixXd weighted = weight.asDiagonal() * x;
  const VectorXd scale = weighted.colwise().norm().cwiseInverse();
  weighted = weighted * scale.asDiagonal();
  const VectorXd c = nonnegative(weighted.transpose() * weighted, weighted.transpose() * weight.cwiseProduct(rest));
  return scale.cwiseProduct(c);
}

}  // namespace

BandData::BandData(const NoiseBands& from) : bands(from.bands) {
  const Index n = at(bands.size());
  z.resize(n);
  count.resize(n);
  with_ramp.resize(n);
  ramp_square.resize(n);
  slow.resize(n);
  design.resize(n, at(power_law_terms.size()));
  for (Index i = 0; i < n; ++i) {
    const NoiseBand& band = bands[static_cast<std::size_t>(i)];
    z[i] = band.mean_square;
    count[i] = band.count;
    with_ramp[i] = band.with_ramp;
    ramp_square[i] = band.ramp_square;
    slow[i] = band.radix == 0 ? 1.0 : 0.0;
    for (Index t = 0; t < design.cols(); ++t) design(i, t) = band.expected[static_cast<std::size_t>(t)];
  }
  start = smoothed(*this);
}

VectorXd BandData::markov(double time) const {
  VectorXd column(z.size());
  for (Index i = 0; i < column.size(); ++i) column[i] = expected_markov(bands[static_cast<std::size_t>(i)], time);
  return column;
}

RampFit fit_ramp(const BandData& data, const VectorXd& s) {
  const Eigen::ArrayXd weight = data.slow.array() * data.count.array() / s.array();
  const double variance = 1.0 / (weight * data.ramp_square.array()).sum();
  return {variance * (weight * data.with_ramp.array()).sum(), variance};
}

ScoringFit fit_by_scoring(const BandData& data, const MatrixXd& x, bool ramp, const VectorXd& start,
                          const VectorXd* known) {
  ScoringFit fit;
  fit.s = start;
  fit.c = VectorXd::Zero(x.cols());
  RampFit line;
  fit.minus_twice_log_likelihood = minus_twice(data, fit.s, ramp, line);
  const auto expectation = [&](const VectorXd& c) {
    VectorXd s = x * c;
    if (known != nullptr) s += *known;
    return s;
  };
  bool placed = false;  // whether s is that of c
  for (int iteration = 0; iteration < 60; ++iteration) {
    VectorXd rest = ramp ? VectorXd(about_ramp(data, line.slope) + line.variance * data.ramp_square) : data.z;
    if (known != nullptr) rest -= *known;
    const VectorXd to = step(data, x, rest, fit.s);
    double share = 1.0, likelihood = 0.0;
    VectorXd c, s;
    RampFit moved;
    for (int halving = 0; halving < 12; ++halving, share *= 0.5) {
      c = placed ? VectorXd(fit.c + share * (to - fit.c)) : to;
      s = expectation(c);
      likelihood = s.minCoeff() > 0.0 ? minus_twice(data, s, ramp, moved) : INFINITY;
      if (!placed || likelihood <= fit.minus_twice_log_likelihood + 1e-9) break;
    }
    const double fall = fit.minus_twice_log_likelihood - likelihood;
    if (placed && !(fall > -1e-9)) break;
    const bool settled = placed && fall < 1e-7;
    fit.c = c;
    fit.s = s.cwiseMax(1e-300);
    fit.minus_twice_log_likelihood = likelihood;
    line = moved;
    placed = true;
    if (settled) break;
  }
  if (ramp) line = fit_ramp(data, fit.s);
  fit.slope = ramp ? line.slope : 0.0;
  fit.slope_variance = ramp ? line.variance : 0.0;
  return fit;
}

}  // namespace tumble::noise_likelihood
