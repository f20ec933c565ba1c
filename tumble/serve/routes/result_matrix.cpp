// Covariance and correlation of a result, for a page and for a spreadsheet.
#include <fmt/format.h>

#include <cmath>

#include "tumble/report/rounding.hpp"
#include "tumble/report/typeset.hpp"
#include "tumble/serve/routes/result_json.hpp"

namespace tumble::routes {
namespace {

constexpr std::size_t most_correlated = 60;

bool has_matrix(const Estimate& estimate) {
  const auto count = estimate.parameters.size();
  return count >= 2 && count <= most_correlated && estimate.covariance.rows >= count;
}

/// [1] NaN where one of both has no uncertainty.
double correlation_between(const Estimate& estimate, std::size_t i, std::size_t j) {
  const auto& v = estimate.covariance;
  const double of = std::sqrt(v(i, i) * v(j, j));
  if (i == j) return of > 0.0 && std::isfinite(of) ? 1.0 : std::nan("");
  return v(i, j) / of;
}

/// [unit of i times unit of j]
double covariance_between(const Estimate& estimate, std::size_t i, std::size_t j) {
  const auto &a = estimate.parameters[i].unit, &b = estimate.parameters[j].unit;
  return a.difference_from_si(b.difference_from_si(estimate.covariance(i, j)));
}

template <class Cell>
Json lower_triangle(const Estimate& estimate, Cell cell) {
  if (!has_matrix(estimate)) return nullptr;
  Json rows = Json::array();
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    Json row = Json::array();
    for (std::size_t j = 0; j <= i; ++j) row.push_back(cell(i, j));
    rows.push_back(row);
  }
  return rows;
}

/// Names have no comma, and no unit has a quotation mark.
std::string heading(const Parameter& parameter, bool unit) {
  return unit && parameter.unit.text() != "1" ? fmt::format("{}[{}]", parameter.name, parameter.unit.text())
                                              : parameter.name;
}

}  // namespace

Json correlation_json(const Estimate& estimate) {
  return lower_triangle(estimate, [&](std::size_t i, std::size_t j) {
    const double r = correlation_between(estimate, i, j);
    return std::isfinite(r) ? Json(std::round(1000.0 * r) / 1000.0) : Json();
  });
}

Json covariance_json(const Estimate& estimate) {
  return lower_triangle(estimate, [&](std::size_t i, std::size_t j) {
    const double v = covariance_between(estimate, i, j);
    return std::isfinite(v) ? Json(number_in_characters(general(v, 3))) : Json();
  });
}

std::string matrix_csv(const Estimate& estimate, bool correlation) {
  std::string text = correlation ? "correlation" : "covariance";
  for (const auto& parameter : estimate.parameters) text += "," + heading(parameter, !correlation);
  text += '\n';
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    text += heading(estimate.parameters[i], !correlation);
    for (std::size_t j = 0; j < estimate.parameters.size(); ++j) {
      const double value = correlation ? correlation_between(estimate, i, j) : covariance_between(estimate, i, j);
      text += std::isfinite(value) ? fmt::format(",{:.12g}", value) : ",";
    }
    text += '\n';
  }
  return text;
}

}  // namespace tumble::routes
