#include "tumble/methods/accelerometer_four_position/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/accelerometer_four_position/findings.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/reduce/pulses/rounding.hpp"
#include "tumble/units/error.hpp"

namespace tumble::accelerometer_four_position {
namespace {

/// How a quantity is named and shown.
struct Face {
  const char* name;
  const char* symbol;
  const char* letter;  ///< of its polynomial; null: it has none
  const char* unit;
  const char* fine;  ///< unit of the polynomial's coefficients, over K^j
  const char* description;
};

Face face_of(Quantity quantity, bool two, bool o_level) {
  switch (quantity) {
    case bias:
      return {
          "bias", two ? "nabla" : "K_0",
          "b",    "mg",
          "ug",   two ? "bias from positions 1 and 3: (K_0 + K_2 G^2)/(1 + K_3 G^2)" : "bias from positions 2 and 4"};
    case scale_factor_error:
      return {"scale_factor_error", "dK", "c", "ppm", "ppm", "K_m/K_i - 1, with K_i = K_1 (1 + K_3 G^2)"};
    case second_order:
      return {"second_order_coefficient",
              "K_2",
              nullptr,
              "ug/g^2",
              "ug/g^2",
              o_level ? "K_2 - K_oo: as 1 g shows it" : "K_2 - K_pp: as 1 g shows it"};
    default:
      return {"misalignment",
              o_level ? "theta_p" : "theta_t",
              nullptr,
              "arcsec",
              "arcsec",
              o_level ? "turn of the input axis about the pendulum axis, with the zero of the head"
                      : "turn of the input axis about the output (wire) axis, with the zero of the head"};
  }
}

const char* words_of(Quantity quantity) {
  switch (quantity) {
    case bias:
      return "bias";
    case scale_factor_error:
      return "scale factor error";
    case second_order:
      return "second-order coefficient";
    default:
      return "misalignment";
  }
}

Unit unit_of_power(const Face& face, std::size_t power) {
  if (power == 0) return Unit::parse(face.fine);
  return Unit::parse(fmt::format("{}/K{}", face.fine, power == 1 ? "" : "^" + std::to_string(power)));
}

/// One row of weights on the polynomials' coefficients for each parameter reported.
struct Reported {
  std::vector<Parameter> parameters;
  std::vector<std::vector<double>> weights;
};

void add_polynomial(const Reduced& reduced, Quantity quantity, const Face& face, double from, bool over_temperature,
                    Reported& out) {
  const Polynomial& p = reduced.polynomial[quantity];
  const std::size_t n = reduced.parameters.size();
  const auto add = [&](Parameter parameter, const std::vector<double>& weights) {
    for (std::size_t j = 0; j < n; ++j) parameter.value += weights[j] * reduced.parameters[j];
    out.parameters.push_back(std::move(parameter));
    out.weights.push_back(weights);
  };
  std::vector<double> weights(n, 0.0);
  const auto t = powers(from, p.count);
  for (std::size_t j = 0; j < p.count; ++j) weights[p.first + j] = t[j];
  const std::string where = face.letter && over_temperature ? ", at " + in_words(from) : "";
  add({face.name, face.symbol, Unit::parse(face.unit), 0.0, face.description + where}, weights);
  if (!face.letter || !over_temperature) return;
  for (std::size_t j = 0; j < p.count; ++j) {
    std::vector<double> unit(n, 0.0);
    unit[p.first + j] = 1.0;
    const std::string name = fmt::format("{}_{}", face.letter, j);
    add({name, name, unit_of_power(face, j), 0.0,
         fmt::format("{} per T^{}, T in degC", quantity == bias ? "bias" : "scale factor error", j)},
        unit);
  }
}

void fill_parameters(const Reduced& reduced, const Reported& reported, Estimate& estimate) {
  const std::size_t n = reported.parameters.size();
  estimate.parameters = reported.parameters;
  Matrix gradients(n, reduced.covariance.rows);
  for (std::size_t i = 0; i < n; ++i) {
    estimate.parameters[i].degrees_of_freedom = freedom_of(reduced, reported.weights[i]);
    for (std::size_t j = 0; j < gradients.columns; ++j) gradients(i, j) = reported.weights[i][j];
  }
  settle(estimate, carried(gradients, lines_of(reduced.sources)));
}

Table temperature_table(const Bench& bench, const Reduced& reduced) {
  const auto value = [&](Quantity q) { return [&, q](std::size_t c) { return reduced.cells[c].value[q]; }; };
  const auto sd = [&](Quantity q) { return [&, q](std::size_t c) { return reduced.cells[c].sd[q]; }; };
  const auto factor = [&](std::size_t c) {
    return bench.reference_scale_factor / (1.0 + reduced.cells[c].value[scale_factor_error]);
  };
  NumberedColumns columns{{"run", [&](std::size_t c) { return bench.cells[c].run; }},
                          {"temperature", "degC", [&](std::size_t c) { return bench.cells[c].temperature; }},
                          {"temperature_spread", "K", [&](std::size_t c) { return bench.cells[c].spread; }},
                          {"scale_factor", bench.output.scale_factor, factor},
                          {"scale_factor_error", "ppm", value(scale_factor_error)},
                          {"scale_factor_error_sd", "ppm", sd(scale_factor_error)},
                          {"bias", "mg", value(bias)},
                          {"bias_sd", "mg", sd(bias)}};
  if (reduced.active.size() > 2) {
    columns.emplace_back("second_order_coefficient", "ug/g^2", value(second_order));
    columns.emplace_back("second_order_coefficient_sd", "ug/g^2", sd(second_order));
    columns.emplace_back("misalignment", "arcsec", value(misalignment));
    columns.emplace_back("misalignment_sd", "arcsec", sd(misalignment));
  }
  return tabulate("temperatures", "one row for each set of positions: scale factor and bias by (3.5)",
                  bench.cells.size(), columns);
}

Table positions(const Bench& bench) {
  const auto place = [](const Position& p) {
    return p.place == Place::up ? 1 : p.place == Place::down ? 3 : p.upwards ? 2 : 4;
  };
  const auto noise = [&](const Position& p) {
    return std::sqrt(bench.white / p.seconds + pulses::rounding_variance(bench.pulse, p.seconds));
  };
  return tabulate("positions", "mean output of each position over the reference scale factor", bench.positions,
                  {{"label", &Position::label},
                   {"run", &Position::run},
                   {"position", place},
                   {"temperature", "degC", &Position::temperature},
                   {"duration", "s", &Position::seconds},
                   {"window", "s", [&](const Position& p) { return bench.evidence.test.stretches[p.stretch].step; }},
                   {"output", "g", &Position::output},
                   {"noise_sd", "g", noise}});
}

/// The polynomial over the temperatures of the test with its band, and the result of each set of positions.
void add_curves(const Bench& bench, const Reduced& reduced, Quantity quantity, const Face& face, Estimate& estimate) {
  constexpr std::size_t points = 60;
  const Polynomial& p = reduced.polynomial[quantity];
  const double low = bench.group_temperature.front(), high = bench.group_temperature.back();
  Curve line{.name = std::string(face.name) + "_fit",
             .figure = fmt::format("{} over temperature", words_of(quantity)),
             .x = {"temperature", Unit::parse("degC")},
             .y = {face.name, Unit::parse(face.unit)},
             .band = "95 % confidence"};
  Curve dots = line;
  dots.name = face.name;
  dots.points = true;
  const std::size_t n = reduced.parameters.size();
  for (std::size_t k = 0; k <= points; ++k) {
    const double t = low + (high - low) * static_cast<double>(k) / points;
    std::vector<double> weights(n, 0.0);
    const auto power = powers(t, p.count);
    for (std::size_t j = 0; j < p.count; ++j) weights[p.first + j] = power[j];
    add_point(line, t, at_temperature(reduced.parameters, p, t),
              student_quantile(two_sided_95, freedom_of(reduced, weights)) *
                  std::sqrt(std::max(0.0, quadratic_form(weights, reduced.covariance))));
  }
  for (std::size_t c = 0; c < bench.cells.size(); ++c)
    add_point(dots, bench.cells[c].temperature, reduced.cells[c].value[quantity],
              normal_two_sided_95 * reduced.cells[c].sd[quantity]);
  estimate.curves.push_back(std::move(line));
  estimate.curves.push_back(std::move(dots));
}

/// Each set of positions less the polynomial, over temperature, or one after the other where there is one temperature.
/// Sets that the polynomial must meet have no residual.
void add_residuals(const Bench& bench, const Reduced& reduced, Quantity quantity, const Face& face,
                   Estimate& estimate) {
  const Polynomial& p = reduced.polynomial[quantity];
  if (bench.cells.size() <= p.count) return;
  const bool over = bench.group_temperature.size() > 1;
  Curve dots{.name = face.name,
             .figure = fmt::format("residuals of the {}", words_of(quantity)),
             .x = {over ? "temperature" : "set of positions", over ? Unit::parse("degC") : Unit()},
             .y = {"residual", Unit::parse(face.unit)},
             .band = "2 sd of the output noise",
             .points = true};
  for (std::size_t c = 0; c < bench.cells.size(); ++c) {
    const double t = bench.cells[c].temperature;
    add_point(dots, over ? t : static_cast<double>(c + 1),
              reduced.cells[c].value[quantity] - at_temperature(reduced.parameters, p, t),
              2.0 * reduced.cells[c].noise_sd[quantity]);
  }
  estimate.curves.push_back(std::move(dots));
}

}  // namespace

std::size_t order_of(const Settings& settings, const Bench& bench) {
  const auto& word = settings.word("order");
  const std::size_t wanted = word == "auto" ? 2 : static_cast<std::size_t>(word[0] - '0');
  return std::min(wanted, bench.group_temperature.size() - 1);
}

Estimate described(const Bench& bench, const Reduced& reduced, const Settings& settings, bool measured) {
  Estimate estimate;
  const bool over = bench.group_temperature.size() > 1, two = reduced.active.size() == 2;
  const double low = bench.group_temperature.front(), high = bench.group_temperature.back();
  const double from = over ? std::clamp(settings.number("report_temperature"), low, high) : low;
  Reported reported;
  for (const Quantity quantity : reduced.active)
    add_polynomial(reduced, quantity, face_of(quantity, two, bench.cells.front().o_level), from, over, reported);
  fill_parameters(reduced, reported, estimate);
  estimate.fit = reduced.fit;
  if (measured) {
    estimate.tables = {temperature_table(bench, reduced), positions(bench)};
    if (over)
      for (const Quantity quantity : {bias, scale_factor_error})
        add_curves(bench, reduced, quantity, face_of(quantity, two, false), estimate);
    for (const Quantity quantity : reduced.active)
      add_residuals(bench, reduced, quantity, face_of(quantity, two, bench.cells.front().o_level), estimate);
  }
  estimate.findings = bench.findings;
  add_findings(bench, reduced, settings, measured, estimate.findings);
  return estimate;
}

}  // namespace tumble::accelerometer_four_position
