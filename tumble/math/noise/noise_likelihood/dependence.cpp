#include "tumble/math/noise/noise_likelihood/dependence.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/noise/noise_filter.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::noise_likelihood {
namespace {

constexpr int blocks_apart = 3, units_apart = 6;

/// The bands of one fast scale.
struct Scale {
  double unit = 1.0;
  int radix = 0;
  std::vector<std::size_t> bands;  ///< rows
  Matrix cosines;                  ///< one column a band
  double blocks = 0.0;
};

std::vector<Scale> scales_of(const std::vector<NoiseBand>& bands) {
  std::vector<Scale> scales;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const NoiseBand& band = bands[i];
    if (band.radix == 0) continue;
    if (scales.empty() || scales.back().unit != band.unit)
      scales.push_back({band.unit, band.radix, {}, {}, band.count});
    scales.back().bands.push_back(i);
  }
  for (Scale& scale : scales) {
    scale.cosines = Matrix(scale.radix, scale.bands.size());
    for (std::size_t b = 0; b < scale.bands.size(); ++b)
      for (int i = 0; i < scale.radix; ++i)
        scale.cosines(i, b) =
            std::sqrt(2.0 / scale.radix) * std::cos(pi * bands[scale.bands[b]].order * (i + 0.5) / scale.radix);
  }
  return scales;
}

/// Covariances of unit means at lags 0 .. most.
std::vector<double> lags_of(const std::vector<WeightedTerm>& terms, double unit, int most) {
  std::vector<double> covariances;
  for (int h = 0; h <= most; ++h) covariances.push_back(unit_mean_covariance(terms, unit, h));
  return covariances;
}

Matrix squared(Matrix a) {
  for (double& value : a.values) value *= value;
  return a;
}

/// Sum over pairs (row k of the first, row j of the second) of w_t(k) w_u(j) squares(k, j).
Matrix weighed(const Matrix& first, const Matrix& squares, const Matrix& second) {
  return transposed_product(first, squares * second);
}

Matrix with_transpose(const Matrix& a) { return a + transposed(a); }

Matrix within_scale(const Scale& scale, const std::vector<WeightedTerm>& terms, const Matrix& weights) {
  const int p = scale.radix;
  const auto gamma = lags_of(terms, scale.unit, p * (blocks_apart + 1));
  const Matrix own = chosen_rows(weights, scale.bands);
  Matrix sum(weights.columns, weights.columns);
  for (int h = 0; h <= blocks_apart; ++h) {
    Matrix toeplitz(p, p);
    for (int a = 0; a < p; ++a)
      for (int b = 0; b < p; ++b) toeplitz(a, b) = gamma[std::abs(h * p + b - a)];
    Matrix squares = squared(transposed_product(scale.cosines, toeplitz * scale.cosines));
    for (std::size_t i = 0; h == 0 && i < squares.rows; ++i) squares(i, i) = 0.0;
    const Matrix products = weighed(own, squares, own);
    sum += h == 0 ? products : with_transpose(products);
  }
  return scale.blocks * sum;
}

/// Covariance of each cosine of a block with the means of blocks `lag` away: one row a lag from -most on.
Matrix with_block_means(const Scale& scale, const std::vector<WeightedTerm>& terms, int most) {
  const int p = scale.radix;
  const auto gamma = lags_of(terms, scale.unit, p * (most + 1));
  Matrix means(2 * most + 1, p);  // covariance of each unit of the block with the means
  for (int lag = -most; lag <= most; ++lag)
    for (int a = 0; a < p; ++a)
      for (int b = 0; b < p; ++b) means(lag + most, a) += gamma[std::abs(lag * p + b - a)] / p;
  return means * scale.cosines;
}

Matrix between_scales(const Scale& fast, const Scale& slow, const std::vector<WeightedTerm>& terms,
                      const Matrix& weights) {
  const int p = slow.radix, most = 2 * p;
  const Matrix means = with_block_means(fast, terms, most);
  Matrix squares(fast.cosines.columns, slow.cosines.columns);
  for (int h = -1; h <= 1; ++h)
    for (int q = 0; q < p; ++q)
      squares += squared(transposed_product(block(means, h * p - q + most, p, 0, means.columns), slow.cosines));
  return slow.blocks *
         with_transpose(weighed(chosen_rows(weights, fast.bands), squares, chosen_rows(weights, slow.bands)));
}

/// What the differences of block means beyond those that were summed add for one Gauss-Markov process: they fall off as
/// exp(-t/T_c), so that the sums of both sides are geometric.
struct ProcessTails {
  Matrix ends;   ///< last difference before and after the block, for each cosine [2 x cosines]
  double decay;  ///< from one block to the next
};

