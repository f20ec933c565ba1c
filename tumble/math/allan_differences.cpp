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

/// The same of one factor in `rows` rows that lie a factor apart, `count` terms of each: a value that has a part in the
/// terms of three rows is loaded once for all.
template <std::size_t rows, Form form>
[[gnu::always_inline]] inline void add_rows_in_lanes(const double* a, std::size_t factor, std::size_t count,
                                                     double* sum) {
  constexpr std::size_t width = 4;
  Lanes squares[rows] = {};
  std::size_t n = 0;
  for (; n + width <= count; n += width) {
#pragma GCC unroll 4
    for (std::size_t k = 0; k < rows; ++k) {
      const double* const p = a + n + k * factor;
      Lanes z;
      second_difference<form>(p, p + factor, p + 2 * factor, z);
      squares[k] += z * z;
    }
  }
  for (std::size_t k = 0; k < rows; ++k) {
    double part = (squares[k][0] + squares[k][1]) + (squares[k][2] + squares[k][3]);
    for (std::size_t i = n; i < count; ++i) {
      const double* const p = a + i + k * factor;
      const double z = (p[0] + p[2 * factor]) - 2.0 * p[factor];
      part += z * z;
    }
    *sum += part;
  }
}

constexpr std::size_t most_rows = 4;

