#include "tumble/math/allan_phase.hpp"

#ifdef __linux__
#include <sys/mman.h>
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <string>

#include "tumble/math/parallel.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr std::size_t chunk = 1024;   // samples summed without carrying
constexpr std::size_t piece = 65536;  // samples or terms a task: fixed, so that the sums do not depend on threads

/// Runs body(first, last) over [0, count) in pieces.
template <class Body>
void in_pieces(std::size_t count, std::size_t length, const Body& body) {
  parallel_for((count + length - 1) / length,
               [&](std::size_t k) { body(k * length, std::min(count, (k + 1) * length)); });
}

/// Samples of a chunk less `origin`, summed; `present` of them are not missing.
struct ChunkSum {
  double sum = 0.0;
  std::size_t present = 0;
};

ChunkSum sum_of_chunk(std::span<const double> rate, double origin) {
  constexpr std::size_t lanes = 8;
  double sums[lanes] = {};
  std::size_t n = 0;
  for (; n + lanes <= rate.size(); n += lanes) {
    for (std::size_t k = 0; k < lanes; ++k) sums[k] += rate[n + k] - origin;
  }
  for (; n < rate.size(); ++n) sums[0] += rate[n] - origin;
  const double sum = ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]));
  if (!std::isnan(sum)) return {sum, rate.size()};
  ChunkSum result;
  for (const double value : rate) {
    if (std::isnan(value)) continue;
    result.sum += value - origin;
    ++result.present;
  }
  return result;
}

/// x_n = offset + sum_{i<n} (rate_i - mean), missing samples taken as the mean. Four stretches at a time, each of which
/// then starts where the one before ends.
void integrate_chunk(std::span<const double> rate, double mean, double offset, bool missing, double* x) {
  constexpr std::size_t stretches = 4;
  const std::size_t length = rate.size() / stretches;
  if (missing || rate.size() % stretches != 0) {
    double part = 0.0;
    for (std::size_t n = 0; n < rate.size(); ++n) {
      x[n] = offset + part;
      if (!std::isnan(rate[n])) part += rate[n] - mean;
    }
    return;
  }
  double parts[stretches] = {};
  for (std::size_t n = 0; n < length; ++n) {
    for (std::size_t k = 0; k < stretches; ++k) {
      x[k * length + n] = parts[k];
      parts[k] += rate[k * length + n] - mean;
    }
  }
  double before = 0.0;
  for (std::size_t k = 0; k < stretches; ++k) {
    for (std::size_t n = 0; n < length; ++n) x[k * length + n] = offset + (before + x[k * length + n]);
    before += parts[k];
  }
}

std::vector<PhaseRun> runs_without_nan(std::span<const double> rate, std::span<const ChunkSum> chunks) {
  std::vector<PhaseRun> runs;
  std::size_t first = 0;
  const auto end_run = [&](std::size_t n) {
    if (n > first) runs.push_back({first, n});
    first = n + 1;
  };
  for (std::size_t k = 0; k < chunks.size(); ++k) {
    const std::size_t end = std::min(rate.size(), (k + 1) * chunk);
    if (chunks[k].present == end - k * chunk) continue;
    for (std::size_t n = k * chunk; n < end; ++n) {
      if (std::isnan(rate[n])) end_run(n);
    }
  }
  end_run(rate.size());
  return runs;
}

/// Mean of the first samples that are there: about the mean of all.
double rough_mean(std::span<const double> rate) {
  const auto first = std::find_if(rate.begin(), rate.end(), [](double value) { return !std::isnan(value); });
  const auto some = rate.subspan(static_cast<std::size_t>(first - rate.begin()))
                        .first(std::min<std::size_t>(chunk, static_cast<std::size_t>(rate.end() - first)));
  const auto sum = sum_of_chunk(some, 0.0);
  return sum.present > 0 ? sum.sum / static_cast<double>(sum.present) : 0.0;
}

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

