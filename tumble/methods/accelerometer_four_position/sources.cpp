#include "tumble/methods/accelerometer_four_position/sources.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/methods/accelerometer_four_position/set_points.hpp"
#include "tumble/reduce/pulses/rounding.hpp"

namespace tumble::accelerometer_four_position {
namespace {

/// Output of the instrument minus the specific force by a first fit: one column with the coefficient 1.
Term model_of(const Bench& bench, const Stacked& all, const Design& design, const std::vector<double>& parameters) {
  const std::array<std::string, quantities> names{"bias", "scale_factor_error", "second_order_coefficient",
                                                  bench.cells.front().o_level ? "misalignment_p" : "misalignment_o"};
  std::vector<std::string> active;
  for (const auto quantity : all.active) active.push_back(names[quantity]);
  return {"model", "", "1", "",
          [=, terms = accelerometer::terms_of(active), quantity = all.active, blocks = design.blocks,
           input = bench.problem.input](const Felt& felt) {
            double inner = input(felt), scale = 1.0;
            for (std::size_t b = 0; b < blocks.size(); ++b) {
              const double value = at_temperature(parameters, blocks[b], felt.temperature);
              if (quantity[b] == scale_factor_error)
                scale = 1.0 / (1.0 + value);  // K = K_m/(1 + dK)
              else
                inner += value * terms[b].regressor(felt);
            }
            return scale * inner - input(felt);
          }};
}

}  // namespace

void add(std::vector<Source>& sources, const std::string& name, const Matrix& covariance) {
  const auto source =
      std::ranges::find_if(sources, [&](const Source& one) { return one.name == name && one.shifts.empty(); });
  if (source == sources.end())
    sources.push_back({name, covariance});
  else
    source->covariance += covariance;
}

Matrix sum_of(const std::vector<Source>& sources) {
  Matrix v = sources.front().covariance;
  for (std::size_t k = 1; k < sources.size(); ++k) v += sources[k].covariance;
  return v;
}

std::vector<Source> known_sources(const Bench& bench, const Stacked& all, const Design& design,
                                  const std::vector<double>& parameters) {
  std::vector<Source> sources;
  std::vector<double> noise(all.slope.columns), counting(all.slope.columns);
  for (const auto& position : bench.positions) {
    noise[position.stretch] = bench.white / position.seconds;
    counting[position.stretch] = pulses::rounding_variance(bench.pulse, position.seconds);
  }
  add(sources, "output noise", sandwich(all.slope, noise));
  if (bench.pulse > 0.0) add(sources, "counting", sandwich(all.slope, counting));
  linear::Problem problem = bench.problem;
  problem.columns = {model_of(bench, all, design, parameters)};
  for (const auto& effect : linear::effects_of(bench.evidence, problem, bench.rows, {1.0})) {
    std::vector<double> shift(all.slope.columns);
    for (std::size_t i = 0; i < effect.column.size(); ++i) shift[bench.rows.segment[i]] = effect.column[i];
    if (effect.each_segment) {
      add(sources, effect.source, sandwich(all.slope, scaled(shift, shift)));
      continue;
    }
    const auto moved = all.slope * shift;
    sources.push_back({effect.source, outer(moved, moved), as_column(moved), effect.key});
  }
  return sources;
}

namespace {

/// Shift [n] of Stacked::z where the temperature of each cell is off by what `error` [K] says.
template <class Error>
std::vector<double> shift_by_temperature(const Bench& bench, const Stacked& all, const Design& design,
                                         const std::vector<double>& centred, const Error& error) {
  std::vector<double> shift(all.z.size());
  for (std::size_t b = 0; b < all.active.size(); ++b)
    for (std::size_t c = 0; c < all.cells; ++c)
      for (std::size_t k = 1; k < design.blocks[b].count; ++k)
        shift[all.index(b, c)] += error(bench.cells[c]) * centred[design.blocks[b].first + k] * static_cast<double>(k) *
                                  std::pow(design.u(bench.cells[c].temperature), static_cast<double>(k - 1)) /
                                  design.half;
  return shift;
}

constexpr double usual_thermometer = 0.1;  ///< [K] of the offset of a thermometer where no rig states it

}  // namespace

void add_thermometer(const Bench& bench, const Stacked& all, const Design& design, const std::vector<double>& centred,
                     double sd, std::vector<Source>& sources) {
  const auto add_errors = [&](const char* name, const auto& error) {
    const auto shift = shift_by_temperature(bench, all, design, centred, error);
    add(sources, name, outer(shift, shift));
  };
  if (sd > 0.0) add_errors("thermometer", [&](const Cell&) { return sd; });
  const Settings& rig = bench.evidence.test.power_ups.front().plan->rig;
  const auto stated = [&](const char* name, double usual) { return rig.has(name) ? rig.number(name) : usual; };
  const double scale = scale_beside_set_points(bench, stated("thermometer_scale_sd", 0.0)), middle = design.centre;
  const double offset =
      offset_beside_set_points(bench, std::hypot(stated("thermometer_offset_sd", usual_thermometer), sd));
  constexpr const char* against = "thermometer against the set points";
  if (offset > 0.0) add_errors(against, [&](const Cell&) { return offset; });
  if (scale > 0.0) add_errors(against, [&](const Cell& cell) { return scale * (cell.temperature - middle); });
}

}  // namespace tumble::accelerometer_four_position
