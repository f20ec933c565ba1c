#include "tumble/methods/dtg_centrifuge/sums.hpp"

#include <algorithm>

#include "tumble/math/circle.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::dtg_centrifuge {
namespace {

constexpr std::size_t batch = 256, lanes = 8;
constexpr std::size_t rows = columns + most_signals;

using Work = double[rows][batch];

/// The columns and signals of up to `batch` samples; what is missing is zero in all of them. Returns the samples used.
[[gnu::always_inline]] inline double fill(const Block& block, std::size_t first, std::size_t count, Work& work) {
  double used[batch];
  const double* arm = block.arm + first;
  const double* table = block.table + first;
  for (std::size_t i = 0; i < batch; ++i) used[i] = i < count ? 1.0 : 0.0;
  for (std::size_t i = 0; i < count; ++i) used[i] = arm[i] + table[i] == arm[i] + table[i] ? 1.0 : 0.0;
  for (std::size_t s = 0; s < block.signals; ++s) {
    const double* y = block.signal[s] + first;
    for (std::size_t i = 0; i < count; ++i) used[i] = y[i] == y[i] ? used[i] : 0.0;
  }
  constexpr double turn = 0.5 / pi;
  const double tau = block.tau + block.tau_step * static_cast<double>(first), step = block.tau_step;
  for (std::size_t i = 0; i < count; ++i) {
    const double a = used[i] != 0.0 ? arm[i] : 0.0, t = used[i] != 0.0 ? table[i] : 0.0;
    const CirclePoint theta = on_circle(-turn * t), beta = on_circle(turn * (a + t));
    const double c = theta.cosine, s = theta.sine, u = used[i];
    const double c2 = c * c - s * s, s2 = 2.0 * s * c;
    work[0][i] = u;
    work[1][i] = u * (tau + step * static_cast<double>(static_cast<int>(i)));
    work[2][i] = u * c;
    work[3][i] = u * s;
    work[4][i] = u * c2;
    work[5][i] = u * s2;
    work[6][i] = u * (c2 * c - s2 * s);
    work[7][i] = u * (s2 * c + c2 * s);
    work[8][i] = u * beta.cosine;
    work[9][i] = u * beta.sine;
    work[10][i] = u * (beta.cosine * c2 - beta.sine * s2);
    work[11][i] = u * (beta.sine * c2 + beta.cosine * s2);
  }
  for (std::size_t s = 0; s < block.signals; ++s) {
    const double* y = block.signal[s] + first;
    for (std::size_t i = 0; i < count; ++i) work[columns + s][i] = used[i] != 0.0 ? y[i] : 0.0;
  }
  for (std::size_t r = 0; r < columns + block.signals; ++r)
    for (std::size_t i = count; i < batch; ++i) work[r][i] = 0.0;
  double samples = 0.0;
  for (std::size_t i = 0; i < count; ++i) samples += used[i];
  return samples;
}

/// In lanes of fixed order, so that every processor adds alike.
[[gnu::always_inline]] inline double product(const double* __restrict a, const double* __restrict b) {
  double sum[lanes] = {};
  for (std::size_t i = 0; i < batch; i += lanes)
    for (std::size_t k = 0; k < lanes; ++k) sum[k] += a[i + k] * b[i + k];
  return ((sum[0] + sum[4]) + (sum[1] + sum[5])) + ((sum[2] + sum[6]) + (sum[3] + sum[7]));
}

}  // namespace

Sums& Sums::operator+=(const Sums& other) {
  for (std::size_t k = 0; k < gram.size(); ++k) gram[k] += other.gram[k];
  for (std::size_t s = 0; s < most_signals; ++s) {
    for (std::size_t k = 0; k < columns; ++k) moment[s][k] += other.moment[s][k];
    square[s] += other.square[s];
  }
  samples += other.samples;
  return *this;
}

#if defined(__x86_64__) && defined(__ELF__) && !defined(__SANITIZE_THREAD__)  // as in math/random.cpp
[[gnu::target_clones("arch=x86-64-v3", "default")]]
#endif
void add_to(Sums& sums, const Block& block) {
  alignas(64) Work work;
  for (std::size_t first = 0; first < block.samples; first += batch) {
    const std::size_t count = std::min(batch, block.samples - first);
    sums.samples += fill(block, first, count, work);
    std::size_t at = 0;
    for (std::size_t a = 0; a < columns; ++a)
      for (std::size_t b = a; b < columns; ++b) sums.gram[at++] += product(work[a], work[b]);
    for (std::size_t s = 0; s < block.signals; ++s) {
      const double* y = work[columns + s];
      for (std::size_t a = 0; a < columns; ++a) sums.moment[s][a] += product(work[a], y);
      sums.square[s] += product(y, y);
    }
  }
}

}  // namespace tumble::dtg_centrifuge
