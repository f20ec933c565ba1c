#include "tumble/math/stability/allan_edf_extended.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "tumble/math/stability/allan_edf.hpp"

namespace tumble {
namespace {

/// Between tabled values: linear in the logarithms. Beyond the ends: the end.
template <std::size_t N>
double interpolated(const std::array<double, N>& at, const std::array<double, N>& values, double x) {
  x = std::clamp(x, at.front(), at.back());
  std::size_t i = 0;
  while (i + 2 < N && x > at[i + 1]) ++i;
  const double part = std::log(x / at[i]) / std::log(at[i + 1] / at[i]);
  return values[i] * std::pow(values[i + 1] / values[i], part);
}

std::size_t terms(std::size_t factor, double ratio, double strides) {
  const double m = static_cast<double>(factor);
  return static_cast<std::size_t>(std::max(1.0, std::round((ratio - strides) * m) + 1.0));
}

// Modified total (alpha = row 2, 1, ...) and Hadamard total (alpha = row - 2), which is 2, 1 in the first two rows: edf
// over that of the modified Allan or the overlapping Hadamard variance of the same record.
constexpr std::array<double, 11> segment_ratios{3.2, 3.6, 4.0, 4.8, 6.0, 8.0, 12.0, 16.0, 24.0, 48.0, 96.0};
constexpr std::array<std::array<double, 11>, 7> segment_gains{
    {{8.30, 3.84, 2.62, 2.49, 2.19, 1.98, 1.86, 1.80, 1.75, 1.65, 1.57},
     {4.86, 3.05, 2.28, 2.17, 1.97, 1.83, 1.74, 1.67, 1.63, 1.53, 1.42},
     {2.99, 2.28, 1.778, 1.664, 1.547, 1.489, 1.457, 1.446, 1.437, 1.424, 1.399},
     {2.348, 1.930, 1.528, 1.387, 1.303, 1.263, 1.241, 1.234, 1.228, 1.223, 1.221},
     {1.996, 1.730, 1.428, 1.260, 1.198, 1.166, 1.148, 1.143, 1.139, 1.139, 1.150},
     {1.652, 1.517, 1.343, 1.190, 1.139, 1.112, 1.098, 1.092, 1.088, 1.087, 1.089},
     {1.306, 1.265, 1.206, 1.128, 1.092, 1.074, 1.064, 1.060, 1.057, 1.055, 1.055}}};

// Total variance of white phase noise: 1/edf = a/T + c/ratio^2.
constexpr std::array<double, 12> total_ratios{2.0, 2.4, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0, 48.0, 96.0};
constexpr std::array<double, 12> total_a{1.3790, 1.4244, 1.4978, 1.5816, 1.6794, 1.7354,
                                         1.7977, 1.8317, 1.8679, 1.8869, 1.9067, 1.9271};
constexpr std::array<double, 12> total_c{0.3200, 0.3673, 0.4260, 0.4999, 0.5948, 0.6527,
                                         0.7191, 0.7557, 0.7940, 0.8125, 0.8263, 0.8263};
// Of flicker phase noise: edf over that of the overlapping Allan variance at m = 24, and the power of 24/m it goes
// with.
constexpr std::array<double, 8> flicker_ratios{3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 48.0};
constexpr std::array<double, 8> flicker_gains{1.157, 1.142, 1.061, 1.026, 1.005, 1.014, 1.001, 1.01};
constexpr std::array<double, 8> flicker_powers{0.185, 0.167, 0.133, 0.1075, 0.073, 0.049, 0.030, 0.003};

constexpr std::array<double, 11> theo_shares{0.02, 0.03, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.75};
/// alpha = 2, 1: exact over published; 0, -1, -2: edf tau/T of long records.
constexpr std::array<std::array<double, 11>, 5> theo_edf{
    {{0.987, 0.975, 0.964, 0.943, 0.933, 0.967, 1.087, 1.000, 0.880, 0.785, 1.020},
     {0.930, 0.905, 0.880, 0.840, 0.804, 0.813, 0.902, 0.901, 0.835, 0.840, 0.880},
     {4.08, 4.05, 4.00, 3.88, 3.568, 3.287, 3.149, 2.774, 2.118, 1.668, 1.494},
     {1.87, 1.84, 1.802, 1.717, 1.545, 1.386, 1.249, 1.054, 0.898, 0.872, 0.908},
     {1.28, 1.255, 1.222, 1.152, 1.017, 0.889, 0.774, 0.697, 0.686, 0.739, 0.785}}};
constexpr std::array<double, 9> ratio_shares{0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.745};
constexpr std::array<std::array<double, 9>, 5> ratio_loss{
    {{0.945, 0.915, 0.92, 0.92, 0.92, 0.96, 0.99, 1.00, 1.00},
     {0.360, 0.375, 0.40, 0.445, 0.475, 0.54, 0.63, 0.84, 0.93},
     {0.430, 0.480, 0.555, 0.685, 0.775, 0.85, 0.907, 0.957, 0.967},
     {0.615, 0.640, 0.695, 0.785, 0.850, 0.905, 0.937, 0.951, 0.951},
     {0.715, 0.743, 0.772, 0.820, 0.848, 0.865, 0.874, 0.876, 0.877}}};

/// Below 300 samples by this power of them.
constexpr std::array<double, 5> few_powers{0.45, 0.09, 0.20, 0.14, 0.08};

std::size_t row_of(int alpha) { return static_cast<std::size_t>(std::clamp(2 - alpha, 0, 4)); }

}  // namespace

double total_bias(int alpha, std::size_t factor, double ratio) {
  if (factor == 1) return 1.0;
  const double m = static_cast<double>(factor);
  switch (std::max(alpha, -2)) {
    case 2:  // the ends count 10 and 14 squares instead of 6
      return 1.0 + 4.0 / 3.0 * static_cast<double>(factor - factor % 2) / (m * ratio);
    case 1:
      return 1.0 + (4.0 / 3.0 - 1.0 / (0.97 + 0.295 * std::log(m))) / ratio;
    case 0:  // SP 1065 has long records, without 1/T
      return 1.0 + 1.0 / (m * ratio);
    case -1:
      return (1.0 - 0.481 / ratio) * (1.0 + 1.0 / (m * ratio));
    default:
      return (1.0 - 0.750 / ratio) * (1.0 + 1.0 / (m * ratio));
  }
}

double modified_total_bias(int alpha, std::size_t factor) {
  // m = 2, 3, ... 7, and from 8 on
  static constexpr std::array<std::array<double, 7>, 5> bias{{{0.998, 0.938, 0.996, 0.973, 0.996, 0.983, 0.995},
                                                              {0.856, 0.834, 0.852, 0.846, 0.851, 0.849, 0.851},
                                                              {0.814, 0.781, 0.784, 0.777, 0.777, 0.774, 0.772},
                                                              {0.727, 0.718, 0.720, 0.718, 0.718, 0.718, 0.717},
                                                              {0.675, 0.678, 0.679, 0.679, 0.679, 0.679, 0.679}}};
  if (factor == 1) return 0.5;  // of three points only one of the two differences is left
  return bias[row_of(alpha)][std::min<std::size_t>(factor, 8) - 2];
}

double hadamard_total_bias(int alpha, std::size_t factor) {
  static constexpr std::array<double, 2> later{0.717, 0.679};  // alpha -3, -4
  const double m = static_cast<double>(factor);
  const bool odd = factor % 2 == 1;
  if (alpha >= 2) return 1.384 - (odd ? 0.92 : 0.28) / m;
  if (alpha == 1 && factor == 2) return 1.038;
  if (alpha == 1) return 1.384 - 1.0 / (1.74 + 1.3 * std::log(m)) - (odd ? 0.19 / m : 0.0);
  if (alpha == -2 && factor < 8) return 0.770;
  return alpha >= -2 ? modified_total_bias(alpha + 2, factor) : later[alpha == -3 ? 0 : 1];
}

namespace {

/// Less where few points of white noise are in a tau.
double segment_gain(std::size_t row, std::size_t factor, double ratio) {
  if (factor == 1) return 1.0;
  const double gain = interpolated(segment_ratios, segment_gains[row], ratio);
  return row > 2 ? gain : 1.0 + (gain - 1.0) * (1.0 - 0.6 / static_cast<double>(factor));
}

double total_edf_of_flicker(std::size_t factor, double ratio) {
  constexpr double shortest = 3.0, at_two = 7.0;  // between the two ratios straight in the logarithms
  const double known = std::max(ratio, shortest), m = static_cast<double>(factor) * ratio / known;
  const double same = phase_difference_edf(1, {2, true, false}, static_cast<std::size_t>(std::max(1.0, std::round(m))),
                                           terms(factor, ratio, 2.0 * ratio / known));
  const double edf = same * interpolated(flicker_ratios, flicker_gains, known) *
                     std::pow(24.0 / m, interpolated(flicker_ratios, flicker_powers, known));
  return edf * std::pow(at_two / edf, std::log(known / ratio) / std::log(shortest / 2.0));
}

}  // namespace

double total_edf(int alpha, std::size_t factor, double ratio) {
  const double same = phase_difference_edf(alpha, {2, true, false}, factor, terms(factor, ratio, 2.0));
  if (factor == 1) return same;
  const double m = static_cast<double>(factor);
  if (alpha > 0 && ratio < 2.0) return 0.0;
  switch (std::max(alpha, -2)) {
    case 2:
      return 1.0 / (interpolated(total_ratios, total_a, ratio) / (m * ratio) +
                    interpolated(total_ratios, total_c, ratio) / (ratio * ratio));
    case 1:
      return total_edf_of_flicker(factor, ratio);
    case 0:  // SP 1065 table 7, which the matrices give as well
      return factor < 8 ? same : std::max(1.0, 1.5 * ratio);
    case -1:
      return factor < 8 ? same : std::max(1.0, 1.17 * ratio - 0.22);
    default:
      return factor < 8 ? same : std::max(1.0, 0.93 * ratio - 0.36);
  }
}

double modified_total_edf(int alpha, std::size_t factor, double ratio) {
  const double same = phase_difference_edf(alpha, {2, true, true}, factor, terms(factor, ratio, 3.0));
  return same * segment_gain(2 + row_of(alpha), factor, ratio);
}

double hadamard_total_edf(int alpha, std::size_t factor, double ratio) {
  const double same = phase_difference_edf(alpha, {3, true, false}, factor, terms(factor, ratio, 3.0));
  return same * segment_gain(static_cast<std::size_t>(std::clamp(2 - alpha, 0, 6)), factor, ratio);
}

double theo1_edf(int alpha, std::size_t factor, std::size_t points) {
  const double N = static_cast<double>(points), r = 0.75 * static_cast<double>(factor), share = r / (N - 1.0);
  const double tabled = interpolated(theo_shares, theo_edf[row_of(alpha)], share);
  if (alpha >= 2) return std::max(1.0, tabled * 0.86 * (N + 1.0) * (N - 4.0 * r / 3.0) / (N - r) * r / (r + 1.14));
  if (alpha == 1)
    return std::max(
        1.0, tabled * (4.798 * N * N - 6.374 * N * r + 12.387 * r) / (std::sqrt(r + 36.6) * (N - r)) * r / (r + 0.3));
  const double few = alpha == 0 ? std::pow(r, 1.5) / (std::pow(r, 1.5) + 5.2) : 1.0;
  return std::max(1.0, few * tabled / share);
}

double theo_bias_removed_edf(int alpha, std::size_t factor, std::size_t points) {
  const double samples = static_cast<double>(points - 1), share = static_cast<double>(factor) / samples;
  const double few = std::pow(std::min(1.0, samples / 300.0), few_powers[row_of(alpha)]);
  const double kept = few * interpolated(ratio_shares, ratio_loss[row_of(alpha)], share);
  return kept * theo1_edf(alpha, factor / 3 * 4, points);
}

}  // namespace tumble
