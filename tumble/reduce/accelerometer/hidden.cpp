#include "tumble/reduce/accelerometer/hidden.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/eigen/dense.hpp"
#include "tumble/math/eigen/view.hpp"

namespace tumble::accelerometer {
namespace {

/// What a unit without its ppm, micro and arcsec comes to: 1/g for ug/g^2.
double power_of_g(const std::string& text) {
  const auto dimension = Unit::parse(text).dimension();
  for (const char* base : {"g", "1/g", "1/g^2"})
    if (Unit::parse(base).dimension() == dimension) return Unit::parse(base).factor();
  return 1.0;
}

/// " + 0.75 K_3": two digits are what the theory of evenly spaced positions has
std::string signed_share(double share, const std::string& symbol) {
  const double size = std::abs(share);
  const std::string factor = std::abs(size - 1.0) < 0.015 ? "" : fmt::format("{:.2g} ", size);
  return (share < 0.0 ? " - " : " + ") + factor + symbol;
}

/// K_2 of "stands for K_2 - K_pp"; what the column of dK_1 takes up multiplies K_1.
std::string meaning(const Term& kept, const std::string& shares) {
  return kept.name == "scale_factor" ? "K_1 (1" + shares + ")" : kept.symbol + shares;
}

std::string listed(const std::vector<std::string>& names) {
  if (names.size() < 2) return names.empty() ? "" : names.front();
  return fmt::format("{} and {}", fmt::join(names.begin(), names.end() - 1, ", "), names.back());
}

bool is_empty(const Dropped& dropped) {
  return std::ranges::all_of(dropped.weights, [](double w) { return w == 0.0; });
}

/// Those about columns left out are the last that the engine says.
void take_back_engines_words(linear::Solution& solution) {
  std::size_t said = 0;
  bool any_empty = false;
  for (const auto& dropped : solution.dropped) is_empty(dropped) ? void(any_empty = true) : void(++said);
  said += any_empty ? 1 : 0;
  solution.findings.resize(solution.findings.size() - std::min(said, solution.findings.size()));
}

}  // namespace

Shares shares_of(const Term& hidden, const linear::Solution& solution) {
  const auto n = at(solution.segments.size()), p = at(solution.columns.size());
  Eigen::MatrixXd x(n, p);
  Eigen::VectorXd y(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& segment = solution.segments[static_cast<std::size_t>(i)];
    const double root = std::sqrt(segment.duration);
    for (Eigen::Index j = 0; j < p; ++j)
      x(i, j) = root * solution.columns[static_cast<std::size_t>(j)].regressor(segment.felt);
    y[i] = root * hidden.regressor(segment.felt);
  }
  Eigen::VectorXd size = x.colwise().norm();
  for (auto& one : size)
    if (!(one > 0.0)) one = 1.0;
  const Eigen::VectorXd b = size.cwiseInverse().asDiagonal() *
                            Eigen::VectorXd((x * size.cwiseInverse().asDiagonal()).colPivHouseholderQr().solve(y));
  Shares out;
  out.left = y.norm() > 0.0 ? (y - x * b).norm() / y.norm() : 0.0;
  for (Eigen::Index j = 0; j < p; ++j) {
    const Term& kept = solution.columns[static_cast<std::size_t>(j)];
    const std::string unit = kept.name == "scale_factor" ? "1" : kept.unit;
    out.of.push_back({kept.name, b[j] * power_of_g(hidden.unit) / power_of_g(unit)});
  }
  return out;
}

std::string said(const Shares& shares, const Term& hidden) {
  std::vector<std::string> parts;
  for (const auto& [name, share] : shares.of)
    if (std::abs(share) > 0.02)
      parts.push_back(name == "scale_factor"
                          ? fmt::format("scale_factor by the factor 1{}", signed_share(share, hidden.symbol))
                          : fmt::format("{} by{}", name, signed_share(share, hidden.symbol)));
  return listed(parts);
}

void describe_dropped(Normalised& found, const std::string& advice) {
  auto& solution = found.solution;
  take_back_engines_words(solution);
  solution.stands_for.clear();
  std::map<std::string, std::string> taken_up;
  std::vector<std::string> empty;
  for (const auto& dropped : solution.dropped) {
    const Term& out = found.problem.columns[dropped.column];
    if (is_empty(dropped)) {
      empty.push_back(out.name);
      continue;
    }
    std::vector<std::string> meanings;
    std::size_t k = 0;  // of the column kept
    for (std::size_t j = 0; j < found.problem.columns.size(); ++j) {
      const bool kept = std::ranges::none_of(solution.dropped, [j](const Dropped& d) { return d.column == j; });
      if (!kept) continue;
      const Term& term = solution.columns[k++];
      if (dropped.weights[j] == 0.0) continue;
      const std::string unit = term.name == "scale_factor" ? "1" : term.unit;
      const auto share = signed_share(dropped.weights[j] * power_of_g(out.unit) / power_of_g(unit), out.symbol);
      taken_up[term.name] += share;
      meanings.push_back(fmt::format("{} stands for {}", term.name, meaning(term, share)));
    }
    solution.findings.push_back(
        {Finding::Severity::warning,
         fmt::format("{} ({}) cannot be told apart with these positions and is taken as zero: {}{}{}", out.name,
                     out.symbol, listed(meanings), advice.empty() ? "" : "; ", advice),
         ""});
  }
  for (const auto& term : solution.columns)
    if (taken_up.contains(term.name)) solution.stands_for[term.name] = meaning(term, taken_up[term.name]);
  if (empty.empty()) return;
  std::ranges::sort(empty);
  solution.findings.push_back(
      {Finding::Severity::info, fmt::format("no position shows {}: left out of the model", listed(empty)), ""});
}

void withhold(const std::string& name, Estimate& estimate) {
  const auto found = std::ranges::find(estimate.parameters, name, &Parameter::name);
  if (found == estimate.parameters.end()) return;
  const auto out = static_cast<std::size_t>(found - estimate.parameters.begin());
  const std::size_t p = estimate.parameters.size();
  Matrix covariance(p - 1, p - 1);
  for (std::size_t i = 0, a = 0; i < p; ++i) {
    if (i == out) continue;
    for (std::size_t j = 0, b = 0; j < p; ++j)
      if (j != out) covariance(a, b++) = estimate.covariance(i, j);
    ++a;
  }
  estimate.covariance = std::move(covariance);
  estimate.parameters.erase(found);
  for (auto& line : estimate.budget) line.variance.erase(line.variance.begin() + static_cast<std::ptrdiff_t>(out));
}

}  // namespace tumble::accelerometer
