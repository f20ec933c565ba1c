#include "tumble/math/noise/noise_likelihood/dependence.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "tumble/math/eigen/view.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::noise_likelihood {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int blocks_apart = 3, units_apart = 6;

/// The bands of one fast scale.
struct Scale {
  double unit = 1.0;
  int radix = 0;
  std::vector<Index> bands;  ///< rows
  MatrixXd cosines;          ///< one column a band
  double blocks = 0.0;
};

std::vector<Scale> scales_of(const std::vector<NoiseBand>& bands) {
  std::vector<Scale> scales;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const NoiseBand& band = bands[i];
    if (band.radix == 0) continue;
    if (scales.empty() || scales.back().unit != band.unit)
      scales.push_back({band.unit, band.radix, {}, {}, band.count});
    scales.back().bands.push_back(at(i));
  }
  for (Scale& scale : scales) {
    scale.cosines.resize(scale.radix, at(scale.bands.size()));
    for (std::size_t b = 0; b < scale.bands.size(); ++b)
      for (int i = 0; i < scale.radix; ++i)
        scale.cosines(i, at(b)) =
            std::sqrt(2.0 / scale.radix) *
            std::cos(pi * bands[static_cast<std::size_t>(scale.bands[b])].order * (i + 0.5) / scale.radix);
  }
  return scales;
}

/// Covariances of unit means at lags 0 .. most.
std::vector<double> lags_of(const std::vector<WeightedTerm>& terms, double unit, int most) {
  std::vector<double> covariances;
  for (int h = 0; h <= most; ++h) covariances.push_back(unit_mean_covariance(terms, unit, h));
  return covariances;
}

/// Sum over pairs (row k of the first, row j of the second) of w_t(k) w_u(j) squares(k, j).
MatrixXd weighed(const MatrixXd& first, const MatrixXd& squares, const MatrixXd& second) {
  return first.transpose() * squares * second;
}

MatrixXd within_scale(const Scale& scale, const std::vector<WeightedTerm>& terms, const MatrixXd& weights) {
  const int p = scale.radix;
  const auto gamma = lags_of(terms, scale.unit, p * (blocks_apart + 1));
  const MatrixXd own = weights(scale.bands, Eigen::all);
  MatrixXd sum = MatrixXd::Zero(weights.cols(), weights.cols());
  for (int h = 0; h <= blocks_apart; ++h) {
    MatrixXd toeplitz(p, p);
    for (int a = 0; a < p; ++a)
      for (int b = 0; b < p; ++b) toeplitz(a, b) = gamma[static_cast<std::size_t>(std::abs(h * p + b - a))];
    MatrixXd squares = (scale.cosines.transpose() * toeplitz * scale.cosines).array().square();
    if (h == 0) squares.diagonal().setZero();
    const MatrixXd one = weighed(own, squares, own);
    sum += h == 0 ? one : MatrixXd(one + one.transpose());
  }
  return scale.blocks * sum;
}

/// Covariance of each cosine of a block with the means of blocks `lag` away: one row a lag from -most on.
MatrixXd with_block_means(const Scale& scale, const std::vector<WeightedTerm>& terms, int most) {
  const int p = scale.radix;
  const auto gamma = lags_of(terms, scale.unit, p * (most + 1));
  MatrixXd result(2 * most + 1, scale.cosines.cols());
  for (int lag = -most; lag <= most; ++lag) {
    VectorXd mean(p);  // covariance of each unit of the block with the mean
    for (int a = 0; a < p; ++a) {
      double sum = 0.0;
      for (int b = 0; b < p; ++b) sum += gamma[static_cast<std::size_t>(std::abs(lag * p + b - a))];
      mean[a] = sum / p;
    }
    result.row(lag + most) = mean.transpose() * scale.cosines;
  }
  return result;
}

MatrixXd between_scales(const Scale& fast, const Scale& slow, const std::vector<WeightedTerm>& terms,
                        const MatrixXd& weights) {
  const int p = slow.radix, most = 2 * p;
  const MatrixXd means = with_block_means(fast, terms, most);
  MatrixXd squares = MatrixXd::Zero(fast.cosines.cols(), slow.cosines.cols());
  for (int h = -1; h <= 1; ++h)
    for (int q = 0; q < p; ++q)
      squares.array() += (means.middleRows(h * p - q + most, p).transpose() * slow.cosines).array().square();
  const MatrixXd one = weighed(weights(fast.bands, Eigen::all), squares, weights(slow.bands, Eigen::all));
  return slow.blocks * (one + one.transpose());
}

