#include "tumble/methods/polar_axis_tumble/harmonics.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::polar_axis_tumble {
namespace {

constexpr double most_inclined = 0.003;  ///< [1] of the Earth's rate across the axis: 0.17 deg off the Earth's

/// One sense of the output axis: specific force along it and in the plane of I and S [m/s^2].
struct Sense {
  double along = 0.0, across = 0.0;
  std::size_t segments = 0;
};

Felt at_angle(const Sense& sense, double angle) {
  Felt felt;
  felt.specific_force = {sense.across * std::sin(angle), sense.along, sense.across * std::cos(angle)};
  return felt;
}

/// The senses in the order in which they come.
std::vector<Sense> senses_of(const linear::Solution& solution) {
  std::vector<Sense> senses;
  for (const auto& segment : solution.segments) {
    const Vector3 f = segment.felt.specific_force;
    if (!segment.steady) continue;
    auto sense = std::ranges::find_if(senses, [&](const Sense& s) { return s.along * f.y > 0.0; });
    if (sense == senses.end()) sense = senses.insert(sense, Sense{});
    const double n = static_cast<double>(sense->segments++);
    sense->along += (f.y - sense->along) / (n + 1.0);
    sense->across += (std::hypot(f.x, f.z) - sense->across) / (n + 1.0);
  }
  return senses;
}

constexpr std::array<const char*, 5> names{"B0", "S1", "C1", "S2", "C2"};

double shape(std::size_t harmonic, double angle) {
  switch (harmonic) {
    case 0:
      return 1.0;
    case 1:
      return std::sin(angle);
    case 2:
      return std::cos(angle);
    case 3:
      return std::sin(2.0 * angle);
    default:
      return std::cos(2.0 * angle);
  }
}

/// Share of each harmonic in every column: its projection at eight angles, exact up to the third harmonic.
Matrix projections(const linear::Solution& solution, const Sense& sense) {
  Matrix out(names.size(), solution.columns.size());
  for (int k = 0; k < 8; ++k) {
    const double angle = pi * k / 4.0;
    const Felt felt = at_angle(sense, angle);
    for (std::size_t j = 0; j < out.columns; ++j) {
      const double value = solution.columns[j].regressor(felt);
      for (std::size_t h = 0; h < out.rows; ++h) out(h, j) += value * shape(h, angle) * (h == 0 ? 0.125 : 0.25);
    }
  }
  return out;
}

void add_curves(const linear::Solution& solution, const Sense& sense, const std::string& which, Estimate& estimate) {
  Curve model{.name = "model, " + which,
              .figure = "drift over angle",
              .x = {"angle", Unit::parse("deg")},
              .y = {"drift", Unit::parse("deg/h")}};
  Curve points = model;
  points.name = "measured, " + which;
  points.points = true;
  for (int k = 0; k <= 120; ++k) {
    const double angle = 2.0 * pi * k / 120.0;
    const Felt felt = at_angle(sense, angle);
    double value = 0.0;
    for (std::size_t j = 0; j < solution.columns.size(); ++j)
      value += solution.fit.parameters[j] * solution.columns[j].regressor(felt);
    add_point(model, angle, value);
  }
  estimate.curves.push_back(std::move(model));
  for (const auto& segment : solution.segments) {
    const Vector3 f = segment.felt.specific_force;
    if (!segment.steady || std::isnan(segment.measured) || f.y * sense.along <= 0.0) continue;
    add_point(points, std::fmod(std::atan2(f.x, f.z) + 2.0 * pi, 2.0 * pi), segment.measured - segment.felt.rate.x);
  }
  if (!points.x.values.empty()) estimate.curves.push_back(std::move(points));
}

void warn_of_another_axis(const linear::Solution& solution, Estimate& estimate) {
  double worst = 0.0, earth = 0.0;
  for (const auto& segment : solution.segments) {
    worst = std::max(worst, std::hypot(segment.felt.rate.x, segment.felt.rate.z));
    earth = std::max(earth, std::abs(segment.felt.rate.y));
  }
  if (worst > most_inclined * earth)
    estimate.findings.push_back(
        {Finding::Severity::warning, "axis_not_the_earths", {{"angle", std::atan2(worst, earth), "deg"}}});
}

}  // namespace

void name_combinations(const linear::Solution& solution, Estimate& estimate) {
  for (auto& parameter : estimate.parameters) {
    const auto meaning = solution.stands_for.find(parameter.name);
    if (meaning == solution.stands_for.end()) continue;
    parameter.symbol = meaning->second;
    parameter.name += meaning->second == "D_SS - D_II" ? "_minus_D_II" : "_sum";
  }
}

void add_harmonics(const linear::Solution& solution, Estimate& estimate) {
  const auto senses = senses_of(solution);
  const std::size_t p = solution.columns.size();
  Matrix l(p + names.size() * senses.size(), p);
  for (std::size_t j = 0; j < p; ++j) l(j, j) = 1.0;
  for (std::size_t s = 0; s < senses.size(); ++s) {
    const Matrix part = projections(solution, senses[s]);
    const std::string which = senses[s].along > 0.0 ? "O upwards" : "O downwards";
    for (std::size_t h = 0; h < names.size(); ++h) {
      std::vector<double> row(p);
      double value = 0.0;
      for (std::size_t j = 0; j < p; ++j) {
        l(p + s * names.size() + h, j) = row[j] = part(h, j);
        value += row[j] * solution.fit.parameters[j];
      }
      estimate.parameters.push_back({names[h] + std::string(s == 0 ? "" : "_reversed"),
                                     names[h] + std::string(s == 0 ? "" : "'"), Unit::parse("deg/h"), value,
                                     "harmonic of the drift over the angle, " + which,
                                     degrees_of_freedom(solution.fit, row)});
    }
    add_curves(solution, senses[s], which, estimate);
  }
  settle(estimate, carried(l, lines_of(solution.fit.sources)));
  warn_of_another_axis(solution, estimate);
}

}  // namespace tumble::polar_axis_tumble
