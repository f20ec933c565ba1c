#include "tumble/core/budget.hpp"

#include <algorithm>

namespace tumble {

void gather_small(Estimate& estimate) {
  constexpr double least_share = 1e-3;
  Contribution small{"all other errors", std::vector<double>(estimate.parameters.size(), 0.0)};
  std::size_t gathered = 0;
  std::erase_if(estimate.budget, [&](const Contribution& line) {
    double most = 0.0;
    for (std::size_t i = 0; i < line.variance.size(); ++i)
      most = std::max(most, line.variance[i] / estimate.covariance(i, i));
    if (most >= least_share) return false;
    for (std::size_t i = 0; i < line.variance.size(); ++i) small.variance[i] += line.variance[i];
    gathered += most > 0.0;
    return true;
  });
  if (gathered > 0) estimate.budget.push_back(std::move(small));
}

}  // namespace tumble
