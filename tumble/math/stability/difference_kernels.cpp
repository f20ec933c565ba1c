#include "tumble/math/stability/difference_kernels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

namespace tumble {
namespace {

// Registers of SSE2 or Neon, of AVX2 and of AVX-512.
using Two = double __attribute__((vector_size(16)));
using Four = double __attribute__((vector_size(32)));
using Eight = double __attribute__((vector_size(64)));

template <class Lanes>
constexpr std::size_t width = sizeof(Lanes) / sizeof(double);

template <class Lanes>
[[gnu::always_inline]] inline void load(const double* from, Lanes& lanes) {
  std::memcpy(&lanes, from, sizeof lanes);
}

/// Whether square and sum are rounded once: where the processor does that by itself. std::fma takes a hundred times as
/// long where it does not.
#ifdef __FP_FAST_FMA
template <class Lanes>
constexpr bool fused = true;
#else
template <class Lanes>
constexpr bool fused = width<Lanes> > 2;
#endif

/// sum += z z
template <class Lanes>
[[gnu::always_inline]] inline void add_square(double z, double& sum) {
  sum = fused<Lanes> ? std::fma(z, z, sum) : sum + z * z;
}

template <class Lanes>
[[gnu::always_inline]] inline void add_square(const Lanes& z, Lanes& sum) {
  if constexpr (!fused<Lanes>) {
    sum += z * z;
    return;
  }
#if defined(__x86_64__) && !defined(__clang__)  // clang takes no such operand without AVX2 for the whole file
  if constexpr (fused<Lanes>) {
    Lanes next = sum;
    asm("vfmadd231pd %1, %1, %0" : "+v"(next) : "v"(z));
    sum = next;
    return;
  }
#endif
  for (std::size_t i = 0; i < width<Lanes>; ++i) sum[i] = std::fma(z[i], z[i], sum[i]);
}

/// Keeps what is used twice from being loaded twice, which GCC thinks cheaper.
template <class Lanes>
[[gnu::always_inline]] inline void keep([[maybe_unused]] Lanes& lanes) {
#if defined(__x86_64__) && !defined(__clang__)
  asm("" : "+v"(lanes));
#endif
}

template <std::size_t together, class Lanes>
[[gnu::always_inline]] inline void add_in_lanes(const double* x, const std::size_t* lags, const std::size_t* into,
                                                std::size_t count, EightSums* squares) {
  constexpr std::size_t beside = 8 / width<Lanes>;
  std::size_t n = 0;
  while (n + 8 <= count) {
    const std::size_t end = n + std::min(count - n, 8 * DifferenceKernels::chain);
    Lanes sums[together][beside] = {};
    for (; n + 8 <= end; n += 8) {
#pragma GCC unroll 4
      for (std::size_t k = 0; k < beside; ++k) {
        Lanes first;
        load(x + n + k * width<Lanes>, first);
#pragma GCC unroll 12
        for (std::size_t g = 0; g < together; ++g) {
          Lanes z;
          load(x + n + k * width<Lanes> + lags[g], z);
          add_square<Lanes>(first - z, sums[g][k]);
        }
      }
    }
    for (std::size_t g = 0; g < together; ++g) {
      auto& all = squares[into[g]].values;
      for (std::size_t lane = 0; lane < 8; ++lane) all[lane] += sums[g][lane / width<Lanes>][lane % width<Lanes>];
    }
  }
  for (std::size_t g = 0; g < together; ++g)
    for (std::size_t i = n; i < count; ++i) add_square<Lanes>(x[i] - x[i + lags[g]], squares[into[g]].values[i - n]);
}

template <std::size_t lines, class Lanes>
[[gnu::always_inline]] inline void put_some(const double* x, std::size_t step, std::size_t rows, Line* tile) {
  constexpr std::size_t parts = 8 / width<Lanes>;  // of a line
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t k = 0; k < parts * lines; ++k)
      std::memcpy(tile[k / parts * rows + row].values + k % parts * width<Lanes>, x + row * step + k * width<Lanes>,
                  sizeof(Lanes));
}

template <class Lanes>
[[gnu::always_inline]] inline void put_in_lanes(const double* x, std::size_t step, std::size_t rows, std::size_t lines,
                                                Line* tile) {
  if (lines == DifferenceKernels::many_lines)
    return put_some<DifferenceKernels::many_lines, Lanes>(x, step, rows, tile);
  for (std::size_t k = 0; k < lines; ++k) put_some<1, Lanes>(x + 8 * k, step, rows, tile + k * rows);
}

template <class Lanes>
[[gnu::always_inline]] inline double second_in_lanes(const double* x, std::size_t m, std::size_t count) {
  constexpr std::size_t lanes = 16, beside = lanes / width<Lanes>;
  Lanes squares[beside] = {};
  std::size_t n = 0;
  for (; n + lanes <= count; n += lanes) {
#pragma GCC unroll 8
    for (std::size_t k = 0; k < beside; ++k) {
      const double* const p = x + n + k * width<Lanes>;
      Lanes first, middle, last;
      load(p, first);
      load(p + m, middle);
      load(p + 2 * m, last);
      keep(middle);
      add_square<Lanes>((first - middle) + (last - middle), squares[k]);
    }
  }
  double sums[lanes];
  std::memcpy(sums, squares, sizeof sums);
  for (std::size_t half = lanes / 2; half > 0; half /= 2)
    for (std::size_t i = 0; i < half; ++i) sums[i] += sums[i + half];
  for (; n < count; ++n) add_square<Lanes>((x[n] - x[n + m]) + (x[n + 2 * m] - x[n + m]), sums[0]);
  return sums[0];
}

// The same loops, compiled for a processor each.

template <std::size_t together>
void add_plain(const double* x, const std::size_t* lags, const std::size_t* into, std::size_t count, EightSums* sums) {
  add_in_lanes<together, Two>(x, lags, into, count, sums);
}
void put_plain(const double* x, std::size_t step, std::size_t rows, std::size_t lines, Line* tile) {
  put_in_lanes<Two>(x, step, rows, lines, tile);
}
double second_plain(const double* x, std::size_t m, std::size_t count) { return second_in_lanes<Two>(x, m, count); }

#ifdef __x86_64__
template <std::size_t together>
[[gnu::target("avx2,fma")]] void add_avx2(const double* x, const std::size_t* lags, const std::size_t* into,
                                          std::size_t count, EightSums* sums) {
  add_in_lanes<together, Four>(x, lags, into, count, sums);
}
[[gnu::target("avx2,fma")]] void put_avx2(const double* x, std::size_t step, std::size_t rows, std::size_t lines,
                                          Line* tile) {
  put_in_lanes<Four>(x, step, rows, lines, tile);
}
[[gnu::target("avx2,fma")]] double second_avx2(const double* x, std::size_t m, std::size_t count) {
  return second_in_lanes<Four>(x, m, count);
}

template <std::size_t together>
[[gnu::target("avx512f,fma")]] void add_avx512(const double* x, const std::size_t* lags, const std::size_t* into,
                                               std::size_t count, EightSums* sums) {
  add_in_lanes<together, Eight>(x, lags, into, count, sums);
}
[[gnu::target("avx512f,fma")]] void put_avx512(const double* x, std::size_t step, std::size_t rows, std::size_t lines,
                                               Line* tile) {
  put_in_lanes<Eight>(x, step, rows, lines, tile);
}
[[gnu::target("avx512f,fma")]] double second_avx512(const double* x, std::size_t m, std::size_t count) {
  return second_in_lanes<Eight>(x, m, count);
}
#endif

/// Without a destructor: threads may work on while the program ends.
struct Found {
  std::array<DifferenceKernels, 3> kernels;
  std::size_t count = 0;
};

/// Twelve registers hold sums, of 16 or of 32: one register a lag, or two or four.
template <std::size_t... g>
Found find_kernels(std::index_sequence<g...>) {
  Found found{{DifferenceKernels{{&add_plain<g % 3 + 1>...}, 3, fused<Two>, &put_plain, &second_plain}}, 1};
#ifdef __x86_64__
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return found;
  found.kernels[found.count++] = {{&add_avx2<g % 6 + 1>...}, 6, true, &put_avx2, &second_avx2};
  if (__builtin_cpu_supports("avx512f"))
    found.kernels[found.count++] = {{&add_avx512<g + 1>...}, 12, true, &put_avx512, &second_avx512};
#endif
  return found;
}

}  // namespace

std::span<const DifferenceKernels> all_difference_kernels() {
  static const Found found = find_kernels(std::make_index_sequence<DifferenceKernels::registers>());
  return {found.kernels.data(), found.count};
}

}  // namespace tumble
