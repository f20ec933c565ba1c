#include "tumble/methods/frequency_response/phase.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::frequency_response {
namespace {

using Severity = Finding::Severity;

/// Nu below which nu/(nu - 2) is no size, and its value there.
constexpr double few_freedom = 2.5, variance_of_few = 5.0;
constexpr double least_phase_variance = 1e-18;  ///< [rad^2] rounding
constexpr double nearly_reversed = 0.75 * pi;   ///< [rad] of one point alone, beyond which half a turn may be wrong
constexpr double most_lead = 0.5 * pi, most_delay = 3.0 * pi;  ///< [rad] at the lowest frequency
constexpr double better_turn = 0.1;  ///< [1] of chi-square as measured, that other turns must leave at most

/// A variance estimated with nu degrees of freedom: that of Student's t is nu/(nu - 2) of it.
double with_few(double variance, double nu) {
  return variance * (nu > few_freedom ? nu / (nu - 2.0) : variance_of_few);
}

/// All but the phases.
Measured without_phases(const std::vector<Point>& points) {
  Measured m;
  double inverse = 0.0;
  for (const Point& p : points) {
    m.frequency.push_back(p.frequency);
    m.log_gain.push_back(std::log(std::abs(p.response)));
    m.log_gain_variance.push_back(with_few(p.output_gain_variance, p.output_dof) +
                                  with_few(p.reference_gain_variance, p.reference_dof) +
                                  with_few(p.scatter_gain_variance, p.scatter_gain_dof) + p.counting_variance);
    m.phase_variance.push_back(with_few(p.output_phase_variance, p.output_dof) +
                               with_few(p.reference_phase_variance, p.reference_dof) +
                               with_few(p.scatter_phase_variance, p.scatter_phase_dof) + p.counting_variance);
    const double output = p.output_gain_variance, reference = p.reference_gain_variance,
                 scatter = p.scatter_gain_variance, all = output + reference + scatter;
    if (all > 0.0)
      inverse += (output * output / p.output_dof + reference * reference / p.reference_dof +
                  scatter * scatter / p.scatter_gain_dof) /
                 (all * all);
  }
  if (inverse > 0.0) m.degrees_of_freedom = static_cast<double>(points.size()) / inverse;
  return m;
}

/// Phases that continue from the first: it as between the two points before, since a delay turns it without end.
std::vector<double> continued(const std::vector<Point>& points, double first, double turn) {
  std::vector<double> phase{first};
  for (std::size_t n = 1; n < points.size(); ++n) {
    const auto f = [&](std::size_t i) { return points[i].frequency; };
    const double expected =
        n == 1 ? first * (first < 0.0 ? f(1) / f(0) : 1.0)
               : phase[n - 1] + (phase[n - 1] - phase[n - 2]) * (f(n) - f(n - 1)) / (f(n - 1) - f(n - 2));
    const double now = std::arg(points[n].response) - turn;
    phase.push_back(now + two_pi * std::round((expected - now) / two_pi));
  }
  return phase;
}

double least_chi_square(const Measured& m) {
  double least = std::numeric_limits<double>::infinity();
  for (const LoopFit& fit : fits_of(m)) least = std::min(least, fit.chi_square);
  return least;
}

/// Weighted polynomial of odd powers through the phases; none: too few points.
struct OddFit {
  std::vector<double> gradient;  ///< of the slope over the phases
  double slope = 0.0, chi_square = 0.0, freedom = 0.0;
};

std::optional<OddFit> odd_fit(const Measured& m, std::size_t terms) {
  const std::size_t n = m.frequency.size();
  if (n < terms + 1) return {};
  Matrix x(n, terms);
  std::vector<double> weight(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double r = m.frequency[i] / m.frequency.back();
    for (std::size_t k = 0; k < terms; ++k) x(i, k) = std::pow(r, static_cast<double>(2 * k + 1));
    weight[i] = 1.0 / std::max(m.phase_variance[i], least_phase_variance);
  }
  const Matrix g = solve_symmetric(gram(x, weight), transposed(scaled_rows(weight, x)));
  OddFit fit;
  const auto b = g * m.phase;
  const auto left = difference(m.phase, x * b);
  fit.chi_square = dot(left, scaled(weight, left));
  fit.freedom = static_cast<double>(n - terms);
  const double to_delay = -1.0 / (two_pi * m.frequency.back());
  fit.slope = b[0] * to_delay;
  for (std::size_t i = 0; i < n; ++i) fit.gradient.push_back(g(0, i) * to_delay);
  return fit;
}

}  // namespace

Measured measured_of(const std::vector<Point>& points) {
  Measured m = without_phases(points);
  if (points.empty()) return m;
  const double measured = std::arg(points.front().response);
  m.phase = continued(points, measured, 0.0);
  if (points.size() < 2) {
    m.turn_unknown = std::abs(measured) > nearly_reversed;
    return m;
  }
  const double as_measured = least_chi_square(m);
  if (!(as_measured > chi_square_quantile(exceeded_in_10000, 2.0 * static_cast<double>(points.size())))) return m;
  double least = as_measured;
  Measured best = m;
  // Odd numbers of half turns: against the reference. A lead of more than a quarter of a turn is no instrument's.
  for (int half_turns = -4; half_turns <= 1; ++half_turns) {
    const double first = measured + half_turns * pi;
    if (half_turns == 0 || first > most_lead || first < -most_delay) continue;
    Measured other = m;
    other.turn = half_turns % 2 == 0 ? 0.0 : pi;
    other.phase = continued(points, first, other.turn);
    const double now = least_chi_square(other);
    if (now < least) least = now, best = std::move(other);
  }
  return least < better_turn * as_measured ? best : m;
}

void report_sign(const Measured& m, bool relative, Findings& findings) {
  if (m.frequency.empty()) return;
  const double phase = std::remainder(m.phase.front() + m.turn, two_pi);
  if (m.turn_unknown) {
    const double lag = phase > 0.0 ? two_pi - phase : -phase;
    findings.push_back({Severity::warning,
                        "sign_or_delay",
                        {{"phase", phase, "deg"},
                         {"frequency", m.frequency.front(), "Hz"},
                         {"delay", lag / (two_pi * m.frequency.front()), "ms"}}});
  } else if (m.turn != 0.0) {
    findings.push_back({relative ? Severity::warning : Severity::error,
                        "response_inverted",
                        {{"phase", phase, "deg"}, {"frequency", m.frequency.front(), "Hz"}}});
  }
}

PhaseSlope slope_at_rest(const Measured& m) {
  constexpr std::size_t most = 4;
  PhaseSlope slope;
  const std::size_t n = m.frequency.size();
  for (std::size_t terms = 1; terms <= most; ++terms) {
    const auto fit = odd_fit(m, terms);
    if (!fit) return slope;
    if (fit->chi_square > chi_square_quantile(exceeded_in_10000, fit->freedom)) continue;
    const auto next = odd_fit(m, terms + 1);
    slope.found = true;
    slope.delay = fit->slope;
    slope.gradient.assign(2 * n, 0.0);
    std::copy(fit->gradient.begin(), fit->gradient.end(), slope.gradient.begin() + static_cast<std::ptrdiff_t>(n));
    slope.model_sd = next ? std::abs(next->slope - fit->slope) / std::sqrt(3.0) : 0.0;
    return slope;
  }
  return slope;
}

}  // namespace tumble::frequency_response
