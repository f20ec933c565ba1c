#include "tumble/tasks/optimisation/criteria.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/eigen/dense.hpp"

namespace tumble::optimisation {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

std::size_t place(const Estimate& estimate, const std::string& term) {
  const auto found = std::ranges::find(estimate.parameters, term, &Parameter::name);
  return static_cast<std::size_t>(found - estimate.parameters.begin());
}

}  // namespace

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
  const auto p = static_cast<Eigen::Index>(terms.size());
  Eigen::MatrixXd scaled(p, p);
  for (Eigen::Index i = 0; i < p; ++i)
    for (Eigen::Index j = 0; j < p; ++j) {
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
      scaled(i, j) =
          estimate.covariance(place(estimate, terms[a]), place(estimate, terms[b])) / reference[a] / reference[b];
    }
  const Eigen::LLT<Eigen::MatrixXd> llt(scaled);
  const Eigen::MatrixXd lower = llt.matrixL();
  out.determinant = std::exp(lower.diagonal().array().log().sum() / static_cast<double>(p));
  out.trace = std::sqrt(scaled.trace() / static_cast<double>(p));
  out.worst = std::sqrt(scaled.diagonal().maxCoeff());
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
