#include "tumble/methods/north_finding/noise.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/sim/power_up.hpp"
#include "tumble/units/error.hpp"

namespace tumble::north_finding {
namespace {

constexpr double other_spin = 1e-6;        ///< [rad/s] between two spins, from which on they are several
constexpr double least_with_drift = 1e-3;  ///< [1] squared: 3 % of a full turn's share, which a drift must leave

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
  return high - low > other_spin;
}

/// Columns of the straight model: the field along x and y of the base, 1, of a gyro t and the turn of the table; each
/// as far as the signal shows it [rows x columns].
Matrix design_of(const Signal& signal, const Shown& shown, bool drift) {
  const bool is_gyro = signal.channel == gyro, spins = is_gyro && several_spins(signal);
  const std::size_t fields = shown.both ? 2 : shown.none ? 0 : 1;
  Matrix design(signal.rows.size(), fields + 1 + (is_gyro && drift ? 1 : 0) + (spins ? 1 : 0));
  for (std::size_t i = 0; i < signal.rows.size(); ++i) {
    const Row& row = signal.rows[i];
    const auto [x, y] = sensitivity_in_base(row);
    std::size_t j = 0;
    if (shown.both) design(i, j++) = x, design(i, j++) = y;
    if (fields == 1) design(i, j++) = std::cos(shown.along) * x + std::sin(shown.along) * y;
    design(i, j++) = 1.0;
    if (is_gyro && drift) design(i, j++) = row.time;
    if (spins) design(i, j) = spin_of(row);
  }
  return design;
}

/// Part of the columns of `x` that is orthogonal to those of `basis`.
Matrix beyond(const Matrix& basis, Matrix x) {
  const Matrix scaled = scaled_columns(basis, inverses(column_norms(basis), 1e-300));
  for (std::size_t j = 0; j < x.columns; ++j) {
    const auto b = column(x, j);
    std::ranges::copy(difference(b, scaled * qr_fit(scaled, b).x), b.begin());
  }
  return x;
}

std::vector<linear::Interval> intervals_of(const Signal& signal) {
  std::vector<linear::Interval> out;
  for (const auto& position : signal.positions) out.push_back(position.interval);
  return out;
}

double step_of(const Signal& signal) { return signal.evidence.test.stretches.front().step; }

/// Bias instability of a signal by the settings [SI of the channel]; 0: not stated.
double stated_for(const Bench& bench, const Signal& signal, const State& state) {
  const double stated =
      linear::stated_bias_instability(bench.plan->settings, signal.channel == gyro ? "gyro_" : "accelerometer_");
  return stated * std::abs(state[scale_of(signal.channel)]);
}

/// Blocks as the mixed model takes them.
MixedData blocks_of(const Signal& signal, const Shown& shown, bool drift) {
  MixedData data;
  std::vector<std::size_t> rows;
  for (std::size_t b = 0; b < signal.row_of.size(); ++b) {
    if (signal.row_of[b] == npos) continue;
    rows.push_back(signal.row_of[b]);
    data.observations.push_back(signal.blocks.output[b]);
    data.weights.push_back(signal.blocks.weights[b]);
    data.segment.push_back(signal.rows[rows.back()].position);
  }
  data.design = chosen_rows(design_of(signal, shown, drift), rows);
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
  for (const auto& disturbance : disturbances) {
    const auto& moves = disturbance.moves[number];
    if (moves.empty()) continue;
    data.effects.push_back({disturbance.source, on_blocks(signal, effect_of(signal, moves, state)), false});
  }
  KnownEffect rounding{"counting", {}, true};
  for (const std::size_t row : signal.row_of)
    if (row != npos) rounding.column.push_back(signal.rows[row].rounding_sd);
  if (signal.problem.pulse > 0.0) data.effects.push_back(std::move(rounding));
}

/// Rounding to whole pulses is part of the scatter of a turn's blocks, but cancels from block to block. At least
/// twice the uncertainty of the scatter remains.
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

}  // namespace

Shown shown_by(const Signal& signal) {
  const std::size_t n = signal.rows.size(), constants = several_spins(signal) && signal.channel == gyro ? 2 : 1;
  Matrix field(n, 2), basis(n, constants, 1.0), times(n, 1);
  for (std::size_t i = 0; i < n; ++i) {
    std::tie(field(i, 0), field(i, 1)) = sensitivity_in_base(signal.rows[i]);
    if (constants == 2) basis(i, 1) = spin_of(signal.rows[i]);
    times(i, 0) = signal.rows[i].time;
  }
  const auto strength = [&](const Matrix& other) {
    return eigen_symmetric((1.0 / static_cast<double>(n)) * gram(beyond(other, field)));
  };
  constexpr double least = 1e-6;  // squared: a thousandth of a full turn's share
  const auto eigen = strength(basis);
  Shown shown;
  shown.none = eigen.values[1] < least;
  shown.both = eigen.values[0] > least;
  shown.along = std::atan2(eigen.vectors(1, 1), eigen.vectors(0, 1));
  const bool time_varies = norm(beyond(basis, times).values) > 0.0;
  const auto with_time = strength(beside(basis, times)).values;
  shown.drift = time_varies && (shown.both ? with_time[0] : with_time[1]) > least_with_drift;
  return shown;
}

Harmonics harmonics_of(const Signal& signal, const std::vector<double>& outputs, const Shown& shown, bool drift) {
  const Matrix x = design_of(signal, shown, drift);
  std::vector<double> weight;
  for (const auto& row : signal.rows) weight.push_back(std::sqrt(row.seconds));
  const Matrix weighted = scaled_rows(weight, x);
  const auto size = inverses(column_norms(weighted), 1e-300);
  const Matrix white = scaled_columns(weighted, size);
  const auto b = scaled(size, qr_fit(white, scaled(weight, outputs)).x);
  Harmonics out;
  const std::size_t fields = shown.both ? 2 : shown.none ? 0 : 1;
  if (fields > 0) out.x = b[0];
  if (fields > 1) out.y = b[1];
  out.offset = b[fields];
  out.residuals = difference(outputs, x * b);
  out.condition = condition(white);
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
  noise.slow_shown = signal.positions.size() > data.design.columns;
  data.slow = linear::unknown_slow_noise(intervals_of(signal), data.design.columns, step_of(signal), stated);
  if (!noise.slow_shown) std::erase_if(data.slow, [](const SlowNoise& slow) { return !slow.known; });
  const MixedFit fit = fit_mixed_model(data);
  noise.scatter = fit.white_variance;
  noise.white = without_rounding(signal, fit.white_variance);
  noise.component_covariance = fit.component_covariance;
  noise.slow = data.slow;
  for (std::size_t c = 0; c < noise.slow.size(); ++c) noise.slow[c].variance = fit.slow_variance[c];
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
  for (const auto& instrument : participants_of(plan))
    for (const auto& output : instrument.model.outputs(instrument.truth)) {
      if (instrument.prefix + output.channel != name) continue;
      const Settings& truth = instrument.truth;
      const NoiseModel model = noise_of(truth, output.noise_prefix);
      noise.white = noise.scatter = k * k * model.angle_random_walk * model.angle_random_walk;
      noise.slow = linear::known_slow_noise(
          intervals_of(signal), model, truth.number(output.noise_prefix + "turn_on_repeatability"), step_of(signal));
      for (auto& slow : noise.slow) slow.variance *= k * k;
    }
  return noise;
}

}  // namespace tumble::north_finding
