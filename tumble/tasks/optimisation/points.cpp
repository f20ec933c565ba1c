#include "tumble/tasks/optimisation/points.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tumble/math/linear_algebra.hpp"

namespace tumble::optimisation {
namespace {

constexpr double nothing = 1e-9;     ///< information, beside the largest of the point, that is rounding
constexpr double negligible = 1e-3;  ///< variance of a shift, beside that of the white noise of a power-up
constexpr double samples_in_period = 40.0;

double dwell_of(const prediction::Candidate& one, double dwell) { return std::max(dwell, one.least); }

/// Every candidate in a power-up of its own, in which it stands where it begins. The rate is as low as the motions
/// allow: what is known of the noise does not depend on it.
Plan plan_of(const Plan& plan, const std::vector<prediction::Candidate>& all, double settling, double dwell,
             double times) {
  Plan out = plan;
  out.schedule.clear();
  double fastest = 10.0 / dwell;
  for (std::size_t j = 0; j < all.size(); ++j) {
    const auto& one = all[j];
    const int run = static_cast<int>(j) + 1;
    if (!one.approach.empty()) out.schedule.push_back({"approach", 1.0, run, one.approach});
    const double spin_up = one.approach.empty() ? 0.0 : one.spin_up;
    out.schedule.push_back({"work", spin_up + settling + times * dwell_of(one, dwell), run, one.work});
    fastest = std::max(fastest, samples_in_period * one.fastest);
  }
  out.sample_rate = std::min(plan.sample_rate, fastest);
  return out;
}

/// The outputs' information of one segment in one matrix: terms of all outputs, then the errors they share.
void embed(const Matrix& m, std::size_t first_term, const std::vector<std::size_t>& error_at, Matrix& into) {
  const std::size_t columns = m.rows - error_at.size();
  const auto place = [&](std::size_t i) { return i < columns ? first_term + i : error_at[i - columns]; };
  for (std::size_t i = 0; i < m.rows; ++i)
    for (std::size_t j = 0; j < m.columns; ++j) into(place(i), place(j)) += m(i, j);
}

std::vector<Matrix> information_of(const Plan& plan, const std::vector<prediction::OutputProblem>& outputs,
                                   DesignSpace& space) {
  std::vector<TermInformation> parts;
  for (auto output : outputs) {
    output.problem.averaging = std::max(1.0 / plan.sample_rate, output.problem.averaging);
    parts.push_back(information_of_terms(plan, output.problem));
  }
  space.terms.clear();
  for (const auto& output : outputs)
    for (const auto& term : output.problem.columns) space.terms.push_back(term.name);
  for (const auto& part : parts)
    for (const auto& error : part.errors)
      if (std::ranges::find(space.errors, error) == space.errors.end()) space.errors.push_back(error);
  const std::size_t size = space.terms.size() + space.errors.size();
  std::vector<Matrix> out(plan.schedule.size(), Matrix(size, size));
  std::size_t first = 0;
  for (std::size_t o = 0; o < parts.size(); ++o) {
    std::vector<std::size_t> error_at;
    for (const auto& error : parts[o].errors)
      error_at.push_back(space.terms.size() +
                         static_cast<std::size_t>(std::ranges::find(space.errors, error) - space.errors.begin()));
    for (std::size_t s = 0; s < out.size(); ++s) embed(parts[o].of_segment[s], first, error_at, out[s]);
    first += outputs[o].problem.columns.size();
  }
  return out;
}

Matrix symmetric_part(const Matrix& m) { return 0.5 * (m + transposed(m)); }

/// The greatest eigenvalues, those above `least`, and their vectors.
SymmetricEigen above(const SymmetricEigen& all, double least) {
  const auto first = std::ranges::upper_bound(all.values, least) - all.values.begin();
  const auto count = all.values.size() - static_cast<std::size_t>(first);
  return {{all.values.begin() + first, all.values.end()},
          block(all.vectors, 0, all.vectors.rows, static_cast<std::size_t>(first), count)};
}

std::vector<double> roots(std::vector<double> values) {
  for (double& value : values) value = std::sqrt(value);
  return values;
}

/// N with N N' = m, m symmetric; what rounding made negative is nothing.
Matrix root(const Matrix& m, double least) {
  const SymmetricEigen eigen = above(eigen_symmetric(symmetric_part(m)), least);
  return scaled_columns(eigen.vectors, roots(eigen.values));
}

}  // namespace

// In the space that the point sees (basis U, scaled columns) the information is (P/d + K)^-1: two durations give P, of
// the white noise, and K, of what does not average. With P = L L':  X = L^-1 U',  N N' = L^-1 K L^-T.
DesignPoint point_of(const Matrix& at_once, const Matrix& at_twice, double dwell) {
  auto scale = roots(diagonal_of(at_twice));
  for (double& s : scale)
    if (!(s > 0.0)) s = 1.0;
  const auto unit = inverses(scale);
  const SymmetricEigen all = eigen_symmetric(scaled_columns(scaled_rows(unit, at_twice), unit));
  const SymmetricEigen eigen = above(all, all.values.empty() ? 0.0 : nothing * std::max(all.values.back(), 1e-300));
  DesignPoint point{Matrix(0, scale.size()), {}};
  if (eigen.values.empty()) return point;
  const Matrix half_once = scaled_columns(transposed(eigen.vectors), unit) * at_once;
  const Matrix first = inverse(scaled_columns(half_once, unit) * eigen.vectors);
  const Matrix second = diagonal(inverses(eigen.values));
  const Matrix white = symmetric_part(2.0 * dwell * (first - second));
  const Matrix basis = scaled_columns(transposed(eigen.vectors), scale);
  const Cholesky factor = cholesky(white);
  if (!factor.positive) {  // rounding: all of it is white noise
    point.rows = 1.0 / std::sqrt(2.0 * dwell) * scaled_rows(roots(eigen.values), basis);
    return point;
  }
  point.rows = solve_lower(factor.lower, basis);
  Matrix constant = second;
  for (std::size_t i = 0; i < constant.values.size(); ++i) constant.values[i] -= white.values[i] / (2.0 * dwell);
  const Matrix half = solve_lower(factor.lower, constant);
  Matrix disturbance = root(solve_lower(factor.lower, transposed(half)), nothing / dwell);
  if (disturbance.columns > 0) point.disturbance = std::move(disturbance);
  return point;
}

namespace {

/// Removes the errors that shift no output by more than a small part of the effect of white noise over a power-up.
void drop_negligible_errors(DesignSpace& space, std::vector<Matrix>& once, std::vector<Matrix>& twice, double time,
                            double dwell) {
  std::vector<std::size_t> places(space.terms.size());
  std::iota(places.begin(), places.end(), std::size_t{0});
  std::vector<std::string> errors;
  for (std::size_t e = 0; e < space.errors.size(); ++e) {
    const std::size_t at = space.terms.size() + e;
    double most = 0.0;
    for (const auto& m : twice) most = std::max(most, m(at, at));
    if (most * time / (2.0 * dwell) < negligible) continue;
    places.push_back(at);
    errors.push_back(space.errors[e]);
  }
  space.errors = std::move(errors);
  for (auto* list : {&once, &twice})
    for (auto& m : *list) m = chosen_rows(chosen_columns(m, places), places);
}

}  // namespace

DesignSpace design_space(const Plan& plan, const std::vector<prediction::Candidate>& all,
                         const std::vector<prediction::OutputProblem>& outputs, double time, double dwell) {
  DesignSpace space;
  const double settling = outputs.empty() ? 0.0 : outputs.front().problem.settling;
  const auto first = plan_of(plan, all, settling, dwell, 1.0), second = plan_of(plan, all, settling, dwell, 2.0);
  auto once = information_of(first, outputs, space), twice = information_of(second, outputs, space);
  drop_negligible_errors(space, once, twice, time, dwell);
  std::size_t segment = 0;
  for (const auto& one : all) {
    if (!one.approach.empty()) ++segment;
    auto point = point_of(once[segment], twice[segment], dwell_of(one, dwell));
    point.setup = one.setup + settling;
    point.least = one.least;
    space.points.push_back(std::move(point));
    ++segment;
  }
  return space;
}

}  // namespace tumble::optimisation
