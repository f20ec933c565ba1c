#include "tumble/math/stability/allan_phase.hpp"

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <string>
#include <utility>

#include "tumble/math/parallel.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr std::size_t chunk = 1024;   // samples summed without carrying
constexpr std::size_t piece = 65536;  // samples or terms a task: fixed, so that the sums do not depend on threads

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

/// to_n = offset + (before + from_n), from the start of a line of the cache on. Past the caches: written straight to
/// memory, which otherwise is read before.
void put(const double* from, std::size_t count, double before, double offset, [[maybe_unused]] bool past_caches,
         double* to) {
  std::size_t n = 0;
#ifdef __SSE2__
  for (; past_caches && n + 2 <= count; n += 2)
    _mm_stream_pd(to + n, _mm_set1_pd(offset) + (_mm_set1_pd(before) + _mm_loadu_pd(from + n)));
#endif
  for (; n < count; ++n) to[n] = offset + (before + from[n]);
}

/// x_n = offset + sum_{i<n} (rate_i - mean), missing samples taken as the mean. Four stretches at a time, each of which
/// then starts where the one before ends.
void integrate_chunk(std::span<const double> rate, double mean, double offset, bool missing, bool past_caches,
                     double* x) {
  constexpr std::size_t stretches = 4;
  const std::size_t length = rate.size() / stretches;
  if (missing || rate.size() != chunk) {
    double part = 0.0;
    for (std::size_t n = 0; n < rate.size(); ++n) {
      x[n] = offset + part;
      if (!std::isnan(rate[n])) part += rate[n] - mean;
    }
    return;
  }
  std::array<double, chunk> sums;
  double parts[stretches] = {};
  for (std::size_t n = 0; n < length; ++n) {
    for (std::size_t k = 0; k < stretches; ++k) {
      sums[k * length + n] = parts[k];
      parts[k] += rate[k * length + n] - mean;
    }
  }
  double before = 0.0;
  for (std::size_t k = 0; k < stretches; ++k) {
    put(sums.data() + k * length, length, before, offset, past_caches, x + k * length);
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

std::span<const double> chunk_of(std::span<const double> rate, std::size_t k) {
  return rate.subspan(k * chunk, std::min(chunk, rate.size() - k * chunk));
}

/// Mean of a few hundred chunks, evenly over the record; of all of a short one.
double mean_of_some(std::span<const double> rate, std::size_t chunks) {
  const double origin = rough_mean(rate);
  ChunkSum some;
  for (std::size_t k = 0; k < chunks; k += chunks / 256 + 1) {
    const ChunkSum one = sum_of_chunk(chunk_of(rate, k), origin);
    some.sum += one.sum;
    some.present += one.present;
  }
  return some.present > 0 ? origin + some.sum / static_cast<double>(some.present) : origin;
}

/// Sum of all chunks, and of how many samples. Throws as integrate_rate.
std::pair<long double, std::size_t> total(std::span<const double> rate, std::span<const ChunkSum> chunks,
                                          std::size_t fewest) {
  std::size_t present = 0;
  long double sum = 0.0L;
  for (const auto& part : chunks) {
    present += part.present;
    sum += part.sum;
  }
  if (present < fewest) {
    throw Error(Error::Kind::bad_data,
                say("a stability deviation needs at least {} samples, there are {}", fewest, present));
  }
  if (!std::isfinite(static_cast<double>(sum))) {
    const auto bad = std::find_if(rate.begin(), rate.end(), [](double value) { return std::isinf(value); });
    throw Error(Error::Kind::bad_data, say("infinite or overflowing value at sample {}", bad - rate.begin()));
  }
  return {sum, present};
}

Phase room_for_phase(std::size_t points) {
  Phase phase;
  phase.storage = borrow_room(points);
  phase.values = {phase.storage.get(), points};
  return phase;
}

constexpr std::size_t chunks_of_piece = piece / chunk;

/// Integrates chunks [first, last) with x at the start of each.
void integrate_chunks(std::span<const double> rate, std::span<const ChunkSum> chunks, double mean, std::size_t first,
                      std::size_t last, const double* starts, double* x) {
  const bool past_caches = rate.size() > std::size_t{1} << 22;
  for (std::size_t k = first; k < last; ++k) {
    const auto some = chunk_of(rate, k);
    integrate_chunk(some, mean, starts[k - first], chunks[k].present != some.size(), past_caches, x + k * chunk);
  }
#ifdef __SSE2__
  _mm_sfence();
#endif
}

}  // namespace

Phase integrate_rate(std::span<const double> rate, std::size_t fewest) {
  const double origin = rough_mean(rate);
  std::vector<ChunkSum> chunks((rate.size() + chunk - 1) / chunk);
  parallel_pieces(chunks.size(), chunks_of_piece, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) chunks[k] = sum_of_chunk(chunk_of(rate, k), origin);
  });
  const auto [sum, present] = total(rate, chunks, fewest);
  const double mean = origin + static_cast<double>(sum / static_cast<long double>(present));
  const long double step = static_cast<long double>(mean) - origin;
  std::vector<double> starts(chunks.size());
  long double carried = 0.0L;
  for (std::size_t k = 0; k < chunks.size(); ++k) {
    starts[k] = static_cast<double>(carried);
    carried += chunks[k].sum - step * static_cast<long double>(chunks[k].present);
  }
  Phase phase = room_for_phase(rate.size() + 1);
  double* const x = phase.storage.get();
  x[rate.size()] = static_cast<double>(carried);
  parallel_pieces(chunks.size(), chunks_of_piece, [&](std::size_t first, std::size_t last) {
    integrate_chunks(rate, chunks, mean, first, last, starts.data() + first, x);
  });
  phase.runs = runs_without_nan(rate, chunks);
  return phase;
}

