#include "tumble/math/allan_phase.hpp"

#include <algorithm>
#include <cmath>
#include <string>

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

}  // namespace

Phase integrate_rate(std::span<const double> rate, std::size_t fewest) {
  const double origin = rough_mean(rate);
  std::vector<ChunkSum> chunks((rate.size() + chunk - 1) / chunk);
  parallel_pieces(chunks.size(), piece / chunk, [&](std::size_t first, std::size_t last) {
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
  phase.storage = borrow_room(rate.size() + 1);
  double* const x = phase.storage.get();
  phase.values = {x, rate.size() + 1};
  const long double step = static_cast<long double>(mean) - origin;
  std::vector<double> offsets(chunks.size());
  long double carried = 0.0L;
  for (std::size_t k = 0; k < chunks.size(); ++k) {
    offsets[k] = static_cast<double>(carried);
    carried += chunks[k].sum - step * static_cast<long double>(chunks[k].present);
  }
  x[rate.size()] = static_cast<double>(carried);
  parallel_pieces(chunks.size(), piece / chunk, [&](std::size_t first, std::size_t last) {
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
