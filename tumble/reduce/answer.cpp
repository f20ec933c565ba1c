#include "tumble/reduce/answer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/budget.hpp"
#include "tumble/math/symmetric_factor.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// Greatest remainder beside a factor: rounding of numbers that cancelled.
constexpr double rounding = 1e-9;

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix out(a.rows, b.columns);
  for (std::size_t c = 0; c < b.columns; ++c)
    for (std::size_t k = 0; k < a.columns; ++k) {
      if (b(k, c) == 0.0) continue;
      for (std::size_t i = 0; i < a.rows; ++i)
        if (a(i, k) != 0.0) out(i, c) += a(i, k) * b(k, c);
    }
  return out;
}

void add_columns(const Matrix& more, Matrix& factor) {
  factor.values.insert(factor.values.end(), more.values.begin(), more.values.end());
  factor.columns += more.columns;
}

/// Rows without a finite variance get a column of their own.
void split_endless(Matrix& covariance, Matrix& endless) {
  for (std::size_t i = 0; i < covariance.rows; ++i) {
    bool all_finite = true;
    for (std::size_t j = 0; j < covariance.rows; ++j) all_finite = all_finite && std::isfinite(covariance(i, j));
    if (all_finite) continue;
    Matrix column(covariance.rows, 1);
    column(i, 0) = std::sqrt(covariance(i, i));
    add_columns(column, endless);
    for (std::size_t j = 0; j < covariance.rows; ++j) covariance(i, j) = covariance(j, i) = 0.0;
  }
}

bool empty(const Contribution& line) {
  return std::ranges::all_of(line.factor.values, [](double v) { return v == 0.0; });
}

/// The line of the budget with this source and key, made where there is none.
Contribution& line_of(std::vector<Contribution>& budget, const std::string& source, const std::string& key,
                      std::size_t rows) {
  for (auto& line : budget)
    if (line.source == source && line.key == key) return line;
  return budget.emplace_back(Contribution{source, key, Matrix(rows, 0)});
}

/// Factors of one key are those of the same errors.
void add_same(const Matrix& factor, Contribution& line) {
  if (line.factor.columns == 0) {
    line.factor = factor;
    return;
  }
  if (line.factor.columns != factor.columns)
    throw Error(Error::Kind::internal,
                say("budget lines '{}' of key '{}' are not the same errors", line.source, line.key));
  for (std::size_t k = 0; k < factor.values.size(); ++k) line.factor.values[k] += factor.values[k];
}

void add_line(const std::string& source, const std::string& key, const Matrix& factor,
              std::vector<Contribution>& budget) {
  Contribution& line = line_of(budget, source, key, factor.rows);
  if (key.empty())
    add_columns(factor, line.factor);
  else
    add_same(factor, line);
}

std::vector<Contribution> budget_of(const std::vector<ErrorLine>& lines, std::size_t parameters) {
  std::vector<Contribution> budget;
  for (const auto& line : lines) {
    if (line.factor.rows != parameters)
      throw Error(Error::Kind::internal, say("budget line '{}' has not one row a parameter", line.source));
    add_line(line.source, line.key, line.factor, budget);
  }
  return budget;
}

/// Rows of zeros above and below.
Matrix padded(const Matrix& factor, std::size_t above, std::size_t below) {
  Matrix out(above + factor.rows + below, factor.columns);
  for (std::size_t c = 0; c < factor.columns; ++c)
    for (std::size_t i = 0; i < factor.rows; ++i) out(above + i, c) = factor(i, c);
  return out;
}

void complete(Estimate& estimate) {
  std::erase_if(estimate.budget, empty);
  for (auto& line : estimate.budget)
    if (line.key.empty()) line.factor = narrowed(std::move(line.factor));
  estimate.covariance = covariance_of(estimate.budget, estimate.parameters.size());
}

void set_degrees_of_freedom(const std::vector<ErrorLine>& lines, Estimate& estimate) {
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    double fourth = 0.0;
    for (const auto& line : lines) {
      if (line.degrees_of_freedom.empty() || !std::isfinite(line.degrees_of_freedom[i])) continue;
      double v = 0.0;
      for (std::size_t c = 0; c < line.factor.columns; ++c) v += line.factor(i, c) * line.factor(i, c);
      fourth += v * v / line.degrees_of_freedom[i];
    }
    const double variance = estimate.covariance(i, i);
    if (fourth > 0.0) estimate.parameters[i].degrees_of_freedom = std::max(1.0, variance * variance / fourth);
  }
}

template <class Item>
void follow(std::vector<Item>& sum, const std::vector<Item>& part) {
  sum.insert(sum.end(), part.begin(), part.end());
}

}  // namespace

ErrorLine from_shifts(std::string source, Matrix shifts, std::string key) {
  return {std::move(source), std::move(shifts), std::move(key), {}};
}

