#include "tumble/math/allan_differences.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "tumble/math/parallel.hpp"

namespace tumble {
namespace {

constexpr std::size_t piece = 65536;  // terms a task: fixed, so that the sums do not depend on threads

using Lanes = double __attribute__((vector_size(32)));

/// How a - 2 b + c is worked out. Doubling is exact, so that the fused instruction rounds as the two that it stands
/// for. Differences of values near each other are exact as well, which the sum of the outer two is not.
enum class Form { fused, two_steps, differences };

template <Form form>
[[gnu::always_inline]] inline void second_difference(const double* a, const double* b, const double* c, Lanes& z) {
  Lanes middle, last;
  std::memcpy(&z, a, sizeof z);
  std::memcpy(&middle, b, sizeof middle);
  std::memcpy(&last, c, sizeof last);
  if constexpr (form == Form::differences) {
    z = (z - middle) + (last - middle);
    return;
  }
  z += last;
#ifdef __x86_64__
  if constexpr (form == Form::fused) {
    const Lanes two = {2.0, 2.0, 2.0, 2.0};
    asm("vfnmadd231pd %2, %1, %0" : "+x"(z) : "x"(two), "x"(middle));
    return;
  }
#endif
  z -= middle + middle;
}

/// sums[g] += sum (a_n - 2 a_{n+m} + a_{n+2m})^2, m = factors[g], over n < count. Lanes and order of addition are fixed
/// (and sums are not fused: see CMakeLists.txt), so the result does not depend on the processor that runs it.
template <std::size_t together, Form form>
[[gnu::always_inline]] inline void add_in_lanes(const double* a, const std::size_t* factors, std::size_t count,
                                                double* sums) {
  constexpr std::size_t width = 4;
  Lanes squares[together][2] = {};
  std::size_t n = 0;
  for (; n + 2 * width <= count; n += 2 * width) {
#pragma GCC unroll 2
    for (std::size_t k = 0; k < 2; ++k) {
      const double* const p = a + n + k * width;
#pragma GCC unroll 4
      for (std::size_t g = 0; g < together; ++g) {
        Lanes z;
        second_difference<form>(p, p + factors[g], p + 2 * factors[g], z);
        squares[g][k] += z * z;
      }
    }
  }
  for (std::size_t g = 0; g < together; ++g) {
    const Lanes both = squares[g][0] + squares[g][1];
    double sum = (both[0] + both[1]) + (both[2] + both[3]);
    for (std::size_t i = n; i < count; ++i) {
      const double middle = a[i + factors[g]], last = a[i + 2 * factors[g]];
      const double z = form == Form::differences ? (a[i] - middle) + (last - middle) : (a[i] + last) - 2.0 * middle;
      sum += z * z;
    }
    sums[g] += sum;
  }
}

constexpr std::size_t most_together = 4;  // factors that share the first value of their terms

template <Form form>
[[gnu::always_inline]] inline void add_together(const double* a, const std::size_t* factors, std::size_t together,
                                                std::size_t count, double* sums) {
  switch (together) {
    case 1:
      return add_in_lanes<1, form>(a, factors, count, sums);
    case 2:
      return add_in_lanes<2, form>(a, factors, count, sums);
    case 3:
      return add_in_lanes<3, form>(a, factors, count, sums);
    default:
      return add_in_lanes<most_together, form>(a, factors, count, sums);
  }
}

#ifdef __x86_64__
/// The same operations in wider registers.
[[gnu::target("avx2,fma")]] void add_avx2(const double* a, const std::size_t* factors, std::size_t together,
                                          std::size_t count, double* sums) {
  add_together<Form::fused>(a, factors, together, count, sums);
}

[[gnu::target("avx2")]] void add_differences_avx2(const double* a, std::size_t factor, std::size_t count, double* sum) {
  add_in_lanes<1, Form::differences>(a, &factor, count, sum);
}
#endif

// Chosen at run time by hand: the resolver of target_clones runs before a thread sanitiser is ready for it.
void add_squares(const double* a, const std::size_t* factors, std::size_t together, std::size_t count, double* sums) {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    return add_avx2(a, factors, together, count, sums);
#endif
  add_together<Form::two_steps>(a, factors, together, count, sums);
}

/// Adds terms [first, last) of ascending factors, `block` terms at a time.
void add_terms(std::span<const double> x, std::span<const std::size_t> factors, std::size_t first, std::size_t last,
               std::size_t block, double* sums) {
  const auto terms = [&](std::size_t i, std::size_t start) {
    const std::size_t reach = std::min(x.size(), start + block + 2 * factors[i]);
    const std::size_t end = std::min(last, reach > 2 * factors[i] ? reach - 2 * factors[i] : 0);
    return end > start ? end - start : 0;
  };
  for (std::size_t start = first; start < last; start += block) {
    for (std::size_t i = 0; i < factors.size();) {
      const std::size_t count = terms(i, start);
      if (count == 0) break;
      std::size_t together = 1;
      while (together < most_together && i + together < factors.size() && terms(i + together, start) == count)
        ++together;
      add_squares(x.data() + start, factors.data() + i, together, count, sums + i);
      i += together;
    }
  }
}

}  // namespace

double second_difference_squares(const double* x, std::size_t factor, std::size_t count) {
  double sum = 0.0;
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2")) {
    add_differences_avx2(x, factor, count, &sum);
    return sum;
  }
#endif
  add_in_lanes<1, Form::differences>(x, &factor, count, &sum);
  return sum;
}

