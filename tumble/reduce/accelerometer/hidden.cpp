#include "tumble/reduce/accelerometer/hidden.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::accelerometer {
namespace {

constexpr double unit_share = 0.015;  ///< [1] within which a share of two digits is 1
constexpr double least_share = 0.02;  ///< [1] a smaller one is not stated

/// Factor of a unit without its ppm, micro and arcsec: 1/g for ug/g^2.
double power_of_g(const std::string& text) {
  const auto dimension = Unit::parse(text).dimension();
  for (const char* base : {"g", "1/g", "1/g^2"})
    if (Unit::parse(base).dimension() == dimension) return Unit::parse(base).factor();
  return 1.0;
}

/// " + 0.75 K_3": two digits are what the theory of evenly spaced positions has
std::string signed_share(double share, const std::string& symbol) {
  const double size = std::abs(share);
  const std::string factor = std::abs(size - 1.0) < unit_share ? "" : fmt::format("{:.2g} ", size);
  return (share < 0.0 ? " - " : " + ") + factor + symbol;
}

/// "K_2 - K_pp"; the part of the column dK_1 multiplies K_1.
std::string meaning(const Term& term, const std::string& shares) {
  return term.name == "scale_factor" ? "K_1 (1" + shares + ")" : term.symbol + shares;
}

bool is_empty(const Dropped& dropped) {
  return std::ranges::all_of(dropped.weights, [](double w) { return w == 0.0; });
}

double per_unit(const Term& hidden, const Term& term) {
  return power_of_g(hidden.unit) / power_of_g(term.name == "scale_factor" ? "1" : term.unit);
}

}  // namespace

Shares shares_of(const Term& hidden, const linear::Solution& solution) {
  Matrix x(solution.segments.size(), solution.columns.size());
  std::vector<double> y;
  for (std::size_t i = 0; i < x.rows; ++i) {
    const auto& segment = solution.segments[i];
    const double root = std::sqrt(segment.duration);
    for (std::size_t j = 0; j < x.columns; ++j) x(i, j) = root * solution.columns[j].regressor(segment.felt);
    y.push_back(root * hidden.regressor(segment.felt));
  }
  const auto [unit, size] = with_unit_columns(std::move(x));
  const QrFit fit = qr_fit(unit, y);
  Shares out;
  if (const double length = norm(y); length > 0.0) out.unexplained = std::sqrt(fit.residual_square) / length;
  for (std::size_t j = 0; j < unit.columns; ++j) {
    const Term& term = solution.columns[j];
    out.of.push_back({term.name, fit.x[j] / size[j] * per_unit(hidden, term), fit.x[j] / size[j]});
  }
  return out;
}

std::pair<Matrix, std::vector<double>> with_unit_columns(Matrix x) {
  auto size = column_norms(x);
  for (double& length : size)
    if (!(length > 0.0)) length = 1.0;
  return {scaled_columns(std::move(x), inverses(size)), size};
}

std::string meanings(const Shares& shares, const Term& hidden) {
  std::vector<std::string> parts;
  for (const auto& [name, share, weight] : shares.of) {
    if (std::abs(share) < least_share) continue;
    const auto term = signed_share(share, hidden.symbol);
    parts.push_back(name == "scale_factor" ? "scale_factor (1" + term + ")" : name + term);
  }
  return joined(parts);
}

void state_contained(const Shares& shares, const Term& hidden, double scale_factor, Estimate& estimate) {
  constexpr double rounding = 1e-6;
  if (shares.unexplained > rounding) return;
  for (const auto& [name, share, weight] : shares.of)
    for (auto& parameter : estimate.parameters)
      if (parameter.name == name && std::abs(share) > rounding)
        parameter.contains.push_back(
            {hidden.name, Unit::parse(hidden.unit), weight * (name == "scale_factor" ? scale_factor : 1.0)});
}

namespace {

/// Adds a dropped term to what the terms that are used contain, and to the `absorbed` of each; the finding of it.
Finding absorb(const Dropped& dropped, const std::string& advice, Normalised& fit,
               std::map<std::string, std::string>& absorbed) {
  auto& solution = fit.solution;
  const Term& out = fit.problem.columns[dropped.column];
  std::vector<std::string> others, meanings;
  std::size_t k = 0;  // of the column used
  for (std::size_t j = 0; j < fit.problem.columns.size(); ++j) {
    if (std::ranges::find(solution.dropped, j, &Dropped::column) != solution.dropped.end()) continue;
    const Term& term = solution.columns[k++];
    if (dropped.weights[j] == 0.0) continue;
    const auto share = signed_share(dropped.weights[j] * per_unit(out, term), out.symbol);
    absorbed[term.name] += share;
    // the column of the scale factor is multiplied by it
    const double size = term.name == "scale_factor" ? fit.scale_factor : 1.0;
    solution.contains[term.name].push_back({out.name, Unit::parse(out.unit), size * dropped.weights[j]});
    others.push_back(term.name);
    meanings.push_back(meaning(term, share));
  }
  return {linear::severity_of(dropped, solution),
          "not_distinguished",
          {{"term", fmt::format("{} ({})", out.name, out.symbol)},
           {"others", joined(others)},
           {"meanings", joined(meanings)},
           {"advice", Phrase{advice}}}};
}

}  // namespace

void describe_dropped(Normalised& fit, const std::string& advice) {
  auto& solution = fit.solution;
  std::erase_if(solution.findings, [](const Finding& finding) {
    return finding.code == "not_distinguished" || finding.code == "not_shown";
  });
  solution.stands_for.clear();
  solution.contains.clear();
  std::map<std::string, std::string> absorbed;
  std::vector<std::string> empty;
  for (const auto& dropped : solution.dropped) {
    const Term& out = fit.problem.columns[dropped.column];
    if (is_empty(dropped)) {
      empty.push_back(out.name);
      continue;
    }
    solution.findings.push_back(absorb(dropped, advice, fit, absorbed));
  }
  for (const auto& term : solution.columns)
    if (absorbed.contains(term.name)) solution.stands_for[term.name] = meaning(term, absorbed[term.name]);
  if (empty.empty()) return;
  std::ranges::sort(empty);
  solution.findings.push_back(
      {Finding::Severity::info, "not_shown", {{"terms", joined(empty)}}, "", {empty.size(), empty.front(), {}}});
}

void withhold(const std::string& name, Estimate& estimate) {
  const Parameter* parameter = find_parameter(estimate, name);
  if (parameter) remove_parameter(estimate, static_cast<std::size_t>(parameter - estimate.parameters.data()));
}

}  // namespace tumble::accelerometer
