#include "tumble/methods/frequency_response/average.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"

namespace tumble::frequency_response {
namespace {

/// Value and gradient over (log_gain, phase) by one model; weight 0: the model lacks it.
struct OfModel {
  double weight = 0.0, value = 0.0;
  std::vector<double> gradient;
};

double noise_variance(const Measured& m, std::size_t i) {
  const std::size_t n = m.frequency.size();
  return i < n ? m.log_gain_variance[i] : m.phase_variance[i - n];
}

}  // namespace

std::vector<Supported> supported(const std::vector<LoopFit>& fits) {
  constexpr double near = 10.0;  // of AICc
  double least_aicc = INFINITY, least = INFINITY, sum = 0.0;
  for (const LoopFit& fit : fits)
    if (fit.accepted) least_aicc = std::min(least_aicc, fit.aicc);
  std::vector<Supported> out;
  for (const LoopFit& fit : fits)
    if (fit.accepted && fit.aicc <= least_aicc + near) out.push_back({&fit, 0.0});
  for (const Supported& one : out) least = std::min(least, one.fit->chi_square);
  for (Supported& one : out) sum += one.weight = std::exp(-0.5 * (one.fit->chi_square - least));
  for (Supported& one : out) one.weight /= sum;
  return out;
}

Averaged averaged(const std::vector<Supported>& models, const Measured& measured,
                  const std::function<std::optional<Derived>(const LoopFit&)>& of) {
  const std::size_t rows = 2 * measured.frequency.size();
  std::vector<OfModel> all;
  double sum = 0.0;
  for (const Supported& model : models) {
    const auto derived = of(*model.fit);
    all.emplace_back();
    if (!derived) continue;
    all.back() = {model.weight, derived->value, transposed(model.fit->gain) * derived->gradient};
    sum += model.weight;
  }
  Averaged out{sum > 0.0, 0.0, std::vector<double>(rows), {}};
  for (OfModel& model : all) {
    if (model.weight == 0.0) continue;
    model.weight /= sum;
    out.value += model.weight * model.value;
    out.gradient = scaled_sum(out.gradient, model.weight, model.gradient);
  }
  for (const OfModel& model : all) {
    const double root = std::sqrt(model.weight);
    out.spread.push_back(root * (model.value - out.value));
    for (std::size_t i = 0; i < rows; ++i)
      out.spread.push_back(
          root == 0.0 ? 0.0 : root * (model.gradient[i] - out.gradient[i]) * std::sqrt(noise_variance(measured, i)));
  }
  return out;
}

}  // namespace tumble::frequency_response
