#include "tumble/math/noise/noise_likelihood/residuals.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/stability/model_error.hpp"

namespace tumble::noise_likelihood {
namespace {

constexpr double residual_count = 30.0;  ///< contrasts that make a residual

}  // namespace

std::vector<NoiseResidual> residuals_of(const BandData& data, const ScoringFit& fit) {
  std::vector<std::size_t> order(data.bands.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return data.bands[a].frequency < data.bands[b].frequency; });
  std::vector<NoiseResidual> residuals;
  double count = 0.0, ratio = 0.0, frequency = 0.0;
  for (const std::size_t b : order) {
    const double z = data.z[b] - 2.0 * fit.slope * data.with_ramp[b] + fit.slope * fit.slope * data.ramp_square[b] +
                     fit.slope_variance * data.ramp_square[b];
    count += data.count[b];
    ratio += data.count[b] * z / fit.s[b];
    frequency += data.count[b] * data.bands[b].frequency;
    if (count < residual_count) continue;
    residuals.push_back({frequency / count, ratio / count, std::sqrt(2.0 / count)});
    count = ratio = frequency = 0.0;
  }
  return residuals;
}

double chi_square(const std::vector<NoiseResidual>& residuals, double error) {
  double sum = 0.0;
  for (const auto& one : residuals) sum += std::pow(one.ratio - 1.0, 2) / (one.sd * one.sd + error * error);
  return sum;
}

double residual_freedom(const std::vector<NoiseResidual>& residuals, const TriedTerms& one, bool ramp) {
  return static_cast<double>(residuals.size()) - size_of(one.terms) - (ramp ? 1.0 : 0.0);
}

std::vector<double> counts_with(std::vector<double> count, double error) {
  for (double& n : count) n /= 1.0 + 0.5 * error * error * n;
  return count;
}

double model_error(const BandData& whole, bool ramp, const TriedTerms& full) {
  auto residuals = residuals_of(whole, full.fit);
  const double dof = residual_freedom(residuals, full, ramp);
  if (!has_model_error(chi_square(residuals, 0.0), dof)) return 0.0;
  BandData data = whole;
  return model_error_where([&](double error) {
    data.count = counts_with(whole.count, error);
    const auto left = residuals_of(whole, tried(data, full.terms, ramp, full.fit.s).fit);
    return chi_square(left, error) > dof;
  });
}

}  // namespace tumble::noise_likelihood
