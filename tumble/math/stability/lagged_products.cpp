#include "tumble/math/stability/lagged_products.hpp"

#include <algorithm>
#include <bit>
#include <complex>
#include <cstring>

#define POCKETFFT_NO_MULTITHREADING
#include <pocketfft/pocketfft_hdronly.h>

#include "tumble/math/parallel.hpp"

namespace tumble {
namespace {

constexpr std::size_t shortest_block = 256;  // a triangle of this size is summed directly
constexpr std::size_t most_blocks = 64;      // blocks a side that a triangle or rectangle is cut into
constexpr std::size_t step = 8;              // complex values that the multiplication works through at a time

/// A line of the cache.
struct Line {
  alignas(64) double values[8] = {};
};

/// Transforms of length 2 L, real ones stored by their first L + 1 values, with zeros up to a whole number of steps.
struct Spectra {
  std::size_t length = 0;  ///< L
  std::size_t count = 0;
  std::vector<Line> lines;  ///< real, imaginary, real, ...

  Spectra(std::size_t half, std::size_t number) : length(half), count(number), lines(number * stride() / 8) {}
  std::size_t stride() const { return 2 * (length + step); }
  double* at(std::size_t k) { return lines.data()->values + k * stride(); }
  const double* at(std::size_t k) const { return lines.data()->values + k * stride(); }
};

/// Runs body(first, last) over [0, count) in pieces of `piece`, on all threads or, within a thread, one after the
/// other.
template <class Body>
void in_pieces(std::size_t count, std::size_t piece, bool threads, const Body& body) {
  if (threads) return parallel_pieces(count, piece, body);
  for (std::size_t k = 0; k < count; k += piece) body(k, std::min(count, k + piece));
}

pocketfft::stride_t strides(std::size_t across, std::size_t along) {
  return {static_cast<std::ptrdiff_t>(across), static_cast<std::ptrdiff_t>(along)};
}

/// Where the stretches of a series lie that are transformed: at first + k hop, k = 0 ... count-1, `used` values of
/// each.
struct Stretches {
  std::size_t first = 0, hop = 0, used = 0, count = 0;
};

/// Their spectra, of length 2 L, zero beyond `used` and beyond the end of x.
Spectra spectra(std::span<const double> x, const Stretches& stretches, std::size_t length, bool threads) {
  const auto [first, hop, used, count] = stretches;
  Spectra result(length, count);
  in_pieces(count, 8, threads, [&](std::size_t from, std::size_t to) {
    std::vector<double> room((to - from) * 2 * length);
    for (std::size_t k = from; k < to; ++k) {
      const std::size_t start = first + k * hop;
      if (start >= x.size()) continue;
      std::copy_n(x.data() + start, std::min(used, x.size() - start), room.data() + (k - from) * 2 * length);
    }
    pocketfft::r2c<double>({to - from, 2 * length}, strides(2 * length * sizeof(double), sizeof(double)),
                           strides(result.stride() * sizeof(double), 2 * sizeof(double)), 1, true, room.data(),
                           reinterpret_cast<std::complex<double>*>(result.at(from)), 1.0);
  });
  return result;
}

using Lanes = double __attribute__((vector_size(32)));

/// out = sum_{a<count} conj(A_a) B_a over `step` complex values, A_a and B_a `stride` apart. The order of addition is
/// fixed and nothing is fused, so that the result is the same on every processor.
[[gnu::always_inline]] inline void multiply_in_lanes(const double* a, const double* b, std::size_t stride,
                                                     std::size_t count, double* out) {
  constexpr std::size_t lanes = step / 2;
  Lanes straight[lanes] = {}, crossed[lanes] = {};
  for (std::size_t k = 0; k < count; ++k) {
#pragma GCC unroll 4
    for (std::size_t i = 0; i < lanes; ++i) {
      Lanes u, v;
      std::memcpy(&u, a + k * stride + 4 * i, sizeof u);
      std::memcpy(&v, b + k * stride + 4 * i, sizeof v);
      straight[i] += u * v;
      crossed[i] += u * __builtin_shufflevector(v, v, 1, 0, 3, 2);
    }
  }
#pragma GCC unroll 4
  for (std::size_t i = 0; i < lanes; ++i) {
    const Lanes sum = {straight[i][0] + straight[i][1], crossed[i][0] - crossed[i][1], straight[i][2] + straight[i][3],
                       crossed[i][2] - crossed[i][3]};
    std::memcpy(out + 4 * i, &sum, sizeof sum);
  }
}

/// out[u] += sum_{i<u} a[i] b[i + u], u < count. Sixteen u at a time, each its own lane.
[[gnu::always_inline]] inline void triangle_in_lanes(const double* a, const double* b, std::size_t count, double* out) {
  constexpr std::size_t width = 16, lanes = width / 4;
  for (std::size_t start = 0; start < count; start += width) {
    double sums[width] = {};
    if (start + width <= count) {
      Lanes all[lanes] = {};
      for (std::size_t i = 0; i < start; ++i) {
        const Lanes u = {a[i], a[i], a[i], a[i]};
#pragma GCC unroll 4
        for (std::size_t k = 0; k < lanes; ++k) {
          Lanes v;
          std::memcpy(&v, b + i + start + 4 * k, sizeof v);
          all[k] += u * v;
        }
      }
      std::memcpy(sums, all, sizeof sums);
    }
    const std::size_t done = start + width <= count ? start : 0;
    for (std::size_t u = start; u < std::min(count, start + width); ++u) {
      for (std::size_t i = done; i < u; ++i) sums[u - start] += a[i] * b[i + u];
      out[u] += sums[u - start];
    }
  }
}

#ifdef __x86_64__
[[gnu::target("avx2")]] void triangle_avx2(const double* a, const double* b, std::size_t count, double* out) {
  triangle_in_lanes(a, b, count, out);
}
[[gnu::target("avx2")]] void multiply_avx2(const double* a, const double* b, std::size_t stride, std::size_t count,
                                           double* out) {
  multiply_in_lanes(a, b, stride, count, out);
}
#endif

void multiply(const double* a, const double* b, std::size_t stride, std::size_t count, double* out) {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2")) return multiply_avx2(a, b, stride, count, out);
#endif
  multiply_in_lanes(a, b, stride, count, out);
}

/// out[b L + u] += sum over blocks a < columns(b) and i in block a of x_i x_{i + b L + u}, for the blocks b of lags.
/// Window of block a of values and b of lags: number a + per_lag b.
template <class Columns>
void add_squares(const Spectra& blocks, const Spectra& windows, std::size_t lag_blocks, std::size_t per_lag,
                 const Columns& columns, bool threads, std::span<double> out) {
  const std::size_t length = blocks.length;
  Spectra sums(length, lag_blocks);
  // Few values of all spectra at a time: they are used for every pair while they are in the cache.
  in_pieces((length + step) / step, 4, threads, [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k) {
      for (std::size_t b = 0; b < lag_blocks; ++b) {
        multiply(blocks.at(0) + 2 * step * k, windows.at(per_lag * b) + 2 * step * k, sums.stride(), columns(b),
                 sums.at(b) + 2 * step * k);
      }
    }
  });
  in_pieces(lag_blocks, 8, threads, [&](std::size_t from, std::size_t to) {
    std::vector<double> room((to - from) * 2 * length);
    pocketfft::c2r<double>({to - from, 2 * length}, strides(sums.stride() * sizeof(double), 2 * sizeof(double)),
                           strides(2 * length * sizeof(double), sizeof(double)), 1, false,
                           reinterpret_cast<const std::complex<double>*>(sums.at(from)), room.data(),
                           1.0 / static_cast<double>(2 * length));
    for (std::size_t b = from; b < to; ++b) {
      for (std::size_t u = 0; u < length && b * length + u < out.size(); ++u) {
        out[b * length + u] += room[(b - from) * 2 * length + u];
      }
    }
  });
}

void triangle(const double* a, const double* b, std::size_t count, double* out) {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2")) return triangle_avx2(a, b, count, out);
#endif
  triangle_in_lanes(a, b, count, out);
}

/// Size of the squares that a side is cut into.
std::size_t block_length(std::size_t side) {
  return std::max(shortest_block, std::bit_ceil((side + most_blocks - 1) / most_blocks));
}

/// out[u] += sum_{i=first}^{first+u-1} x_i x_{i+first+u}: what is left on the diagonal, lag = first + u.
void add_triangle(std::span<const double> x, std::size_t first, std::span<double> out) {
  if (out.size() <= shortest_block) {
    triangle(x.data() + first, x.data() + 2 * first, out.size(), out.data());
    return;
  }
  const std::size_t length = block_length(out.size());
  const std::size_t count = (out.size() + length - 1) / length;
  const auto blocks = spectra(x, {first, length, length, count}, length, false);
  const auto windows = spectra(x, {2 * first, length, 2 * length, 2 * count}, length, false);
  add_squares(
      blocks, windows, count, 1, [](std::size_t b) { return b; }, false, out);
  for (std::size_t b = 0; b < count; ++b) {
    const std::size_t start = b * length;
    add_triangle(x, first + start, out.subspan(start, std::min(length, out.size() - start)));
  }
}

/// leading[m], from the spectra of the whole series.
std::vector<double> leading_products(std::span<const double> x, std::size_t longest, const Spectra& blocks,
                                     const Spectra& windows, bool threads) {
  std::vector<double> out(longest + 1, 0.0);
  const std::size_t length = blocks.length, count = longest / length + 1;
  add_squares(
      blocks, windows, count, 1, [](std::size_t b) { return b; }, threads, out);
  in_pieces(count, 1, threads, [&](std::size_t b, std::size_t) {
    const std::size_t start = b * length;
    add_triangle(x, start, std::span(out).subspan(start, std::min(length, out.size() - start)));
  });
  return out;
}

/// whole[0 ... longest], from the spectra of the whole series in `all` blocks.
std::vector<double> whole_products(const Spectra& blocks, const Spectra& windows, std::size_t longest, bool threads) {
  std::vector<double> out(longest + 1, 0.0);
  const std::size_t all = blocks.count;
  add_squares(
      blocks, windows, longest / blocks.length + 1, 1, [&](std::size_t b) { return all > b ? all - b : 0; }, threads,
      out);
  return out;
}

/// The values that are summed at each lag: i < share lag.
struct Share {
  std::size_t over = 1, under = 1;  ///< share = over/under; 1, 2 or 1/2

