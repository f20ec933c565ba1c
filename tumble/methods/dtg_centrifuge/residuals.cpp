#include "tumble/methods/dtg_centrifuge/residuals.hpp"

#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/methods/dtg_centrifuge/levels.hpp"

namespace tumble::dtg_centrifuge {
namespace {

/// Standard deviation of one component of the mean of an observation, by the scatter of its parts; NaN: one part.
double noise_sd_of(const Observation& one) {
  double squares = 0.0, weight = 0.0, parts = 0.0;
  for (std::size_t k = 0; k < one.part.size(); ++k) {
    if (!(one.weight[k] > 0.0)) continue;
    squares += one.weight[k] * std::norm(one.part[k] - one.value);
    weight += one.weight[k];
    parts += 1.0;
  }
  return parts > 1.0 ? std::sqrt(squares / (2.0 * (parts - 1.0)) / weight) : std::nan("");
}

/// What the polynomial says of component c at a level, less what the level itself says; 0 without a polynomial.
double of_polynomial_less_level(const Outcome& outcome, const Levels& of, const Level& level, std::size_t index,
                                std::size_t c) {
  if (!outcome.corrected) return 0.0;
  const Polynomial& p = outcome.polynomial;
  const auto row = p.row(level);
  double value = 0.0;
  for (std::size_t k = 0; k < row.size(); ++k) value += row[k] * p.value[c * p.each() + k];
  return value - of.part(index, c).value;
}

}  // namespace

void add_residuals(const Outcome& outcome, const std::vector<Level>& levels, Estimate& estimate) {
  const Levels of(outcome, levels);
  const std::size_t parts = outcome.polynomial.parts;
  for (std::size_t c = 0; c < parts; ++c) {
    Curve curve{.name = parts == 1 ? "K"
                        : c == 0   ? "along X"
                                   : "along Y",
                .figure = "residuals of the sensitive term",
                .x = {"specific force", Unit::parse("g")},
                .y = {"residual", sensitivity()},
                .band = "2 sd of the output noise",
                .points = true};
    for (const Observation& o : outcome.observations) {
      const double seen = parts == 1 ? std::abs(o.value) : c == 0 ? o.value.real() : o.value.imag();
      const double residual = seen - outcome.levels.value[o.level * parts + c] -
                              of_polynomial_less_level(outcome, of, levels[o.level], o.level, c);
      add_point(curve, levels[o.level].force, residual, 2.0 * noise_sd_of(o));
    }
    estimate.curves.push_back(std::move(curve));
  }
}

}  // namespace tumble::dtg_centrifuge
