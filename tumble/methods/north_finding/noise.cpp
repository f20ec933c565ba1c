#include "tumble/methods/north_finding/noise.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/eigen/dense.hpp"
#include "tumble/math/eigen/view.hpp"
#include "tumble/sim/power_up.hpp"
#include "tumble/units/error.hpp"

namespace tumble::north_finding {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// What a unit field along x and y of the base gives.
std::pair<double, double> seen_of(const Row& row) {
  double x = 0.0, y = 0.0;
  for (const auto& view : row.views) {
    const Vector3 axis = row.channel == accelerometer_y ? view.turn.y : view.turn.x;
    x += view.weight * axis.x;
    y += view.weight * axis.y;
  }
  return {x, y};
}

double spin_of(const Row& row) {
  double sum = 0.0;
  for (const auto& view : row.views) sum += view.weight * view.spin.z;
  return sum;
}

/// Whether the table turns at several rates: gamma_z then shows apart from the bias.
bool several_spins(const Signal& signal) {
  double low = INFINITY, high = -INFINITY;
  for (const auto& row : signal.rows) {
    low = std::min(low, spin_of(row));
    high = std::max(high, spin_of(row));
  }
  return high - low > 1e-6;
}

std::vector<std::vector<double>> columns_of(const Signal& signal, const Shown& shown, bool drift) {
  std::vector<std::vector<double>> columns(shown.both ? 2 : shown.none ? 0 : 1);
  std::vector<double> ones, times, spins;
  for (const auto& row : signal.rows) {
    const auto [x, y] = seen_of(row);
    if (shown.both) {
      columns[0].push_back(x);
      columns[1].push_back(y);
    } else if (!shown.none) {
      columns[0].push_back(std::cos(shown.along) * x + std::sin(shown.along) * y);
    }
    ones.push_back(1.0);
    times.push_back(row.time);
    spins.push_back(spin_of(row));
  }
  columns.push_back(ones);
  if (signal.channel != gyro) return columns;
  if (drift) columns.push_back(times);
  if (several_spins(signal)) columns.push_back(spins);
  return columns;
}

MatrixXd matrix_of(const std::vector<std::vector<double>>& columns) {
  MatrixXd out(at(columns.front().size()), at(columns.size()));
  for (std::size_t j = 0; j < columns.size(); ++j)
    for (std::size_t i = 0; i < columns[j].size(); ++i) out(at(i), at(j)) = columns[j][i];
  return out;
}

/// What is left of `x` beyond the columns of `basis`.
MatrixXd beyond(const MatrixXd& basis, const MatrixXd& x) {
  const MatrixXd scaled = basis * basis.colwise().norm().cwiseMax(1e-300).cwiseInverse().asDiagonal();
  return x - scaled * scaled.colPivHouseholderQr().solve(x);
}

std::vector<linear::Interval> intervals_of(const Signal& signal) {
  std::vector<linear::Interval> out;
  for (const auto& place : signal.places) out.push_back(place.interval);
  return out;
}

double step_of(const Signal& signal) { return signal.evidence.test.stretches.front().step; }

/// What the settings say of the bias instability of a signal, as its output shows it; 0: nothing.
double stated_for(const Bench& bench, const Signal& signal, const State& state) {
  std::vector<std::string> problems;
  const double stated = linear::stated_bias_instability(bench.plan->settings,
                                                        signal.channel == gyro ? "gyro_" : "accelerometer_", problems);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return stated * std::abs(state[scale_of(signal.channel)]);
}

/// Blocks as the mixed model takes them.
MixedData blocks_of(const Signal& signal, const Shown& shown, bool drift) {
  const auto columns = columns_of(signal, shown, drift);
  MixedData data;
  std::vector<std::size_t> rows;
  for (std::size_t b = 0; b < signal.row_of.size(); ++b) {
    if (signal.row_of[b] == npos) continue;
    rows.push_back(signal.row_of[b]);
    data.observations.push_back(signal.blocks.output[b]);
    data.weights.push_back(signal.blocks.weights[b]);
    data.segment.push_back(signal.rows[rows.back()].place);
  }
  data.design = Matrix(rows.size(), columns.size());
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = 0; j < columns.size(); ++j) data.design(i, j) = columns[j][rows[i]];
  return data;
}