  std::size_t of(std::size_t lag) const { return lag * over / under; }
};

/// out[u] += sum_{i < share u} x_{a+i} x_{b+i+u}.
void add_share(std::span<const double> x, std::size_t a, std::size_t b, const Share& share, bool threads,
               std::span<double> out) {
  if (out.size() <= shortest_block) {
    for (std::size_t u = 0; u < out.size(); ++u)
      for (std::size_t i = 0; i < share.of(u); ++i) out[u] += x[a + i] * x[b + i + u];
    return;
  }
  // Blocks of `hop` values and of `length` lags: a corner of the region is a corner of a block.
  const std::size_t length = block_length(out.size()), hop = length / share.under;
  const std::size_t count = (out.size() + length - 1) / length, per_lag = length / hop;
  {
    const auto blocks = spectra(x, {a, hop, hop, count * share.over}, length, threads);
    const auto windows = spectra(x, {b, hop, hop + length, count * (share.over + per_lag)}, length, threads);
    add_squares(
        blocks, windows, count, per_lag, [&](std::size_t k) { return k * share.over; }, threads, out);
  }
  in_pieces(count, 1, threads, [&](std::size_t k, std::size_t) {
    const std::size_t lag = k * length, values = share.of(lag);
    add_share(x, a + values, b + values + lag, share, false, out.subspan(lag, std::min(length, out.size() - lag)));
  });
}

std::vector<double> share_of_products(std::span<const double> x, std::size_t longest, const Share& share,
                                      bool threads) {
  std::vector<double> out(longest + 1, 0.0);
  add_share(x, 0, 0, share, threads, out);
  return out;
}

ThirdProducts::Ends ends_of(std::span<const double> x, std::size_t longest, bool threads) {
  ThirdProducts::Ends ends{share_of_products(x, longest, {1, 1}, threads),
                           share_of_products(x, longest, {2, 1}, threads), std::vector<double>(longest + 1)};
  const auto half = share_of_products(x, 2 * longest, {1, 2}, threads);
  for (std::size_t m = 0; m <= longest; ++m) ends.half[m] = half[2 * m];
  return ends;
}

}  // namespace