/// A cosine's covariance with differences of block means around it, as their sine transform sees it.
MatrixXd with_sines(const Scale& last, const std::vector<NoiseBand>& bands, const std::vector<WeightedTerm>& terms,
                    const MatrixXd& weights) {
  const MatrixXd means = with_block_means(last, terms, units_apart);
  const double unit = last.unit * last.radix;
  std::vector<Index> sines;
  for (std::size_t i = 0; i < bands.size(); ++i)
    if (bands[i].radix == 0 && bands[i].unit == unit) sines.push_back(at(i));
  MatrixXd squares(means.cols(), at(sines.size()));
  VectorXd counts(at(sines.size()));
  for (Index b = 0; b < squares.cols(); ++b) {
    const NoiseBand& band = bands[static_cast<std::size_t>(sines[static_cast<std::size_t>(b)])];
    counts[b] = band.count;
    const double w = 2.0 * pi * band.frequency * unit;
    for (Index k = 0; k < squares.rows(); ++k) {
      std::complex<double> sum = 0.0;
      for (Index j = 1; j < means.rows(); ++j)
        sum += (means(j, k) - means(j - 1, k)) * std::polar(1.0, w * static_cast<double>(j - units_apart));
      squares(k, b) = std::norm(sum);
    }
  }
  const MatrixXd one =
      weighed(weights(last.bands, Eigen::all), squares * counts.asDiagonal(), weights(sines, Eigen::all));
  return one + one.transpose();
}

/// Quantization leaves 4 c_Q sin(w) sin(w')/(u^2 (n + 1)) between sines that are both even or both odd.
MatrixXd of_ends(const std::vector<NoiseBand>& bands, const std::vector<WeightedTerm>& terms, const MatrixXd& weights) {
  const VectorXd part = variance_of_ends(bands, terms);
  VectorXd sum = VectorXd::Zero(weights.cols());
  MatrixXd same = MatrixXd::Zero(weights.cols(), weights.cols());
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const VectorXd w = part[at(i)] * weights.row(at(i)).transpose();
    sum += bands[i].count * w;
    same += bands[i].count * w * w.transpose();
  }
  return 0.5 * (sum * sum.transpose()) - same;
}

}  // namespace

double unit_mean_covariance(const std::vector<WeightedTerm>& terms, double unit, int lag) {
  double sum = 0.0;
  for (const auto& term : terms) {
    if (term.unit.term != NoiseTerm::markov) {
      sum += term.squared * unit_covariance(term.unit.term, unit, lag);
      continue;
    }
    const double r = unit / term.unit.markov_time, gone = -std::expm1(-r);
    sum += term.squared * (lag == 0 ? 2.0 * (r - gone) / (r * r) : std::exp(-(lag - 1) * r) * gone * gone / (r * r));
  }
  return sum;
}

VectorXd variance_of_ends(const std::vector<NoiseBand>& bands, const std::vector<WeightedTerm>& terms) {
  double quantization = 0.0;
  for (const auto& term : terms)
    if (term.unit.term == NoiseTerm::quantization) quantization = term.squared;
  VectorXd part = VectorXd::Zero(at(bands.size()));
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const NoiseBand& band = bands[i];
    if (band.radix > 0) continue;
    const double edge = std::sin(2.0 * pi * band.frequency * band.unit);
    part[at(i)] = 4.0 * quantization * band.shortness / (band.unit * band.unit) * edge * edge;
  }
  return part;
}

MatrixXd covariance_of_dependence(const std::vector<NoiseBand>& bands, const std::vector<WeightedTerm>& terms,
                                  const MatrixXd& weights) {
  const auto scales = scales_of(bands);
  MatrixXd sum = of_ends(bands, terms, weights);
  for (std::size_t i = 0; i < scales.size(); ++i) {
    sum += within_scale(scales[i], terms, weights);
    if (i + 1 < scales.size())
      sum += between_scales(scales[i], scales[i + 1], terms, weights);
    else
      sum += with_sines(scales[i], bands, terms, weights);
  }
  return 0.5 * sum;
}

}  // namespace tumble::noise_likelihood
