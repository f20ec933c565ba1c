#include "tumble/math/stability/allan_edf.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

// Letters as in Greenhall and Riley (2003): alpha exponent of S_y, d order of the difference, m averaging factor, F
// filter factor (1 modified, m not, infinite for its limit), S stride factor, M number of terms, r = M/S, J number of
// lags.

namespace tumble {
namespace {

constexpr double infinite = 0.0;  // stands for F -> infinity in what follows
constexpr std::size_t most_lags = 100;

/// Generalised autocovariance of the phase filter's input, eq. (7). long double: eq. (8) differences it at 1/F.
long double s_w(long double t, int alpha) {
  t = std::abs(t);
  if (t == 0.0L) return 0.0L;
  switch (alpha) {
    case 2:
      return -t;
    case 1:
      return t * t * std::log(t);
    case 0:
      return t * t * t;
    case -1:
      return -t * t * t * t * std::log(t);
    case -2:
      return -t * t * t * t * t;
    case -3:
      return t * t * t * t * t * t * std::log(t);
    default:
      return t * t * t * t * t * t * t;
  }
}

/// Eq. (8).
double s_x(double t, double F, int alpha) {
  if (F == infinite) return static_cast<double>(s_w(t, alpha + 2));
  const long double step = 1.0L / F;
  return static_cast<double>(F * (F * (2.0L * s_w(t, alpha) - s_w(t - step, alpha) - s_w(t + step, alpha))));
}

/// Autocovariance of the d-th difference of phase at lag t (in units of tau), eq. (9).
double s_z(double t, double F, int alpha, int d) {
  static constexpr std::array<std::array<double, 4>, 4> binomial{
      {{1, 0, 0, 0}, {2, -1, 0, 0}, {6, -4, 1, 0}, {20, -15, 6, -1}}};
  double sum = binomial[d][0] * s_x(t, F, alpha);
  for (int k = 1; k <= d; ++k) sum += binomial[d][k] * (s_x(t - k, F, alpha) + s_x(t + k, F, alpha));
  return sum;
}

/// BasicSum of eq. (10) divided by s_z(0)^2 M: 1/edf.
double inverse_edf(std::size_t J, double M, double S, double F, int alpha, int d, double variance) {
  const auto squared = [](double value) { return value * value; };
  const double last = static_cast<double>(J);
  double sum = squared(s_z(0.0, F, alpha, d)) + (1.0 - last / M) * squared(s_z(last / S, F, alpha, d));
  for (std::size_t j = 1; j < J; ++j) {
    const double lag = static_cast<double>(j);
    sum += 2.0 * (1.0 - lag / M) * squared(s_z(lag / S, F, alpha, d));
  }
  return sum / (squared(variance) * M);
}

struct Pair {
  double a0, a1;
};

/// Coefficients of 1/edf = (a0 - a1/r)/r for large r; rows alpha = 2 ... -4, columns d = 1 ... 3.
constexpr Pair none{0.0, 0.0};
constexpr Pair table_1[7][3] = {{{2.0 / 3, 1.0 / 3}, {7.0 / 9, 0.5}, {22.0 / 25, 2.0 / 3}},
                                {{0.840, 0.345}, {0.997, 0.616}, {1.141, 0.843}},
                                {{1.079, 0.368}, {1.033, 0.607}, {1.184, 0.848}},
                                {none, {1.048, 0.534}, {1.180, 0.816}},
                                {none, {1.302, 0.535}, {1.175, 0.777}},
                                {none, none, {1.194, 0.703}},
                                {none, none, {1.489, 0.702}}};
constexpr Pair table_2[7][3] = {{{1.5, 0.5}, {35.0 / 18, 1.0}, {231.0 / 100, 1.5}},
                                {{78.6, 25.2}, {790.0, 410.0}, {9950.0, 6520.0}},
                                {{2.0 / 3, 1.0 / 6}, {2.0 / 3, 1.0 / 3}, {7.0 / 9, 0.5}},
                                {none, {0.852, 0.375}, {0.997, 0.617}},
                                {none, {1.079, 0.368}, {1.033, 0.607}},
                                {none, none, {1.053, 0.553}},
                                {none, none, {1.302, 0.535}}};
/// s_z(0) = b0 + b1 ln m for alpha = 1, unmodified.
constexpr Pair table_3[3] = {{6.0, 4.0}, {15.23, 12.0}, {47.8, 40.0}};

double large_r(const Pair& table, double r) { return (table.a0 - table.a1 / r) / r; }

/// White phase noise, unmodified: phase samples are independent, so only lags of whole tau count.
double inverse_edf_white_phase(double M, double r, int d) {
  static constexpr double binomial[4][4] = {{1, 0, 0, 0}, {2, 1, 0, 0}, {6, 4, 1, 0}, {20, 15, 6, 1}};
  double sum = 1.0;
  for (int k = 1; k <= d && k < r; ++k) {
    const double correlation = binomial[d][k] / binomial[d][0];
    sum += 2.0 * (1.0 - k / r) * correlation * correlation;
  }
  return sum / M;
}

}  // namespace

double phase_difference_edf(int alpha, const PhaseDifference& difference, std::size_t factor, std::size_t terms) {
  const int d = std::clamp(difference.order, 1, 3);
  alpha = std::clamp(alpha, 2 - 2 * d, 2);
  const double m = static_cast<double>(factor);
  const double M = static_cast<double>(terms);
  const double S = difference.overlapping ? m : 1.0;
  const double r = M / S;
  const std::size_t J = std::min(terms, (static_cast<std::size_t>(d) + 1) * (difference.overlapping ? factor : 1));
  const double lags = static_cast<double>(most_lags);
  // F samples are averaged; `tabled` is the approximation for many terms
  const auto inverse_with = [&](double F, double F_of_lags, double variance, double tabled) {
    if (J <= most_lags) return inverse_edf(J, M, S, F, alpha, d, s_z(0.0, F, alpha, d));
    if (r > d + 1) return tabled;
    return inverse_edf(most_lags, lags, lags / r, F_of_lags, alpha, d, variance);
  };

  double inverse = 1.0;
  if (difference.modified && factor > 1) {
    inverse = inverse_with(1.0, 1.0, s_z(0.0, 1.0, alpha, d), large_r(table_1[2 - alpha][d - 1], r));
  } else if (alpha <= 0) {
    // F = m would stand for phase averaged over t0. Ours is the integral of a rate, not filtered: F infinite at any m.
    inverse = inverse_with(infinite, infinite, s_z(0.0, infinite, alpha, d), large_r(table_2[2 - alpha][d - 1], r));
  } else if (alpha == 1) {
    const double variance = table_3[d - 1].a0 + table_3[d - 1].a1 * std::log(m);
    inverse = inverse_with(m, lags / r, variance, large_r(table_2[1][d - 1], r) / (variance * variance));
  } else {
    inverse = inverse_edf_white_phase(M, r, d);
  }
  return std::max(1.0, 1.0 / inverse);
}

double parabolic_edf(int alpha, std::size_t factor, std::size_t terms) {
  // Beyond 24 points in tau the edf depends on terms/factor alone (within 2 %).
  constexpr std::size_t most_points = 24, lags_in_tau = 8;
  if (factor == 1) return phase_difference_edf(alpha, PhaseDifference{}, 1, terms);
  alpha = std::clamp(alpha, -2, 2);
  const std::size_t m = std::min(factor, most_points), lags = lags_in_tau * m, span = 2 * m;
  const double M = std::max(1.0, static_cast<double>(terms) * static_cast<double>(m) / static_cast<double>(factor));
  const double F = alpha > 0 ? static_cast<double>(m) : infinite;
  const auto weight = [&](std::size_t k) {
    const double line = 0.5 * static_cast<double>(m - 1) - static_cast<double>(k % m);
    return k < m ? line : -line;
  };
  std::vector<double> product(span, 0.0);  // sum_k w_k w_{k+d}
  for (std::size_t d = 0; d < span; ++d) {
    for (std::size_t k = 0; k + d < span; ++k) product[d] += weight(k) * weight(k + d);
  }
  std::vector<double> phase(lags + span);
  for (std::size_t k = 0; k < phase.size(); ++k) {
    phase[k] = s_x(static_cast<double>(k) / static_cast<double>(m), F, alpha);
  }
  double variance = 0.0, sum = 0.0;
  for (std::size_t j = 0; j < lags && static_cast<double>(j) < M; ++j) {
    double covariance = product[0] * phase[j];
    for (std::size_t d = 1; d < span; ++d) covariance += product[d] * (phase[j + d] + phase[j > d ? j - d : d - j]);
    if (j == 0) variance = covariance;
    sum += (j == 0 ? 1.0 : 2.0) * (1.0 - static_cast<double>(j) / M) * covariance * covariance;
  }
  return std::max(1.0, M * variance * variance / sum);
}

}  // namespace tumble