ErrorLine from_covariance(std::string source, const Matrix& covariance, const std::vector<double>& scale) {
  Matrix sound = covariance, endless(covariance.rows, 0);
  split_endless(sound, endless);
  auto [factor, excess] = symmetric_factor(sound, scale);
  if (excess > rounding)
    throw Error(
        Error::Kind::internal,
        say("the covariance of '{}' is not positive semidefinite: {:.2g} of its scale remains", source, excess));
  add_columns(endless, factor);
  return {std::move(source), std::move(factor), {}, {}};
}

ErrorLine from_gradients(std::string source, const Matrix& gradients, const Matrix& covariance) {
  return carried(gradients, from_covariance(std::move(source), covariance));
}

ErrorLine from_variances(std::string source, const std::vector<double>& variances) {
  Contribution line = independent_errors(std::move(source), variances);
  return {std::move(line.source), std::move(line.factor), {}, {}};
}

std::vector<ErrorLine> lines_of(const std::vector<SourceCovariance>& sources) {
  std::vector<ErrorLine> lines;
  std::vector<double> scale;
  for (const auto& source : sources) {
    scale.resize(source.covariance.rows, 0.0);
    for (std::size_t i = 0; i < scale.size(); ++i) scale[i] += std::max(0.0, source.covariance(i, i));
  }
  for (const auto& source : sources)
    lines.push_back(source.shifts.empty() ? from_covariance(source.source, source.covariance, scale)
                                          : from_shifts(source.source, source.shifts, source.key));
  return lines;
}

ErrorLine carried(const Matrix& gradients, ErrorLine inputs) {
  inputs.factor = product(gradients, inputs.factor);
  auto& dof = inputs.degrees_of_freedom;
  if (!dof.empty()) {
    const double first = dof.front();
    if (std::ranges::any_of(dof, [first](double v) { return v != first; }))
      throw Error(Error::Kind::internal,
                  say("budget line '{}' has inputs of several degrees of freedom", inputs.source));
    dof.assign(gradients.rows, first);
  }
  return inputs;
}

std::vector<ErrorLine> carried(const Matrix& gradients, std::vector<ErrorLine> inputs) {
  for (auto& line : inputs) line = carried(gradients, std::move(line));
  return inputs;
}

Matrix covariance_of(const std::vector<ErrorLine>& lines, std::size_t parameters) {
  return covariance_of(budget_of(lines, parameters), parameters);
}

void settle(Estimate& estimate, const std::vector<ErrorLine>& lines) {
  estimate.budget = budget_of(lines, estimate.parameters.size());
  complete(estimate);
  set_degrees_of_freedom(lines, estimate);
}

void append(Estimate& sum, const Estimate& part) {
  const std::size_t before = sum.parameters.size(), added = part.parameters.size();
  for (auto& line : sum.budget) line.factor = padded(line.factor, 0, added);
  for (const auto& line : part.budget) add_line(line.source, line.key, padded(line.factor, before, 0), sum.budget);
  follow(sum.parameters, part.parameters);
  complete(sum);
  sum.fit.observations += part.fit.observations;
  sum.fit.degrees_of_freedom += part.fit.degrees_of_freedom;
  sum.fit.chi_square += part.fit.chi_square;
  sum.fit.condition = std::max(sum.fit.condition, part.fit.condition);
  follow(sum.findings, part.findings);
  for (std::size_t f = sum.findings.size() - part.findings.size(); f < sum.findings.size(); ++f)
    for (std::size_t& index : sum.findings[f].about) index += before;
  follow(sum.tables, part.tables);
  follow(sum.curves, part.curves);
}

void append_parameter(Estimate& estimate, Parameter parameter, const std::string& source, double variance) {
  Estimate part;
  part.parameters = {std::move(parameter)};
  part.budget = {independent_errors(source, {variance})};
  append(estimate, part);
}

Estimate finished(Estimate estimate, const Findings& findings) {
  estimate.findings.insert(estimate.findings.begin(), findings.begin(), findings.end());
  return estimate;
}

void remove_parameter(Estimate& estimate, std::size_t index) {
  estimate.parameters.erase(estimate.parameters.begin() + static_cast<std::ptrdiff_t>(index));
  for (auto& line : estimate.budget) {
    Matrix rest(line.factor.rows - 1, line.factor.columns);
    for (std::size_t c = 0; c < rest.columns; ++c)
      for (std::size_t i = 0; i < rest.rows; ++i) rest(i, c) = line.factor(i < index ? i : i + 1, c);
    line.factor = std::move(rest);
  }
  complete(estimate);
  std::erase_if(estimate.findings, [index](const Finding& one) { return one.about == std::vector{index}; });
  for (Finding& finding : estimate.findings) {
    std::erase(finding.about, index);
    for (std::size_t& other : finding.about) other -= other > index ? 1 : 0;
  }
}

}  // namespace tumble
