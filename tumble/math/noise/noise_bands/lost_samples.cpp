#include "tumble/math/noise/noise_bands/lost_samples.hpp"

#include <cmath>

#include "tumble/math/noise/noise_bands/expected.hpp"
#include "tumble/math/noise/noise_filter.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

struct BlockPattern {
  std::vector<double> present;  ///< 1 or 0
  double count = 0.0;
};

BlockPattern pattern_of(unsigned mask, int radix) {
  BlockPattern pattern;
  for (int i = 0; i < radix; ++i) {
    pattern.present.push_back((mask >> i) & 1u ? 1.0 : 0.0);
    pattern.count += pattern.present.back();
  }
  return pattern;
}

/// Weights of cosine `order` on the values of a block: zero where one is missing, and adding up to zero.
std::vector<double> cosine_weights(const BlockPattern& pattern, int order) {
  const auto radix = static_cast<double>(pattern.present.size());
  std::vector<double> weights;
  double sum = 0.0;
  for (std::size_t i = 0; i < pattern.present.size(); ++i) {
    weights.push_back(pattern.present[i] * std::sqrt(2.0 / radix) *
                      std::cos(pi * order * (static_cast<double>(i) + 0.5) / radix));
    sum += weights.back();
  }
  for (std::size_t i = 0; i < weights.size(); ++i) weights[i] -= pattern.present[i] * sum / pattern.count;
  return weights;
}

void add_products(double times, const std::vector<double>& products, std::vector<double>& to) {
  for (std::size_t h = 0; h < to.size(); ++h) to[h] += times * products[h];
}

void divide(double by, std::vector<double>& values) {
  for (double& value : values) value /= by;
}

}  // namespace

std::vector<double> lag_products(const std::vector<double>& weights) {
  std::vector<double> products(weights.size(), 0.0);
  for (std::size_t h = 0; h < weights.size(); ++h)
    for (std::size_t i = 0; i + h < weights.size(); ++i) products[h] += weights[i] * weights[i + h];
  return products;
}

double over_lags(const std::vector<double>& products, const std::vector<double>& covariances) {
  double sum = products[0] * covariances[0];
  for (std::size_t h = 1; h < products.size(); ++h) sum += 2.0 * products[h] * covariances[h];
  return sum;
}

noise_bands::PatternsOfScale patterns_of(const ContrastSums& sums, int radix) {
  const auto p = static_cast<std::size_t>(radix);
  const double whole = sums.count;
  noise_bands::PatternsOfScale result;
  result.contrasts = whole;
  result.products.assign(p, std::vector<double>(p, 0.0));
  result.excess.assign(p, 0.0);
  for (int k = 1; k < radix; ++k) add_products(whole, cosine_products(radix, k), result.products[k]);
  const auto of_whole = lag_products(std::vector<double>(p, 1.0 / radix));
  double means = whole, shares = whole / radix;
  for (const auto& [mask, blocks] : sums.patterns.counts()) {
    const BlockPattern pattern = pattern_of(mask, radix);
    result.contrasts += blocks * (pattern.count - 1.0) / (radix - 1.0);
    for (int k = 1; k < radix; ++k) add_products(blocks, lag_products(cosine_weights(pattern, k)), result.products[k]);
    auto mean = pattern.present;
    divide(pattern.count, mean);
    auto excess = lag_products(mean);
    add_products(-1.0, of_whole, excess);
    add_products(blocks, excess, result.excess);
    means += blocks;
    shares += blocks / pattern.count;
  }
  for (auto& products : result.products) divide(std::max(result.contrasts, 1e-300), products);
  divide(std::max(means, 1.0), result.excess);
  result.share = shares / std::max(means, 1.0);
  return result;
}

std::shared_ptr<const LostSamples> lost_after(const std::shared_ptr<const LostSamples>& before,
                                              const noise_bands::PatternsOfScale& patterns, double unit) {
  LostSamples after;
  if (before != nullptr) after = *before;
  for (auto& scale : after.scales)
    for (double& product : scale.products) product *= patterns.share;
  after.scales.push_back({unit, patterns.excess});
  return std::make_shared<const LostSamples>(std::move(after));
}

double LostSamples::variance(NoiseTerm term) const {
  double sum = 0.0;
  for (const auto& scale : scales) {
    std::vector<double> covariances;
    for (std::size_t h = 0; h < scale.products.size(); ++h)
      covariances.push_back(unit_covariance(term, scale.unit, static_cast<int>(h)));
    sum += over_lags(scale.products, covariances);
  }
  return sum;
}

double LostSamples::markov_variance(double time) const {
  double sum = 0.0;
  for (const auto& scale : scales)
    sum += over_lags(scale.products, markov_below_variance(scale.unit, time, static_cast<int>(scale.products.size())));
  return sum;
}

double LostSamples::filtered_variance(std::span<const double> autocovariance) const {
  double sum = 0.0;
  for (const auto& scale : scales) {
    std::vector<double> covariances;
    for (std::size_t h = 0; h < scale.products.size(); ++h)
      covariances.push_back(mean_covariance(autocovariance, scale.unit, static_cast<int>(h)));
    sum += over_lags(scale.products, covariances);
  }
  return sum;
}

}  // namespace tumble
