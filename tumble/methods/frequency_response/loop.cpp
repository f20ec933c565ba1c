#include "tumble/methods/frequency_response/loop.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <utility>

#include "tumble/math/bisection.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::frequency_response {
namespace {

using Complex = std::complex<double>;
using Vector = std::vector<double>;
/// Ratios of a loop of second order that are looked for.
constexpr double least_damping = 1e-4, greatest_damping = 50.0;
/// Frequencies from which the search starts: from `first_start` of the lowest to `last_start` of the highest point.
constexpr double first_start = 0.3, last_start = 10.0, ratio_of_starts = 1.25;
constexpr int most_rounds_of_fit = 100;
/// [1] of a step: if so short a one raises the cost, the cost is at rounding.
constexpr double least_step_share = 1e-6;
constexpr double last_step = 1e-7;  ///< [sd of one point] of the residuals, by which the last step changes them
constexpr double least_freedom_of_loop = 4.0;  ///< with which a point can be judged by the others

/// A response without noise keeps finite weights: rounding of ln H.
constexpr double least_variance = 1e-18;

std::size_t parameters(LoopKind kind) { return 2 + static_cast<std::size_t>(kind); }

/// ln H and its derivatives by theta.
Complex log_response(LoopKind kind, const Vector& theta, double f, Complex* derivative) {
  const Complex i(0.0, 1.0);
  Complex value = theta[0] - i * two_pi * f * theta[1];
  derivative[0] = 1.0;
  derivative[1] = -i * two_pi * f;
  if (kind == LoopKind::delay) return value;
  const double r = f / std::exp(theta[2]);
  if (kind == LoopKind::first_order) {
    const Complex d = 1.0 + i * r;
    derivative[2] = i * r / d;
    return value - std::log(d);
  }
  const Complex d = 1.0 - r * r + 2.0 * i * theta[3] * r;
  derivative[2] = -(2.0 * r * r - 2.0 * i * theta[3] * r) / d;
  derivative[3] = -2.0 * i * r / d;
  return value - std::log(d);  // zeta > 0: the argument runs from 0 to pi, no branch is crossed
}

struct Equations {
  Matrix jacobian;  // weighted
  Vector residual;  // weighted
};

Equations linearise(const Measured& m, LoopKind kind, const Vector& theta) {
  const std::size_t n = m.frequency.size();
  Equations e{Matrix(2 * n, theta.size()), Vector(2 * n)};
  Complex derivative[4];
  for (std::size_t k = 0; k < n; ++k) {
    const Complex value = log_response(kind, theta, m.frequency[k], derivative);
    const double gain_weight = 1.0 / std::sqrt(std::max(m.log_gain_variance[k], least_variance));
    const double phase_weight = 1.0 / std::sqrt(std::max(m.phase_variance[k], least_variance));
    e.residual[k] = gain_weight * (m.log_gain[k] - value.real());
    e.residual[n + k] = phase_weight * (m.phase[k] - value.imag());
    for (std::size_t j = 0; j < theta.size(); ++j) {
      e.jacobian(k, j) = gain_weight * derivative[j].real();
      e.jacobian(n + k, j) = phase_weight * derivative[j].imag();
    }
  }
  return e;
}

double cost(const Measured& m, LoopKind kind, const Vector& theta) {
  if (kind == LoopKind::second_order && !(theta[3] > least_damping && theta[3] < greatest_damping))
    return std::numeric_limits<double>::infinity();
  const Vector residual = linearise(m, kind, theta).residual;
  return dot(residual, residual);
}

/// K and tau are linear parameters: their best values for given poles.
void fill_linear(const Measured& m, LoopKind kind, Vector& theta) {
  theta[0] = theta[1] = 0.0;
  const Equations e = linearise(m, kind, theta);
  const Vector linear = solve(block(e.jacobian, 0, e.jacobian.rows, 0, 2), e.residual);
  std::ranges::copy(linear, theta.begin());
}

Vector best_start(const Measured& m, LoopKind kind) {
  Vector best(parameters(kind), 0.0);
  if (kind == LoopKind::delay) return best;
  double least = std::numeric_limits<double>::infinity();
  const double low = first_start * m.frequency.front(), high = last_start * m.frequency.back();
  for (double f = low; f <= high; f *= ratio_of_starts) {
    for (const double zeta : {0.05, 0.15, 0.3, 0.5, 0.7, 1.0, 2.0}) {
      Vector theta(parameters(kind), 0.0);
      theta[2] = std::log(f);
      if (kind == LoopKind::second_order) theta[3] = zeta;
      fill_linear(m, kind, theta);
      const double current = cost(m, kind, theta);
      if (current < least) {
        least = current;
        best = theta;
      }
      if (kind == LoopKind::first_order) break;
    }
  }
  return best;
}

/// Gauss-Newton steps, halved where they raise the cost, until they or the gain by them are at rounding. Returns
/// whether they come to that.
bool refine(const Measured& m, LoopKind kind, Vector& theta) {
  double least = cost(m, kind, theta);
  for (int round = 0; round < most_rounds_of_fit; ++round) {
    const Equations e = linearise(m, kind, theta);
    const Vector lengths = column_norms(e.jacobian), weights = inverses(lengths, 1e-300);
    const Vector scaled_step = solve(scaled_columns(e.jacobian, weights), e.residual);
    const Vector step = scaled(weights, scaled_step);
    double share = 1.0;
    while (share > least_step_share && !(cost(m, kind, scaled_sum(theta, share, step)) <= least)) share *= 0.5;
    if (share <= least_step_share) return true;
    theta = scaled_sum(theta, share, step);
    const double reached = cost(m, kind, theta);
    if (reached == least || share * norm(scaled_step) < last_step) return true;
    least = reached;
  }
  return false;
}

double value_at(const LoopFit& fit, Derived (*of)(const LoopFit&), std::size_t j, double change) {
  LoopFit moved = fit;
  moved.theta[j] += change;
  return of(moved).value;
}

/// Gradient by central differences of a function that fills the value alone.
Derived with_gradient(const LoopFit& fit, Derived (*of)(const LoopFit&)) {
  Derived d = of(fit);
  for (std::size_t j = 0; j < fit.theta.size(); ++j) {
    const double h = 1e-6;
    d.gradient.push_back(j < 2 ? 0.0 : (value_at(fit, of, j, h) - value_at(fit, of, j, -h)) / (2.0 * h));
  }
  return d;
}

Derived plain_bandwidth(const LoopFit& fit) {
  const double f = std::exp(fit.theta[2]);
  if (fit.kind == LoopKind::first_order) return {f, {}};
  const double a = 1.0 - 2.0 * fit.theta[3] * fit.theta[3];
  return {f * std::sqrt(a + std::sqrt(a * a + 1.0)), {}};
}

Derived plain_peaking(const LoopFit& fit) {
  const double z = fit.theta[3];
  return {1.0 / (2.0 * z * std::sqrt(1.0 - z * z)), {}};
}

Derived plain_resonance(const LoopFit& fit) {
  const double z = fit.theta[3];
  return {std::exp(fit.theta[2]) * std::sqrt(1.0 - 2.0 * z * z), {}};
}

}  // namespace