LaggedProducts lagged_products(std::span<const double> x, std::size_t longest, bool threads) {
  LaggedProducts result;
  const std::size_t length = block_length(2 * longest + 1), all = (x.size() + length - 1) / length;
  {
    const auto blocks = spectra(x, {0, length, length, all}, length, threads);
    const auto windows = spectra(x, {0, length, 2 * length, all}, length, threads);
    result.whole = whole_products(blocks, windows, 2 * longest, threads);
    result.leading = leading_products(x, longest, blocks, windows, threads);
  }
  const std::size_t reach = std::min(x.size(), 2 * longest + 2 * length);
  const std::vector<double> backwards(x.rbegin(), x.rbegin() + static_cast<std::ptrdiff_t>(reach));
  const std::size_t count = longest / length + 1;
  const auto blocks = spectra(backwards, {0, length, length, count}, length, threads);
  const auto windows = spectra(backwards, {0, length, 2 * length, 2 * count}, length, threads);
  result.trailing = leading_products(backwards, longest, blocks, windows, threads);
  return result;
}

ThirdProducts third_products(std::span<const double> x, std::size_t longest, bool threads) {
  ThirdProducts result;
  const std::size_t length = block_length(3 * longest + 1), all = (x.size() + length - 1) / length;
  {
    const auto blocks = spectra(x, {0, length, length, all}, length, threads);
    const auto windows = spectra(x, {0, length, 2 * length, all}, length, threads);
    result.whole = whole_products(blocks, windows, 3 * longest, threads);
  }
  result.leading = ends_of(x, longest, threads);
  const std::size_t reach = std::min(x.size(), 3 * longest);
  result.trailing =
      ends_of(std::vector<double>(x.rbegin(), x.rbegin() + static_cast<std::ptrdiff_t>(reach)), longest, threads);
  return result;
}

}  // namespace tumble
