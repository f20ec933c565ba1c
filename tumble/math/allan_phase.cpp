#include "tumble/math/allan_phase.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>

#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr std::size_t chunk = 1024;

std::vector<PhaseRun> runs_without_nan(std::span<const double> rate) {
  std::vector<PhaseRun> runs;
  std::size_t first = 0;
  for (std::size_t n = 0; n <= rate.size(); ++n) {
    if (n < rate.size() && !std::isnan(rate[n])) continue;
    if (n > first) runs.push_back({first, n});
    first = n + 1;
  }
  return runs;
}

/// Sum of samples that are there, in chunks so that rounding does not grow.
long double total(std::span<const double> rate, const PhaseRun& run) {
  long double sum = 0.0L;
  for (std::size_t n = run.first; n < run.last; n += chunk) {
    double part = 0.0;
    for (std::size_t i = n; i < std::min(run.last, n + chunk); ++i) part += rate[i];
    sum += part;
  }
  return sum;
}

using Lanes = double __attribute__((vector_size(32)));

/// sum (a - 2 b + c)^2 over `count` terms. Lanes and order of addition are fixed (and there is no fused multiply-add),
/// so the result does not depend on the processor that runs it.
[[gnu::always_inline]] inline double squares_in_lanes(const double* a, const double* b, const double* c,
                                                      std::size_t count) {
  constexpr std::size_t width = 4;
  Lanes sums[2] = {};
  std::size_t n = 0;
  for (; n + 2 * width <= count; n += 2 * width) {
    for (std::size_t k = 0; k < 2; ++k) {
      Lanes va, vb, vc;
      std::memcpy(&va, a + n + k * width, sizeof va);
      std::memcpy(&vb, b + n + k * width, sizeof vb);
      std::memcpy(&vc, c + n + k * width, sizeof vc);
      const Lanes z = (va - vb) + (vc - vb);
      sums[k] += z * z;
    }
  }
  const Lanes both = sums[0] + sums[1];
  double sum = (both[0] + both[1]) + (both[2] + both[3]);
  for (; n < count; ++n) {
    const double z = (a[n] - b[n]) + (c[n] - b[n]);
    sum += z * z;
  }
  return sum;
}

#ifdef __x86_64__
/// The same instructions in wider registers, which halves the time: 62 ms for 118 ms, 58 factors of 4.4e6 samples.
[[gnu::target("avx2")]] double squares_avx2(const double* a, const double* b, const double* c, std::size_t count) {
  return squares_in_lanes(a, b, c, count);
}
#endif

// Chosen at run time by hand: the resolver of target_clones runs before a thread sanitiser is ready for it.
double squares(const double* a, const double* b, const double* c, std::size_t count) {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2")) return squares_avx2(a, b, c, count);
#endif
  return squares_in_lanes(a, b, c, count);
}

/// Adds the terms of one run for factors [from, to), block by block: `block` terms at a time.
void add_run(std::span<const double> x, std::span<const std::size_t> factors, std::size_t block,
             std::span<double> sums) {
  for (std::size_t start = 0; start < x.size(); start += block) {
    for (std::size_t i = 0; i < factors.size(); ++i) {
      const std::size_t m = factors[i];
      if (x.size() <= start + 2 * m) break;
      const std::size_t count = std::min(block, x.size() - 2 * m - start);
      const double* const a = x.data() + start;
      sums[i] += squares(a, a + m, a + 2 * m, count);
    }
  }
}

}  // namespace

Phase integrate_rate(std::span<const double> rate, std::size_t fewest) {
  Phase phase;
  phase.runs = runs_without_nan(rate);
  std::size_t present = 0;
  long double sum = 0.0L;
  for (const auto& run : phase.runs) {
    present += run.points() - 1;
    sum += total(rate, run);
  }
  if (present < fewest) {
    throw Error(Error::Kind::bad_data, "a stability deviation needs at least " + std::to_string(fewest) +
                                           " samples, there are " + std::to_string(present));
  }
  if (!std::isfinite(static_cast<double>(sum))) {
    const auto bad = std::find_if(rate.begin(), rate.end(), [](double value) { return std::isinf(value); });
    throw Error(Error::Kind::bad_data, "infinite or overflowing value at sample " + std::to_string(bad - rate.begin()));
  }
  const double mean = static_cast<double>(sum / static_cast<long double>(present));

  phase.values.resize(rate.size() + 1);
  long double carried = 0.0L;
  for (std::size_t start = 0; start < rate.size(); start += chunk) {
    const double offset = static_cast<double>(carried);
    double part = 0.0;
    for (std::size_t n = start; n < std::min(rate.size(), start + chunk); ++n) {
      phase.values[n] = offset + part;
      if (!std::isnan(rate[n])) part += rate[n] - mean;
    }
    carried += part;
  }
  phase.values.back() = static_cast<double>(carried);
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

void add_second_differences(std::span<const double> x, std::span<const std::size_t> factors, std::span<double> sums) {
  // Longest factor of a group and terms a block: what the first two touch stays in a 32 kB and a 512 kB cache.
  struct Group {
    std::size_t longest, block;
  };
  constexpr std::array<Group, 3> groups{{{512, 2048}, {16384, 16384}, {~std::size_t{0}, 65536}}};
  std::size_t from = 0;
  for (const auto& group : groups) {
    std::size_t to = from;
    while (to < factors.size() && factors[to] <= group.longest) ++to;
    add_run(x, factors.subspan(from, to - from), group.block, sums.subspan(from, to - from));
    from = to;
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
