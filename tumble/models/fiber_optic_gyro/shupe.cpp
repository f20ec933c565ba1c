#include "tumble/models/fiber_optic_gyro/shupe.hpp"

#include <cmath>

#include "tumble/units/constants.hpp"

namespace tumble::fiber_optic_gyro {
namespace {

double gain_of(const Coil& coil) {
  return coil.index / (coil.length * coil.diameter) * (coil.index_slope + coil.index * coil.expansion);
}

/// Wave number of a mode times the thickness: cosines with an insulated face at x = 0, else sines.
double wave_of(const Coil& coil, std::size_t mode) {
  const auto n = static_cast<double>(mode) + 1.0;
  return coil.inner_insulated ? (n - 0.5) * pi : n * pi;
}

/// Mean over layer `layer` of the mode.
double mean_of_mode(const Coil& coil, std::size_t mode, std::size_t layer) {
  const double k = wave_of(coil, mode), d = 1.0 / coil.layers;
  const double from = k * d * static_cast<double>(layer), to = from + k * d;
  return (coil.inner_insulated ? std::sin(to) - std::sin(from) : std::cos(from) - std::cos(to)) / (k * d);
}

/// Share of the outer face in the temperature of a layer at rest.
double share_of_outer(const Coil& coil, std::size_t layer) {
  return coil.inner_insulated ? 1.0 : (static_cast<double>(layer) + 0.5) / coil.layers;
}

}  // namespace

double shupe_rate(const Coil& coil, std::span<const double> temperature_rates) {
  const double section = coil.length / static_cast<double>(temperature_rates.size());
  double integral = 0.0;
  for (std::size_t i = 0; i < temperature_rates.size(); ++i)
    integral += temperature_rates[i] * ((2.0 * static_cast<double>(i) + 1.0) * section - coil.length) * section;
  return gain_of(coil) * integral;
}

std::vector<double> layer_weights(const Coil& coil) {
  std::vector<double> weights;
  const double of_layer = coil.length / coil.layers;
  int half_layers[2]{0, 0};  // of each half wound so far
  for (int layer = 0; layer < coil.layers; ++layer) {
    if (coil.winding == Winding::plain) {
      weights.push_back(((2.0 * layer + 1.0) * of_layer - coil.length) * of_layer);
      continue;
    }
    const int place = coil.winding == Winding::dipole ? layer % 2 : (layer % 4 == 1 || layer % 4 == 2 ? 1 : 0);
    const double from_middle = (half_layers[place]++ + 0.5) * of_layer;
    weights.push_back((place == 0 ? -2.0 : 2.0) * from_middle * of_layer);
  }
  return weights;
}

CoilHeat::CoilHeat(const Coil& coil, double outer, double inner)
    : coil_(coil), gain_(gain_of(coil)), outer_(outer), inner_(inner) {
  const auto weights = layer_weights(coil);
  const auto layers = static_cast<std::size_t>(coil.layers);
  for (std::size_t l = 0; l < layers; ++l) {
    outer_moment_ += weights[l] * share_of_outer(coil, l);
    inner_moment_ += weights[l] * (1.0 - share_of_outer(coil, l));
  }
  for (std::size_t mode = 0; mode < 4 * layers; ++mode) {
    const double k = wave_of(coil, mode), sign = mode % 2 == 0 ? 1.0 : -1.0;
    rate_.push_back(coil.diffusivity * k * k / (coil.thickness * coil.thickness));
    // 1 = sum of 2 (-1)^(n+1)/k_n cos; x/H = sum of 2 (-1)^(n+1)/k_n sin, 1 - x/H = sum of 2/k_n sin
    from_outer_.push_back(-2.0 * sign / k);
    from_inner_.push_back(coil.inner_insulated ? 0.0 : -2.0 / k);
    double moment = 0.0;
    for (std::size_t l = 0; l < layers; ++l) moment += weights[l] * mean_of_mode(coil, mode, l);
    mode_moment_.push_back(moment);
  }
  amplitude_.assign(rate_.size(), 0.0);
}

void CoilHeat::choose_step(double step) {
  step_ = step;
  decay_.clear();
  gained_.clear();
  for (const double rate : rate_) {
    decay_.push_back(std::exp(-rate * step));
    gained_.push_back(-std::expm1(-rate * step) / (rate * step));
  }
}

/// Sum over layers of weight x temperature, without what the faces give in equilibrium.
double CoilHeat::moment() const {
  double sum = 0.0;
  for (std::size_t n = 0; n < amplitude_.size(); ++n) sum += mode_moment_[n] * amplitude_[n];
  return sum;
}

double CoilHeat::advance(double step, double outer, double inner) {
  if (step != step_) choose_step(step);
  const double before = moment(), by_outer = outer - outer_, by_inner = inner - inner_;
  for (std::size_t n = 0; n < amplitude_.size(); ++n)
    amplitude_[n] = decay_[n] * amplitude_[n] + gained_[n] * (from_outer_[n] * by_outer + from_inner_[n] * by_inner);
  outer_ = outer;
  inner_ = inner;
  return gain_ * (moment() - before + outer_moment_ * by_outer + inner_moment_ * by_inner) / step;
}

std::vector<double> CoilHeat::layers() const {
  std::vector<double> temperatures;
  for (std::size_t l = 0; l < static_cast<std::size_t>(coil_.layers); ++l) {
    const double share = share_of_outer(coil_, l);
    double sum = share * outer_ + (1.0 - share) * inner_;
    for (std::size_t n = 0; n < amplitude_.size(); ++n) sum += amplitude_[n] * mean_of_mode(coil_, n, l);
    temperatures.push_back(sum);
  }
  return temperatures;
}

}  // namespace tumble::fiber_optic_gyro
