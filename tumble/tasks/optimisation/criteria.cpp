#include "tumble/tasks/optimisation/criteria.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/linear_algebra.hpp"

namespace tumble::optimisation {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

std::size_t place(const Estimate& estimate, const std::string& term) {
  const auto found = std::ranges::find(estimate.parameters, term, &Parameter::name);
  return static_cast<std::size_t>(found - estimate.parameters.begin());
}

}  // namespace

const Estimate& with_prior_if_any(const Estimate& estimate) {
  return estimate.prior && estimate.prior->with_prior ? *estimate.prior->with_prior : estimate;
}

std::vector<double> sds_of(const Estimate& estimate, const std::vector<std::string>& terms) {
  std::vector<double> out;
  for (const auto& term : terms) {
    const auto i = place(estimate, term);
    out.push_back(i < estimate.parameters.size() ? std::sqrt(estimate.covariance(i, i)) : infinity);
  }
  return out;
}

Criteria criteria_of(const Estimate& estimate, const std::vector<std::string>& terms,
                     const std::vector<double>& reference) {
  Criteria out{sds_of(estimate, terms), infinity, infinity, infinity};
  if (std::ranges::any_of(out.sd, [](double sd) { return std::isinf(sd); })) return out;
  const std::size_t p = terms.size();
  Matrix scaled(p, p);
  double largest = 0.0;
  for (std::size_t i = 0; i < p; ++i) {
    for (std::size_t j = 0; j < p; ++j)
      scaled(i, j) =
          estimate.covariance(place(estimate, terms[i]), place(estimate, terms[j])) / reference[i] / reference[j];
    largest = std::max(largest, scaled(i, i));
  }
  out.determinant = std::exp(0.5 * cholesky(scaled).log_determinant / static_cast<double>(p));
  out.trace = std::sqrt(trace(scaled) / static_cast<double>(p));
  out.worst = std::sqrt(largest);
  return out;
}

std::vector<double> limit_widths(const Plan& plan, const Estimate& truth, const std::vector<std::string>& terms) {
  std::vector<double> out;
  for (const auto& term : terms) {
    double width = 0.0;
    const auto* parameter = find_parameter(truth, term);
    for (const auto& limit : plan.limits) {
      if (limit.parameter != term) continue;
      const auto si = [](const Quantity& q) { return q.unit.to_si(q.value); };
      if (limit.min && limit.max)
        width = 0.5 * (si(*limit.max) - si(*limit.min));
      else if (parameter)
        width = std::abs(si(limit.min ? *limit.min : *limit.max) - parameter->value);
    }
    out.push_back(width);
  }
  return out;
}

}  // namespace tumble::optimisation