void add_second_differences(std::span<const double> x, std::span<const std::size_t> factors, std::span<double> sums) {
  // Longest factor of a group and terms a block: what the first two touch stays in a 32 kB and a 512 kB cache.
  if (x.empty()) return;
  struct Group {
    std::size_t longest, block;
  };
  constexpr std::array<Group, 3> groups{{{512, 2048}, {16384, 16384}, {~std::size_t{0}, piece}}};
  const std::size_t pieces = (x.size() + piece - 1) / piece, count = factors.size();
  std::vector<double> partial(pieces * count, 0.0), largest(pieces, 0.0);
  parallel_pieces(x.size(), piece, [&](std::size_t first, std::size_t last) {
    double* const of_piece = partial.data() + first / piece * count;
    double most = 0.0;
    for (std::size_t n = first; n < last; ++n) most = std::abs(x[n]) > most ? std::abs(x[n]) : most;
    largest[first / piece] = most;
    std::size_t from = 0;
    for (const auto& group : groups) {
      std::size_t to = from;
      while (to < count && factors[to] <= group.longest) ++to;
      add_terms(x, factors.subspan(from, to - from), first, last, group.block, of_piece + from);
      from = to;
    }
  });
  // The sum of the outer two values rounds by about half an epsilon of them, which is 1e-11 of the sum at most.
  const double rounding = std::numeric_limits<double>::epsilon() * *std::max_element(largest.begin(), largest.end());
  for (std::size_t i = 0; i < count; ++i) {
    double sum = 0.0;
    for (std::size_t k = 0; k < pieces; ++k) sum += partial[k * count + i];
    if (rounding > 1e-11 * std::sqrt(sum)) {
      std::vector<double> exact(pieces, 0.0);
      const std::size_t terms = x.size() > 2 * factors[i] ? x.size() - 2 * factors[i] : 0;
      parallel_pieces(terms, piece, [&](std::size_t first, std::size_t last) {
        exact[first / piece] = second_difference_squares(x.data() + first, factors[i], last - first);
      });
      sum = std::accumulate(exact.begin(), exact.end(), 0.0);
    }
    sums[i] += sum;
  }
}

std::vector<double> second_difference_sums(const Phase& phase, std::span<const std::size_t> factors) {
  std::vector<double> sums(factors.size(), 0.0);
  for (const auto& run : phase.runs) {
    add_second_differences({phase.values.data() + run.first, run.points()}, factors, sums);
  }
  return sums;
}

}  // namespace tumble
