#include "tumble/math/noise/noise_likelihood/excess.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"

namespace tumble::noise_likelihood {
namespace {

constexpr double fewest_groups = 16.0, unusual = 4.0;

/// Variance of the sum of all powers over their means: of Gaussian noise with these terms.
double gaussian_variance(const std::vector<NoiseBand>& bands, const std::vector<WeightedTerm>& terms) {
  Matrix weights(bands.size(), 1);
  double contrasts = 0.0;
  for (std::size_t b = 0; b < bands.size(); ++b) {
    weights(b, 0) = 2.0 / bands[b].mean_square;
    contrasts += bands[b].count;
  }
  return 2.0 * contrasts + covariance_of_dependence(bands, terms, weights)(0, 0);
}

ExcessScatter excess_of(const PowerScatter& scatter, const std::vector<WeightedTerm>& terms) {
  ExcessScatter result;
  if (scatter.bands.empty()) return result;
  result.unit = scatter.bands[0].unit;
  double groups = 0.0, contrasts = 0.0, squares = 0.0;
  for (const auto& band : scatter.bands)
    if (!(band.mean_square > 0.0)) return result;
  for (const auto& group : scatter.groups) {
    if (group.contrasts == 0.0) continue;
    double q = 0.0;
    for (const auto& band : scatter.bands)
      q += group.square[static_cast<std::size_t>(band.order)] / band.mean_square - group.contrasts;
    squares += q * q;
    contrasts += group.contrasts * static_cast<double>(scatter.bands.size());
    ++groups;
  }
  if (groups < fewest_groups) return result;
  const double measured = squares * groups / (groups - 1.0), gaussian = gaussian_variance(scatter.bands, terms);
  // q of n contrasts has the kurtosis 12/n of a chi-square.
  const double sd = std::sqrt((2.0 + 12.0 * groups / contrasts) / groups);
  if (measured < gaussian * (1.0 + unusual * sd)) return result;
  result.relative = (measured - gaussian) / (contrasts * contrasts);
  result.ratio = std::sqrt(measured / gaussian);
  return result;
}

}  // namespace

std::vector<ExcessScatter> excess_scatter(const BandData& data, const std::vector<WeightedTerm>& terms) {
  std::vector<ExcessScatter> all;
  double before = 0.0;
  for (const auto& scatter : data.scatter) {
    all.push_back(excess_of(*scatter, terms));
    all.back().relative = before = std::max(all.back().relative, before);
  }
  return all;
}

Matrix covariance_of_excess(const BandData& data, const std::vector<ExcessScatter>& excess,
                            const std::vector<double>& count, const std::vector<double>& s, const Matrix& weights) {
  std::vector<double> common(s.size(), 0.0);
  for (std::size_t b = 0; b < s.size(); ++b) {
    const NoiseBand& band = data.bands[b];
    for (const ExcessScatter& one : excess)
      if (one.unit == band.unit) common[b] = std::sqrt(one.relative) * count[b] * s[b];
  }
  const auto v = transposed_product(weights, common);
  Matrix product(v.size(), v.size());
  add_square(product, 0.25, v);
  return product;
}

}  // namespace tumble::noise_likelihood