const char* name(LoopKind kind) {
  return kind == LoopKind::delay ? "delay alone" : kind == LoopKind::first_order ? "first order" : "second order";
}

LoopFit fit_loop(const Measured& m, LoopKind kind) {
  const std::size_t n = m.frequency.size(), p = parameters(kind);
  LoopFit fit;
  fit.kind = kind;
  if (2 * n < p + 2) return fit;
  fit.theta = best_start(m, kind);
  if (kind == LoopKind::delay) fill_linear(m, kind, fit.theta);
  fit.converged = refine(m, kind, fit.theta);
  const Equations e = linearise(m, kind, fit.theta);
  fit.chi_square = dot(e.residual, e.residual);
  fit.degrees_of_freedom = static_cast<double>(2 * n - p);
  const double k = static_cast<double>(p);
  fit.aicc = fit.chi_square + 2.0 * k + 2.0 * k * (k + 1.0) / std::max(1.0, static_cast<double>(2 * n) - k - 1.0);
  fit.accepted = fit.converged && fit.chi_square < chi_square_quantile(exceeded_in_10000, fit.degrees_of_freedom);
  fit.gain = pseudo_inverse(e.jacobian);
  for (std::size_t i = 0; i < 2 * n; ++i) {
    const double variance = i < n ? m.log_gain_variance[i] : m.phase_variance[i - n];
    for (double& gain : column(fit.gain, i)) gain /= std::sqrt(std::max(variance, least_variance));
  }
  return fit;
}