/// Room for the values, from the start of a line of the cache on; of a long record in large pages, which are handed
/// over in a third of the time (47 ms for 22 ms, 1e7 samples with their sum).
double* allocate(Phase& phase, std::size_t size) {
  constexpr std::size_t large_page = std::size_t{1} << 21;
  const std::size_t alignment = size * sizeof(double) > 4 * large_page ? large_page : std::size_t{64};
  const std::size_t extra = alignment / sizeof(double);
  phase.storage = std::make_unique_for_overwrite<double[]>(size + extra);
  void* start = phase.storage.get();
  std::size_t room = (size + extra) * sizeof(double);
  std::align(alignment, size * sizeof(double), start, room);
#ifdef __linux__
  if (alignment == large_page) madvise(start, size * sizeof(double), MADV_HUGEPAGE);  // an advice: may be ignored
#endif
  double* const values = static_cast<double*>(start);
  phase.values = {values, size};
  return values;
}

}  // namespace

Phase integrate_rate(std::span<const double> rate, std::size_t fewest) {
  const double origin = rough_mean(rate);
  std::vector<ChunkSum> chunks((rate.size() + chunk - 1) / chunk);
  in_pieces(chunks.size(), piece / chunk, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      chunks[k] = sum_of_chunk(rate.subspan(k * chunk, std::min(chunk, rate.size() - k * chunk)), origin);
    }
  });
  std::size_t present = 0;
  long double sum = 0.0L;
  for (const auto& part : chunks) {
    present += part.present;
    sum += part.sum;
  }
  if (present < fewest) {
    throw Error(Error::Kind::bad_data, "a stability deviation needs at least " + std::to_string(fewest) +
                                           " samples, there are " + std::to_string(present));
  }
  const double mean = origin + static_cast<double>(sum / static_cast<long double>(present));
  if (!std::isfinite(static_cast<double>(sum)) || !std::isfinite(mean)) {
    const auto bad = std::find_if(rate.begin(), rate.end(), [](double value) { return std::isinf(value); });
    throw Error(Error::Kind::bad_data, "infinite or overflowing value at sample " + std::to_string(bad - rate.begin()));
  }

  Phase phase;
  phase.runs = runs_without_nan(rate, chunks);
  double* const x = allocate(phase, rate.size() + 1);
  const long double step = static_cast<long double>(mean) - origin;
  std::vector<double> offsets(chunks.size());
  long double carried = 0.0L;
  for (std::size_t k = 0; k < chunks.size(); ++k) {
    offsets[k] = static_cast<double>(carried);
    carried += chunks[k].sum - step * static_cast<long double>(chunks[k].present);
  }
  x[rate.size()] = static_cast<double>(carried);
  in_pieces(chunks.size(), piece / chunk, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      const auto some = rate.subspan(k * chunk, std::min(chunk, rate.size() - k * chunk));
      integrate_chunk(some, mean, offsets[k], chunks[k].present != some.size(), x + k * chunk);
    }
  });
  return phase;
}

double remove_quadratic(std::span<double> x) {
  // Discrete orthogonal polynomials 1, t, t^2 - <t^2> on t = -1 ... 1.
  if (x.size() < 2) return 0.0;
  const double count = static_cast<double>(x.size());
  const double scale = 2.0 / (count - 1.0);
  const auto at = [&](std::size_t i) { return scale * static_cast<double>(i) - 1.0; };
  const double square = (count + 1.0) / (3.0 * (count - 1.0));  // <t^2>
  double p0 = 0.0, p1 = 0.0, p2 = 0.0, n1 = 0.0, n2 = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double t = at(i), q = t * t - square;
    p0 += x[i];
    p1 += x[i] * t;
    p2 += x[i] * q;
    n1 += t * t;
    n2 += q * q;
  }
  const double c0 = p0 / count, c1 = p1 / n1, c2 = n2 > 0.0 ? p2 / n2 : 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] -= c0 + c1 * at(i) + c2 * (at(i) * at(i) - square);
  return c2 * scale * scale;
}

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
  in_pieces(x.size(), piece, [&](std::size_t first, std::size_t last) {
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
      in_pieces(terms, piece, [&](std::size_t first, std::size_t last) {
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