Phase integrate_rate_once(std::span<const double> rate, std::size_t fewest) {
  std::vector<ChunkSum> chunks((rate.size() + chunk - 1) / chunk);
  const double mean = mean_of_some(rate, chunks.size());
  Phase phase = room_for_phase(rate.size() + 1);
  double* const x = phase.storage.get();
  const std::size_t pieces = (chunks.size() + chunks_of_piece - 1) / chunks_of_piece;
  std::vector<long double> carried(pieces + 1, 0.0L);  // the integral at the start of each piece
  std::atomic<std::size_t> begun{0}, known{0};         // pieces; those whose start is known
  parallel_for(pieces, [&](std::size_t) {
    const std::size_t p = begun++;  // its own count: who is stopped before a piece takes none, and none waits in vain
    const std::size_t first = p * chunks_of_piece, last = std::min(chunks.size(), first + chunks_of_piece);
    for (std::size_t k = first; k < last; ++k) chunks[k] = sum_of_chunk(chunk_of(rate, k), mean);
    for (std::size_t at = known; at != p; at = known) known.wait(at);
    std::array<double, chunks_of_piece> starts;
    long double start = carried[p];
    for (std::size_t k = first; k < last; ++k) {
      starts[k - first] = static_cast<double>(start);
      start += chunks[k].sum;
    }
    carried[p + 1] = start;
    known = p + 1;
    known.notify_all();
    integrate_chunks(rate, chunks, mean, first, last, starts.data(), x);
  });
  total(rate, chunks, fewest);
  x[rate.size()] = static_cast<double>(carried.back());
  phase.runs = runs_without_nan(rate, chunks);
  return phase;
}

double remove_quadratic(std::span<double> x) {
  // Discrete orthogonal polynomials 1, t, t^2 - <t^2> on t = -1 ... 1.
  if (x.size() < 2) return 0.0;
  const double count = static_cast<double>(x.size());
  const double scale = 2.0 / (count - 1.0);
  const auto at = [&](std::size_t i) { return scale * static_cast<double>(i) - 1.0; };
  const double square = (count + 1.0) / (3.0 * (count - 1.0));  // <t^2>
  const double n1 = count * square, n2 = 4.0 / 5.0 * n1 * (count * count - 4.0) / (3.0 * (count - 1.0) * (count - 1.0));
  double p0 = 0.0, p1 = 0.0, p2 = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double t = at(i);
    p0 += x[i];
    p1 += x[i] * t;
    p2 += x[i] * (t * t - square);
  }
  const double c0 = p0 / count, c1 = p1 / n1, c2 = n2 > 0.0 ? p2 / n2 : 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] -= c0 + c1 * at(i) + c2 * (at(i) * at(i) - square);
  return c2 * scale * scale;
}

}  // namespace tumble
