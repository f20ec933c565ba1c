#include "tumble/methods/accelerometer_four_position/sources.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "tumble/math/eigen/view.hpp"
#include "tumble/reduce/pulses/rounding.hpp"

namespace tumble::accelerometer_four_position {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// What the instrument shows beyond the specific force, as found so far: one column with the coefficient 1.
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

void add(std::vector<Source>& sources, const std::string& name, const MatrixXd& covariance) {
  const auto found = std::ranges::find(sources, name, &Source::name);
  if (found == sources.end())
    sources.push_back({name, covariance});
  else
    found->covariance += covariance;
}

MatrixXd sum_of(const std::vector<Source>& sources) {
  MatrixXd v = sources.front().covariance;
  for (std::size_t k = 1; k < sources.size(); ++k) v += sources[k].covariance;
  return v;
}

std::vector<Source> known_sources(const Bench& bench, const Stacked& all, const Design& design,
                                  const std::vector<double>& parameters) {
  std::vector<Source> sources;
  const Index stretches = all.slope.cols();
  VectorXd noise = VectorXd::Zero(stretches), counting = VectorXd::Zero(stretches);
  for (const auto& position : bench.positions) {
    noise[at(position.stretch)] = bench.white / position.seconds;
    counting[at(position.stretch)] = pulses::rounding_variance(bench.pulse, position.seconds);
  }
  add(sources, "output noise", all.slope * noise.asDiagonal() * all.slope.transpose());
  if (bench.pulse > 0.0) add(sources, "counting", all.slope * counting.asDiagonal() * all.slope.transpose());
  linear::Problem problem = bench.problem;
  problem.columns = {model_of(bench, all, design, parameters)};
  for (const auto& effect : linear::effects_of(bench.evidence, problem, bench.rows, {1.0})) {
    VectorXd shift = VectorXd::Zero(stretches);
    for (std::size_t i = 0; i < effect.column.size(); ++i) shift[at(bench.rows.segment[i])] = effect.column[i];
    const VectorXd moved = all.slope * shift;
    if (effect.each_segment)
      add(sources, effect.source, all.slope * shift.cwiseAbs2().asDiagonal() * all.slope.transpose());
    else
      add(sources, effect.source, moved * moved.transpose());
  }
  return sources;
}

void add_thermometer(const Bench& bench, const Stacked& all, const Design& design, const VectorXd& centred, double sd,
                     std::vector<Source>& sources) {
  if (!(sd > 0.0)) return;
  VectorXd shift = VectorXd::Zero(all.z.size());
  for (std::size_t b = 0; b < all.active.size(); ++b)
    for (std::size_t c = 0; c < all.cells; ++c)
      for (std::size_t k = 1; k < design.blocks[b].count; ++k)
        shift[all.index(b, c)] += sd * centred[at(design.blocks[b].first + k)] * static_cast<double>(k) *
                                  std::pow(design.u(bench.cells[c].temperature), static_cast<double>(k - 1)) /
                                  design.half;
  add(sources, "thermometer", shift * shift.transpose());
}

}  // namespace tumble::accelerometer_four_position
