#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace tumble {

/// Eight sums beside each other.
struct alignas(64) EightSums {
  std::array<double, 8> values{};
};

/// A line of the cache.
struct alignas(64) Line {
  double values[8];
};

/// The innermost loops over squared differences, in the widest registers of a processor. Lanes and order of addition
/// are fixed, so that the result does not depend on the processor, except for one whose sums are not `fused`.
struct DifferenceKernels {
  static constexpr std::size_t registers = 12;  ///< that hold sums
  static constexpr std::size_t chain = 64;      ///< squares that a lane takes before it is added to what is there

  /// squares[into[g]] += sum_{n<count} (x_{n + lags[g]} - x_n)^2, in lanes n mod 8. Entry k takes k + 1 lags, which
  /// share the first value of their differences; `most_together` of the entries are meant.
  std::array<void (*)(const double* x, const std::size_t* lags, const std::size_t* into, std::size_t count,
                      EightSums* squares),
             registers>
      add_lags{};
  std::size_t most_together = 0;
  bool fused = false;  ///< squares are rounded together with their sum, as every processor does that has AVX2 or Neon

  /// Columns that lie beside each other, of rows `step` values apart, line by line; quickest for `many_lines`.
  static constexpr std::size_t many_lines = 8;
  void (*put_lines)(const double* x, std::size_t step, std::size_t rows, std::size_t lines, Line* tile) = nullptr;

  /// sum_{n<count} ((x_n - x_{n+m}) + (x_{n+2m} - x_{n+m}))^2: differences of values near each other are exact, which
  /// the sum of the outer two is not.
  double (*second_differences)(const double* x, std::size_t m, std::size_t count) = nullptr;
};

/// Kernels that this processor can run, the fastest last; their sums are of numbers [u]. Chosen by hand: the resolver
/// of target_clones runs before a thread sanitiser is ready.
std::span<const DifferenceKernels> all_difference_kernels();

inline const DifferenceKernels& difference_kernels() { return all_difference_kernels().back(); }

}  // namespace tumble