template <Form form>
[[gnu::always_inline]] inline void add_some_rows(const double* a, std::size_t factor, std::size_t rows,
                                                 std::size_t count, double* sum) {
  switch (rows) {
    case 1:
      return add_rows_in_lanes<1, form>(a, factor, count, sum);
    case 2:
      return add_rows_in_lanes<2, form>(a, factor, count, sum);
    case 3:
      return add_rows_in_lanes<3, form>(a, factor, count, sum);
    default:
      return add_rows_in_lanes<most_rows, form>(a, factor, count, sum);
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

[[gnu::target("avx2,fma")]] void add_rows_avx2(const double* a, std::size_t factor, std::size_t rows, std::size_t count,
                                               double* sum) {
  add_some_rows<Form::fused>(a, factor, rows, count, sum);
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

void add_row_squares(const double* a, std::size_t factor, std::size_t rows, std::size_t count, double* sum) {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    return add_rows_avx2(a, factor, rows, count, sum);
#endif
  add_some_rows<Form::two_steps>(a, factor, rows, count, sum);
}

/// Factors up to `longest` are worked through by pieces of so many terms, and within these by blocks, so that what is
/// touched again is still in a cache. Both are fixed: the sums do not depend on the number of threads.
struct Group {
  std::size_t longest, piece, block;
  bool by_rows;  ///< blocks of columns one factor after the other, else of terms for all factors
};
constexpr std::size_t whole = ~std::size_t{0};
constexpr std::array<Group, 5> groups{{{512, 65536, 2048, false},     // 32 kB
                                       {2048, 65536, 16384, false},   // 1 MB
                                       {16384, 65536, 2048, true},    // 1 MB
                                       {131072, 524288, 2048, true},  // 32 MB
                                       {whole, 1048576, 2048, true}}};

/// Adds terms [first, last) of ascending factors, `block` terms at a time.
void add_by_blocks(std::span<const double> x, std::span<const std::size_t> factors, std::size_t first, std::size_t last,
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

/// Adds `count` terms of one factor: rows of `factor` terms, `block` columns of all rows at a time, then the rest.
void add_by_rows(const double* x, std::size_t factor, std::size_t count, std::size_t block, double* sum) {
  const std::size_t rows = count / factor;
  for (std::size_t column = 0; rows > 0 && column < factor; column += block)
    for (std::size_t row = 0; row < rows; row += most_rows)
      add_row_squares(x + row * factor + column, factor, std::min(most_rows, rows - row),
                      std::min(block, factor - column), sum);
  if (rows * factor < count) add_row_squares(x + rows * factor, factor, 1, count - rows * factor, sum);
}

void add_terms(std::span<const double> x, std::span<const std::size_t> factors, const Group& group, std::size_t first,
               double* sums) {
  const std::size_t last = std::min(x.size(), first + group.piece);
  if (!group.by_rows) return add_by_blocks(x, factors, first, last, group.block, sums);
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const std::size_t terms = x.size() > 2 * factors[i] ? x.size() - 2 * factors[i] : 0;
    if (first < terms) add_by_rows(x.data() + first, factors[i], std::min(last, terms) - first, group.block, sums + i);
  }
}

/// The terms of a group's factors that start in one piece.
struct Task {
  const Group* group;
  std::size_t from, to;  ///< factors
  std::size_t first;     ///< term
  std::size_t place;     ///< of its sums among the partial ones
};

/// Longest pieces first, so that none is left to one thread at the end.
std::vector<Task> tasks_of(std::size_t size, std::span<const std::size_t> factors) {
  std::vector<Task> tasks;
  std::size_t place = 0, to = factors.size();
  for (auto group = groups.rbegin(); group != groups.rend(); ++group) {
    const std::size_t shorter = std::next(group) == groups.rend() ? 0 : std::next(group)->longest;
    std::size_t from = to;
    while (from > 0 && factors[from - 1] > shorter) --from;
    for (std::size_t first = 0; from < to && first < size; first += group->piece, place += to - from)
      tasks.push_back({&*group, from, to, first, place});
    to = from;
  }
  return tasks;
}

double largest_of(std::span<const double> x) {
  double most = 0.0;
  for (const double value : x) most = std::abs(value) > most ? std::abs(value) : most;
  return most;
}

/// The sum by differences of neighbouring values, which are exact.
double careful_sum(std::span<const double> x, std::size_t factor) {
  constexpr std::size_t piece = 65536;
  const std::size_t terms = x.size() > 2 * factor ? x.size() - 2 * factor : 0;
  std::vector<double> exact((terms + piece - 1) / piece, 0.0);
  parallel_pieces(terms, piece, [&](std::size_t first, std::size_t last) {
    exact[first / piece] = second_difference_squares(x.data() + first, factor, last - first);
  });
  return std::accumulate(exact.begin(), exact.end(), 0.0);
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
  if (x.empty() || factors.empty()) return;
  const auto tasks = tasks_of(x.size(), factors);
  std::vector<double> partial(tasks.back().place + tasks.back().to - tasks.back().from, 0.0);
  std::vector<double> largest(tasks.size(), 0.0);
  parallel_for(tasks.size(), [&](std::size_t t) {
    const Task& task = tasks[t];
    if (task.from == 0)  // pieces that are in a cache anyway, and together all of the phase
      largest[t] = largest_of(x.subspan(task.first, std::min(task.group->piece, x.size() - task.first)));
    add_terms(x, factors.subspan(task.from, task.to - task.from), *task.group, task.first, partial.data() + task.place);
  });
  std::vector<double> found(factors.size(), 0.0);
  for (const Task& task : tasks)
    for (std::size_t i = task.from; i < task.to; ++i) found[i] += partial[task.place + i - task.from];
  // The sum of the outer two values rounds by about half an epsilon of them, which is 1e-11 of the sum at most.
  const double rounding = std::numeric_limits<double>::epsilon() * *std::max_element(largest.begin(), largest.end());
  for (std::size_t i = 0; i < factors.size(); ++i)
    sums[i] += rounding > 1e-11 * std::sqrt(found[i]) ? careful_sum(x, factors[i]) : found[i];
}

std::vector<double> second_difference_sums(const Phase& phase, std::span<const std::size_t> factors) {
  std::vector<double> sums(factors.size(), 0.0);
  for (const auto& run : phase.runs) {
    add_second_differences({phase.values.data() + run.first, run.points()}, factors, sums);
  }
  return sums;
}

}  // namespace tumble
