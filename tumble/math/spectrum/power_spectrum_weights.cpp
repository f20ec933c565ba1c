#include "tumble/math/spectrum/power_spectrum_weights.hpp"

#include <algorithm>
#include <cmath>

namespace tumble {
namespace {

constexpr int most_rounds = 100;
constexpr double settled = 1e-9;

}  // namespace

ByTaper adaptive_weights(const ByTaper& eigenspectra, const std::vector<double>& leaks, double level) {
  const std::size_t tapers = eigenspectra.size();
  ByTaper weights(tapers, std::vector<double>(eigenspectra[0].size(), 1.0 / static_cast<double>(tapers)));
  if (tapers == 1) return weights;
  std::vector<double> weight(tapers);
  for (std::size_t k = 0; k < eigenspectra[0].size(); ++k) {
    double density = 0.5 * (eigenspectra[0][k] + eigenspectra[1][k]);
    for (int round = 0; round < most_rounds && density > 0.0; ++round) {
      double sum = 0.0, next = 0.0;
      for (std::size_t a = 0; a < tapers; ++a) {
        const double lambda = 1.0 - leaks[a], b = density / (lambda * density + leaks[a] * level);
        weight[a] = lambda * b * b;
        sum += weight[a];
        next += weight[a] * eigenspectra[a][k];
      }
      next /= sum;
      for (std::size_t a = 0; a < tapers; ++a) weights[a][k] = weight[a] / sum;
      const bool done = std::abs(next - density) <= settled * density;
      density = next;
      if (done) break;
    }
  }
  return weights;
}

}  // namespace tumble