std::vector<ProcessTails> tails_of(const Scale& last, const std::vector<WeightedTerm>& terms, double unit) {
  std::vector<ProcessTails> tails;
  for (const auto& term : terms) {
    if (term.unit.term != NoiseTerm::markov) continue;
    const Matrix means = with_block_means(last, {term}, units_apart);
    Matrix ends(2, means.columns);
    for (std::size_t k = 0; k < means.columns; ++k) {
      ends(0, k) = means(1, k) - means(0, k);
      ends(1, k) = means(means.rows - 1, k) - means(means.rows - 2, k);
    }
    tails.push_back({ends, std::exp(-unit / term.unit.markov_time)});
  }
  return tails;
}

/// A cosine's covariance with differences of block means around it, as their sine transform sees it.
Matrix with_sines(const Scale& last, const std::vector<NoiseBand>& bands, const std::vector<WeightedTerm>& terms,
                  const Matrix& weights) {
  const Matrix means = with_block_means(last, terms, units_apart);
  const double unit = last.unit * last.radix;
  const auto tails = tails_of(last, terms, unit);
  std::vector<std::size_t> sines;
  for (std::size_t i = 0; i < bands.size(); ++i)
    if (bands[i].radix == 0 && bands[i].unit == unit) sines.push_back(i);
  Matrix squares(means.columns, sines.size());
  for (std::size_t b = 0; b < sines.size(); ++b) {
    const NoiseBand& band = bands[sines[b]];
    const double w = 2.0 * pi * band.frequency * unit;
    for (std::size_t k = 0; k < means.columns; ++k) {
      std::complex<double> sum = 0.0;
      for (std::size_t j = 1; j < means.rows; ++j)
        sum += (means(j, k) - means(j - 1, k)) * std::polar(1.0, w * (static_cast<double>(j) - units_apart));
      for (const auto& [ends, decay] : tails) {
        const auto before = std::polar(decay, -w), after = std::polar(decay, w);
        sum += ends(0, k) * std::polar(1.0, w * (1.0 - units_apart)) * before / (1.0 - before);
        sum += ends(1, k) * std::polar(1.0, w * units_apart) * after / (1.0 - after);
      }
      squares(k, b) = std::norm(sum) * band.count;
    }
  }
  return with_transpose(weighed(chosen_rows(weights, last.bands), squares, chosen_rows(weights, sines)));
}

/// Quantization leaves 4 c_Q sin(w) sin(w')/(u^2 (n + 1)) between sines that are both even or both odd.
Matrix of_ends(const std::vector<NoiseBand>& bands, const std::vector<WeightedTerm>& terms, const Matrix& weights) {
  const auto part = variance_of_ends(bands, terms);
  std::vector<double> counts;
  for (const NoiseBand& band : bands) counts.push_back(band.count);
  const Matrix shares = scaled_rows(part, weights);
  Matrix product(weights.columns, weights.columns);
  add_square(product, 0.5, transposed_product(shares, counts));
  return product - gram(shares, counts);
}

}  // namespace

double unit_mean_covariance(const std::vector<WeightedTerm>& terms, double unit, int lag) {
  double sum = 0.0;
  for (const auto& term : terms) {
    if (term.unit.term == NoiseTerm::white) {
      sum += term.squared * mean_covariance(term.autocovariance, unit, lag);
      continue;
    }
    if (term.unit.term != NoiseTerm::markov) {
      sum += term.squared * unit_covariance(term.unit.term, unit, lag);
      continue;
    }
    const double r = unit / term.unit.markov_time, gone = -std::expm1(-r);
    sum += term.squared * (lag == 0 ? 2.0 * (r - gone) / (r * r) : std::exp(-(lag - 1) * r) * gone * gone / (r * r));
  }
  return sum;
}

std::vector<double> variance_of_ends(const std::vector<NoiseBand>& bands, const std::vector<WeightedTerm>& terms) {
  double quantization = 0.0;
  for (const auto& term : terms)
    if (term.unit.term == NoiseTerm::quantization) quantization = term.squared;
  std::vector<double> part(bands.size());
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const NoiseBand& band = bands[i];
    if (band.radix > 0) continue;
    const double edge = std::sin(2.0 * pi * band.frequency * band.unit);
    part[i] = 4.0 * quantization * band.shortness / (band.unit * band.unit) * edge * edge;
  }
  return part;
}

Matrix covariance_of_dependence(const std::vector<NoiseBand>& bands, const std::vector<WeightedTerm>& terms,
                                const Matrix& weights) {
  const auto scales = scales_of(bands);
  Matrix sum = of_ends(bands, terms, weights);
  for (std::size_t i = 0; i < scales.size(); ++i) {
    sum += within_scale(scales[i], terms, weights);
    sum += i + 1 < scales.size() ? between_scales(scales[i], scales[i + 1], terms, weights)
                                 : with_sines(scales[i], bands, terms, weights);
  }
  return 0.5 * sum;
}

}  // namespace tumble::noise_likelihood