std::vector<double> on_blocks(const Signal& signal, const std::vector<double>& of_rows) {
  std::vector<double> out;
  for (const std::size_t row : signal.row_of)
    if (row != npos) out.push_back(of_rows[row]);
  return out;
}

void add_effects(const Signal& signal, std::size_t number, const State& state,
                 const std::vector<Disturbance>& disturbances, MixedData& data) {
  for (const auto& one : disturbances) {
    if (one.moves[number].empty()) continue;
    data.effects.push_back({one.source, on_blocks(signal, effect_of(signal, one.moves[number], state)), false});
  }
  KnownEffect rounding{"counting", {}, true};
  for (const std::size_t row : signal.row_of)
    if (row != npos) rounding.column.push_back(signal.rows[row].rounding_sd);
  if (signal.problem.pulse > 0.0) data.effects.push_back(std::move(rounding));
}

/// Rounding to whole pulses is part of the scatter of a turn's blocks, but cancels from block to block. No less is left
/// than twice what the scatter is known to.
double without_rounding(const Signal& signal, double white) {
  double rounding = 0.0, blocks = 0.0;
  for (const std::size_t row : signal.row_of) {
    if (row == npos) continue;
    const double sd = signal.rows[row].reading_sd;
    rounding += 2.0 * sd * sd * signal.rows[row].seconds;
    blocks += 1.0;
  }
  if (!(rounding > 0.0)) return white;
  return std::max(white - rounding / blocks, std::min(1.0, 2.0 * std::sqrt(2.0 / blocks)) * white);
}

double place_sd(const std::vector<SlowNoise>& slow) {
  double sum = 0.0;
  for (const auto& one : slow) {
    if (one.source != linear::drift_source) continue;
    for (std::size_t g = 0; g < one.kernel.rows; ++g)
      sum += one.variance * one.kernel(g, g) / static_cast<double>(one.kernel.rows);
  }
  return std::sqrt(sum);
}

}  // namespace

Shown shown_by(const Signal& signal) {
  Shown shown;
  MatrixXd field(at(signal.rows.size()), 2);
  std::vector<double> times;
  for (std::size_t i = 0; i < signal.rows.size(); ++i) {
    std::tie(field(at(i), 0), field(at(i), 1)) = seen_of(signal.rows[i]);
    times.push_back(signal.rows[i].time);
  }
  const auto n = static_cast<double>(signal.rows.size());
  MatrixXd rest = MatrixXd::Ones(field.rows(), several_spins(signal) && signal.channel == gyro ? 2 : 1);
  if (rest.cols() == 2)
    for (std::size_t i = 0; i < signal.rows.size(); ++i) rest(at(i), 1) = spin_of(signal.rows[i]);
  const auto strength = [&](const MatrixXd& basis) {
    const MatrixXd left = beyond(basis, field);
    return Eigen::SelfAdjointEigenSolver<MatrixXd>(left.transpose() * left / n);
  };
  constexpr double least = 1e-6;  // squared: a thousandth of a full turn's share
  const auto solver = strength(rest);
  shown.none = solver.eigenvalues()[1] < least;
  shown.both = solver.eigenvalues()[0] > least;
  shown.along = std::atan2(solver.eigenvectors()(1, 1), solver.eigenvectors()(0, 1));
  MatrixXd with_time(field.rows(), rest.cols() + 1);
  with_time.leftCols(rest.cols()) = rest;
  for (std::size_t i = 0; i < times.size(); ++i) with_time(at(i), rest.cols()) = times[i];
  const double own = beyond(rest, with_time.rightCols(1)).norm();
  const auto eigenvalues = strength(with_time).eigenvalues();
  shown.drift = own > 0.0 && (shown.both ? eigenvalues[0] : eigenvalues[1]) > 1e-3;
  return shown;
}