std::vector<LoopFit> fits_of(const Measured& m) {
  std::vector<LoopFit> fits;
  for (const LoopKind kind : {LoopKind::delay, LoopKind::first_order, LoopKind::second_order})
    if (LoopFit fit = fit_loop(m, kind); !fit.theta.empty()) fits.push_back(std::move(fit));
  return fits;
}

namespace {

Measured without(Measured m, std::size_t point) {
  const auto at = static_cast<std::ptrdiff_t>(point);
  for (auto* values : {&m.frequency, &m.log_gain, &m.phase, &m.log_gain_variance, &m.phase_variance})
    values->erase(values->begin() + at);
  return m;
}

}  // namespace

std::optional<Apart> point_apart(const Measured& m) {
  std::optional<Apart> apart;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < m.frequency.size(); ++k)
    for (const LoopFit& fit : fits_of(without(m, k))) {
      if (!fit.accepted || fit.degrees_of_freedom < least_freedom_of_loop || !(fit.chi_square < least)) continue;
      least = fit.chi_square;
      Complex derivative[4];
      const Complex value = log_response(fit.kind, fit.theta, m.frequency[k], derivative);
      apart = Apart{k, std::exp(m.log_gain[k] - value.real()), m.phase[k] - value.imag()};
    }
  return apart;
}

Derived bandwidth_of(const LoopFit& fit) { return with_gradient(fit, plain_bandwidth); }
Derived peaking_of(const LoopFit& fit) { return with_gradient(fit, plain_peaking); }
Derived resonance_frequency_of(const LoopFit& fit) { return with_gradient(fit, plain_resonance); }

Derived delay_of(const LoopFit& fit) {
  Derived delay{fit.theta[1], std::vector<double>(fit.theta.size())};
  delay.gradient[1] = 1.0;
  return delay;
}

Derived group_delay_of(const LoopFit& fit) {
  Derived delay = delay_of(fit);
  if (fit.kind == LoopKind::delay) return delay;
  const bool second = fit.kind == LoopKind::second_order;
  const double of_damping = (second ? 2.0 : 1.0) / (two_pi * std::exp(fit.theta[2]));
  const double lag = of_damping * (second ? fit.theta[3] : 1.0);
  delay.value += lag;
  delay.gradient[2] = -lag;
  if (second) delay.gradient[3] = of_damping;
  return delay;
}

Crossing crossing_of(const std::vector<double>& frequency, const std::vector<double>& log_gain) {
  const double level = log_gain.empty() ? 0.0 : log_gain.front() - 0.5 * std::log(2.0);
  for (std::size_t k = 0; k + 1 < frequency.size(); ++k) {
    if (!(log_gain[k] > level && log_gain[k + 1] <= level)) continue;
    const double x0 = std::log(frequency[k]), x1 = std::log(frequency[k + 1]), h = x1 - x0;
    const double y0 = log_gain[k], y1 = log_gain[k + 1];
    const auto slope = [&](std::size_t a, std::size_t b) {
      return (log_gain[b] - log_gain[a]) / (std::log(frequency[b]) - std::log(frequency[a]));
    };
    // Falling slopes, at most three times the chord's: the cubic then crosses once (Fritsch and Carlson, 1980).
    const double chord = (y1 - y0) / h;
    const double m0 = std::clamp(k > 0 ? slope(k - 1, k + 1) : chord, 3.0 * chord, 0.0);
    const double m1 = std::clamp(k + 2 < frequency.size() ? slope(k, k + 2) : chord, 3.0 * chord, 0.0);
    constexpr int halvings = 60;  // to rounding
    const auto is_above = [&](double s) {
      const double t = 1.0 - s;
      return y0 * (1.0 + 2.0 * s) * t * t + h * m0 * s * t * t + y1 * s * s * (3.0 - 2.0 * s) - h * m1 * s * s * t >
             level;
    };
    const double cubic = std::exp(x0 + h * bisected(0.0, 1.0, halvings, is_above).low),
                 straight = std::exp(x0 + (level - y0) / chord);
    return {true, cubic, std::abs(cubic - straight) / std::sqrt(3.0)};
  }
  return {};
}

}  // namespace tumble::frequency_response
