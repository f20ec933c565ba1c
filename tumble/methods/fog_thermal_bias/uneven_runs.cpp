#include "tumble/methods/fog_thermal_bias/uneven_runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/noise/whitening.hpp"
#include "tumble/math/stability/allan_fit.hpp"

namespace tumble::fog_thermal_bias {
namespace {

constexpr double rare_shape = 1e-4;           ///< probability in a sound test, of all that is tried together
constexpr std::size_t fewest_for_shape = 12;  ///< averages of a run: fewer show no shape beside a level
constexpr std::size_t beside_shape = 3;       ///< averages on either side of a step
constexpr std::size_t most_steps = 64;        ///< of a run: a step between two of them is seen by both
constexpr double settling_shares[] = {20.0, 10.0, 5.0, 2.5};  ///< length of a run over the time constants tried

/// A shape that a run might have beside the model.
struct Shape {
  bool settles = false;
  double time = 0.0;  ///< [s] of the step since power-on, or time constant
  double size = 0.0;  ///< [rad/s]
  double chance = 1.0;
  int run = 0;
};

/// The columns: constant, shapes, residual; rows without data are zero.
Matrix design_of_shapes(const RunData& run, const std::vector<std::size_t>& columns,
                        const std::vector<double>& parameters, const std::vector<Shape>& shapes) {
  const std::size_t n = run.time.size(), last = shapes.size() + 1;
  Matrix design(n, shapes.size() + 2);
  for (std::size_t k = 0; k < n; ++k) {
    if (!(run.share[k] > 0.0)) continue;
    design(k, 0) = 1.0;
    for (std::size_t s = 0; s < shapes.size(); ++s)
      design(k, s + 1) = shapes[s].settles              ? std::exp(-run.time[k] / shapes[s].time)
                         : run.time[k] > shapes[s].time ? 1.0
                                                        : 0.0;
    design(k, last) = run.output[k] - run.start_output;
    for (std::size_t c = 0; c < columns.size(); ++c) design(k, last) -= parameters[c] * run.regressors(k, columns[c]);
  }
  return design;
}

std::vector<Shape> shapes_of(const RunData& run, double interval) {
  std::vector<Shape> shapes;
  const double length = run.time.back();
  const std::size_t stride = 1 + run.time.size() / most_steps;
  for (std::size_t k = beside_shape; k + beside_shape <= run.time.size(); k += stride)
    shapes.push_back({false, run.time[k] - 0.5 * interval});
  for (const double share : settling_shares) shapes.push_back({true, length / share});
  return shapes;
}

/// The most significant shape of one run.
Shape shape_of(const RunData& run, const Answer& answer, double interval) {
  auto shapes = shapes_of(run, interval);
  Matrix rows = design_of_shapes(run, answer.columns, answer.fit.parameters, shapes);
  Whitening(answer.noise, interval, run.time.back() + 0.5 * interval)(rows, run.share);
  const Matrix products = gram(rows);
  const std::size_t y = shapes.size() + 1;
  Shape best;
  for (std::size_t s = 0; s < shapes.size(); ++s) {
    const std::size_t x = s + 1;
    const double own = products(x, x) - products(0, x) * products(0, x) / products(0, 0);
    const double with = products(x, y) - products(0, x) * products(0, y) / products(0, 0);
    if (!(own > 1e-9 * products(x, x))) continue;
    const double square = with * with / own / answer.fit.inflation;
    const double chance = chi_square_tail(square, 1.0);
    if (chance >= best.chance) continue;
    best = shapes[s];
    best.size = with / own;
    best.chance = chance;
    best.run = run.number;
  }
  return best;
}

}  // namespace

Findings uneven_runs(const Answer& answer, double interval) {
  if (!std::isfinite(answer.noise.angle_random_walk) || !(answer.noise.angle_random_walk > 0.0)) return {};
  Shape worst;
  double tried = 0.0;
  for (const RunData& run : answer.runs) {
    const auto measured = std::ranges::count_if(run.share, [](double share) { return share > 0.0; });
    if (run.held_out || static_cast<std::size_t>(measured) < fewest_for_shape) continue;
    tried += static_cast<double>(shapes_of(run, interval).size());
    const Shape shape = shape_of(run, answer, interval);
    if (shape.chance < worst.chance) worst = shape;
  }
  const double chance = tried * worst.chance;
  if (chance >= rare_shape) return {};
  return {{Finding::Severity::warning,
           worst.settles ? "power_up_settles" : "power_up_steps",
           {{"size", worst.size, "deg/h"}, {"time", worst.time, "s"}, {"p", std::max(1e-6, chance)}},
           fmt::format("run {}", worst.run)}};
}

}  // namespace tumble::fog_thermal_bias