Harmonics harmonics_of(const Signal& signal, const std::vector<double>& outputs, const Shown& shown, bool drift) {
  const MatrixXd x = matrix_of(columns_of(signal, shown, drift));
  VectorXd weight(x.rows()), y(x.rows());
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    weight[i] = std::sqrt(signal.rows[static_cast<std::size_t>(i)].seconds);
    y[i] = outputs[static_cast<std::size_t>(i)];
  }
  const VectorXd size = (weight.asDiagonal() * x).colwise().norm().cwiseMax(1e-300).cwiseInverse();
  const MatrixXd white = weight.asDiagonal() * x * size.asDiagonal();
  const VectorXd b = size.cwiseProduct(white.colPivHouseholderQr().solve(weight.cwiseProduct(y)));
  const VectorXd left = y - x * b;
  Harmonics out;
  const std::size_t fields = shown.both ? 2 : shown.none ? 0 : 1;
  if (fields > 0) out.x = b[0];
  if (fields > 1) out.y = b[1];
  out.offset = b[at(fields)];
  out.residuals.assign(left.data(), left.data() + left.size());
  const VectorXd s = white.jacobiSvd().singularValues();
  out.condition = s[0] / s[s.size() - 1];
  return out;
}

std::vector<double> effect_of(const Signal& signal, const std::vector<Move>& moves, const State& state) {
  std::vector<double> out(signal.rows.size(), 0.0);
  for (const auto& move : moves) {
    const Row& row = signal.rows[move.row];
    out[move.row] = output_of(state, row, {move.after}) - output_of(state, row, {move.before});
  }
  return out;
}

Noise noise_of(const Bench& bench, std::size_t number, const State& state, const std::vector<Disturbance>& disturbances,
               bool drift) {
  const Signal& signal = bench.signals[number];
  MixedData data = blocks_of(signal, shown_by(signal), drift);
  add_effects(signal, number, state, disturbances, data);
  Noise noise;
  const double stated = stated_for(bench, signal, state);
  noise.slow_known = stated > 0.0;
  noise.slow_shown = signal.places.size() > data.design.columns;
  data.slow = linear::unknown_slow_noise(intervals_of(signal), data.design.columns, step_of(signal), stated);
  if (!noise.slow_shown) std::erase_if(data.slow, [](const SlowNoise& slow) { return !slow.known; });
  const MixedFit fit = fit_mixed_model(data);
  noise.scatter = fit.white_variance;
  noise.white = without_rounding(signal, fit.white_variance);
  noise.component_covariance = fit.component_covariance;
  noise.slow = data.slow;
  for (std::size_t c = 0; c < noise.slow.size(); ++c) noise.slow[c].variance = fit.slow_variance[c];
  noise.place_sd = place_sd(noise.slow);
  return noise;
}

Noise expected_noise(const Bench& bench, std::size_t number, const State& state) {
  const Signal& signal = bench.signals[number];
  const Plan& plan = *bench.plan;
  const auto choice = plan.channels.find(signal.problem.role);
  const std::string name = choice == plan.channels.end() ? signal.problem.role : choice->second.front().channel;
  Noise noise;
  noise.slow_known = true;
  const double k = state[scale_of(signal.channel)];
  for (const auto& one : participants_of(plan))
    for (const auto& output : one.model.outputs(one.truth)) {
      if (one.prefix + output.channel != name) continue;
      NoiseModel model = noise_of(one.truth, output.noise_prefix);
      noise.white = noise.scatter = k * k * model.angle_random_walk * model.angle_random_walk;
      noise.slow =
          linear::known_slow_noise(intervals_of(signal), model,
                                   one.truth.number(output.noise_prefix + "turn_on_repeatability"), step_of(signal));
      for (auto& slow : noise.slow) slow.variance *= k * k;
    }
  noise.place_sd = place_sd(noise.slow);
  return noise;
}

}  // namespace tumble::north_finding
