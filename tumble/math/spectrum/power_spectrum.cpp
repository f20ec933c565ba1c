#include "tumble/math/spectrum/power_spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "tumble/math/fourier.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/spectrum/power_spectrum_weights.hpp"
#include "tumble/math/spectrum/slepian.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr double least_leak = 1e-14;      ///< [1] of a taper: its concentration is not known better
constexpr std::size_t beside_tapers = 8;  ///< bins beyond the bandwidth, that count for neighbours
constexpr double most_time_bandwidth = 16.0, most_points_per_decade = 1000.0;  ///< beyond what any record resolves
constexpr double same_freedom = 1e-6;  ///< [1] of the degrees of freedom, within which limits are not calculated again

constexpr std::size_t shortest_run = 16;

struct Run {
  std::size_t first = 0, size = 0;
};

std::vector<Run> runs_of(std::span<const double> values) {
  std::vector<Run> runs;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isinf(values[i])) throw Error(Error::Kind::bad_data, say("infinite value at sample {}", i));
    if (std::isnan(values[i])) continue;
    if (i == 0 || std::isnan(values[i - 1])) runs.push_back({i, 0});
    ++runs.back().size;
  }
  return runs;
}

/// Windows of one length, all of unit energy, and by how much a segment starts after the one before.
struct Tapers {
  std::size_t length = 0, hop = 0;
  std::vector<std::vector<double>> values;
  double bins = 0.0;            ///< bandwidth in units of 1/(length T)
  std::vector<double> leaks{};  ///< share of each one's energy beyond the bandwidth
};

Tapers hann(std::size_t length) {
  std::vector<double> window(length);
  for (std::size_t i = 0; i < length; ++i) {
    const double sine = std::sin(pi * (static_cast<double>(i) + 0.5) / static_cast<double>(length));
    window[i] = sine * sine / std::sqrt(0.375 * static_cast<double>(length));
  }
  return {length, length / 2, {std::move(window)}, 1.5, {0.0}};
}

Tapers slepian(std::size_t length, double time_bandwidth) {
  const auto count = static_cast<std::size_t>(std::max(1.0, std::floor(2.0 * time_bandwidth) - 1.0));
  Tapers tapers{length, length, {}, 2.0 * time_bandwidth};
  for (auto& taper : slepian_tapers(length, time_bandwidth, count)) {
    tapers.leaks.push_back(std::max(least_leak, 1.0 - taper.concentration));
    tapers.values.push_back(std::move(taper.values));
  }
  return tapers;
}

/// Orthonormal polynomials of degree 0 and 1 over a segment.
struct Polynomials {
  explicit Polynomials(std::size_t length) : n(static_cast<double>(length)) {}
  double n;
  double constant() const { return 1.0 / std::sqrt(n); }
  double line(std::size_t i) const {
    return (static_cast<double>(i) - 0.5 * (n - 1.0)) / std::sqrt(n * (n * n - 1.0) / 12.0);
  }
};

/// g_k of each taper: what taking the line off leaves of white noise.
ByTaper gains(const Tapers& tapers) {
  const Polynomials polynomials(tapers.length);
  ByTaper gain(tapers.values.size(), std::vector<double>(tapers.length / 2 + 1, 1.0));
  std::vector<double> product(tapers.length);
  std::vector<std::complex<double>> spectrum;
  for (std::size_t a = 0; a < gain.size(); ++a) {
    for (const int degree : {0, 1}) {
      for (std::size_t i = 0; i < product.size(); ++i)
        product[i] = tapers.values[a][i] * (degree == 0 ? polynomials.constant() : polynomials.line(i));
      real_transform(product, spectrum);
      for (std::size_t k = 0; k < gain[a].size(); ++k) gain[a][k] -= std::norm(spectrum[k]);
    }
  }
  return gain;
}

/// What a segment is worked through in, used again by the next: fresh memory takes longer than a transform.
struct Bench {
  std::vector<double> segment, product;
  std::vector<std::complex<double>> spectrum;
};

/// Adds the squared transforms of one segment under every taper; returned: the squares about its line.
double add_segment(std::span<const double> values, const Tapers& tapers, Bench& bench, ByTaper& sums) {
  auto& [segment, product, spectrum] = bench;
  const Polynomials polynomials(tapers.length);
  segment.assign(values.begin(), values.end());
  product.resize(values.size());
  double constant = 0.0, line = 0.0, squares = 0.0;
  const double origin = values[0];
  for (std::size_t i = 0; i < segment.size(); ++i) {
    segment[i] -= origin;
    constant += segment[i] * polynomials.constant();
    line += segment[i] * polynomials.line(i);
  }
  for (std::size_t i = 0; i < segment.size(); ++i) {
    segment[i] -= constant * polynomials.constant() + line * polynomials.line(i);
    squares += segment[i] * segment[i];
  }
  for (std::size_t a = 0; a < sums.size(); ++a) {
    for (std::size_t i = 0; i < segment.size(); ++i) product[i] = tapers.values[a][i] * segment[i];
    real_transform(product, spectrum);
    for (std::size_t k = 0; k < sums[a].size(); ++k) sums[a][k] += std::norm(spectrum[k]);
  }
  return squares;
}

/// |sum_t h_a,t h_b,t+shift exp(-2 pi i D t/L)|^2 for every pair of tapers (a the slower index) and D = 0, 1, ... as
/// far as it is not small.
ByTaper squared_correlations(const Tapers& tapers, std::size_t shift) {
  const auto reach =
      std::min(tapers.length / 2 + 1, static_cast<std::size_t>(std::ceil(2.0 * tapers.bins)) + beside_tapers);
  ByTaper result;
  std::vector<double> product(tapers.length);
  std::vector<std::complex<double>> spectrum;
  for (const auto& a : tapers.values) {
    for (const auto& b : tapers.values) {
      std::fill(product.begin(), product.end(), 0.0);
      for (std::size_t i = 0; i + shift < tapers.length; ++i) product[i] = a[i] * b[i + shift];
      real_transform(product, spectrum);
      auto& squares = result.emplace_back(reach);
      for (std::size_t k = 0; k < reach; ++k) squares[k] = std::norm(spectrum[k]);
    }
  }
  return result;
}

/// Degrees of freedom of the mean over all segments and over frequencies side by side, each with its weights.
class Freedom {
 public:
  Freedom(const Tapers& tapers, std::size_t segments, std::size_t overlaps)
      : same_(squared_correlations(tapers, 0)), segments_(static_cast<double>(segments)) {
    if (overlaps > 0) next_ = squared_correlations(tapers, tapers.hop);
    overlaps_ = static_cast<double>(overlaps);
  }
  double edf(const ByTaper& weights, std::size_t first, std::size_t end) const {
    const double pairs =
        segments_ * over(same_, weights, first, end) + 2.0 * overlaps_ * over(next_, weights, first, end);
    const double all = segments_ * static_cast<double>(end - first);
    return 2.0 * all * all / pairs;
  }

 private:
  /// Sum over all pairs of the frequencies and tapers.
  static double over(const ByTaper& of_distance, const ByTaper& weights, std::size_t first, std::size_t end) {
    double sum = 0.0;
    const std::size_t count = weights.size();
    for (std::size_t pair = 0; pair < of_distance.size(); ++pair) {
      const auto& a = weights[pair / count];
      const auto& b = weights[pair % count];
      for (std::size_t d = 0; d < std::min(end - first, of_distance[pair].size()); ++d) {
        double products = 0.0;
        for (std::size_t k = first; k + d < end; ++k) products += a[k] * b[k + d] + (d > 0 ? a[k + d] * b[k] : 0.0);
        sum += products * of_distance[pair][d];
      }
    }
    return sum;
  }
  ByTaper same_, next_;
  double segments_, overlaps_ = 0.0;
};

/// The greatest length up to `length` without prime factors beyond 7, whose transform is quick.
std::size_t quick_length(std::size_t length) {
  for (;; --length) {
    std::size_t rest = length;
    for (const std::size_t prime : {2u, 3u, 5u, 7u})
      while (rest > 1 && rest % prime == 0) rest /= prime;
    if (rest <= 1) return length;
  }
}

std::size_t segment_length(SpectrumEstimator estimator, const std::vector<Run>& runs, std::size_t asked) {
  std::size_t longest = 0;
  for (const auto& run : runs) longest = std::max(longest, run.size);
  if (longest < shortest_run)
    throw Error(Error::Kind::bad_data,
                say("a spectrum needs a run of at least {} samples without a gap; the longest has {}",
                    Name{std::to_string(shortest_run)}, Name{std::to_string(longest)}));
  if (asked > longest)
    throw Error(Error::Kind::bad_data,
                say("a segment of {} samples does not fit between the gaps: the longest run has {}",
                    Name{std::to_string(asked)}, Name{std::to_string(longest)}));
  if (asked > 0) return asked;
  const bool welch = estimator == SpectrumEstimator::welch;
  // Of the runs at least as long as `usual`, which hold half of all samples, no whole one is lost.
  std::vector<std::size_t> sizes;
  std::size_t all = 0, held = 0, usual = longest;
  for (const auto& run : runs) sizes.push_back(run.size);
  std::sort(sizes.begin(), sizes.end(), std::greater<>());
  for (const auto size : sizes) all += size;
  for (std::size_t i = 0; i < sizes.size() && 2 * held < all; ++i) held += usual = sizes[i];
  const std::size_t most = std::size_t{1} << (welch ? 20 : 16),
                    parts = std::max<std::size_t>(welch ? 4 : 1, (usual + most - 1) / most);
  return std::max(shortest_run, quick_length(usual / parts));
}

void check(double rate, const SpectrumOptions& options) {
  Problems problems;
  if (!(rate > 0.0 && std::isfinite(rate))) problems.push_back("sampling rate must be above 0 Hz");
  if (options.length != 0 && options.length < shortest_run)
    problems.push_back(say("a segment needs at least {} samples", shortest_run));
  if (!(options.time_bandwidth >= 1.0 && options.time_bandwidth <= most_time_bandwidth))
    problems.push_back("time-bandwidth must lie between 1 and 16");
  if (!(options.points_per_decade >= 0.0 && options.points_per_decade <= most_points_per_decade))
    problems.push_back("points per decade must lie between 0 and 1000");
  if (!(options.confidence > 0.0 && options.confidence < 1.0))
    problems.push_back("confidence must lie between 0 and 1");
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

/// Means over bands of frequency, with limits. Nearer to zero or to half the rate than `reach` bins, a value and its
/// mirror image are not independent.
void add_points(const std::vector<double>& density, const ByTaper& weights, const Freedom& freedom, double step,
                std::size_t reach, const SpectrumOptions& options, PowerSpectrum& result) {
  const std::size_t end = result.length / 2 + 1 - std::min(reach, result.length / 4);
  double at = 0.0, low = 0.0, high = 0.0;
  for (std::size_t k = reach; k < end;) {
    std::size_t next = k + 1;
    if (options.points_per_decade > 0.0) {
      const double edge = (static_cast<double>(k) - 0.5) * std::pow(10.0, 1.0 / options.points_per_decade) + 0.5;
      next = std::clamp(static_cast<std::size_t>(std::llround(edge)), k + 1, end);
    }
    double sum = 0.0, logarithm = 0.0;
    for (std::size_t i = k; i < next; ++i) {
      sum += density[i];
      logarithm += std::log(static_cast<double>(i));
    }
    if (const double found = freedom.edf(weights, k, next); !(std::abs(found - at) < same_freedom * at)) {
      at = found;
      low = at / chi_square_quantile(0.5 * (1.0 + options.confidence), at);
      high = at / chi_square_quantile(0.5 * (1.0 - options.confidence), at);
    }
    const double count = static_cast<double>(next - k), mean = sum / count;
    result.frequency.push_back(step * std::exp(logarithm / count));
    result.density.push_back(mean);
    result.edf.push_back(at);
    result.lower.push_back(low * mean);
    result.upper.push_back(high * mean);
    k = next;
  }
}

}  // namespace

PowerSpectrum power_spectrum(SpectrumEstimator estimator, std::span<const double> values, double rate,
                             const SpectrumOptions& options) {
  check(rate, options);
  const auto runs = runs_of(values);
  PowerSpectrum result;
  result.length = segment_length(estimator, runs, options.length);
  const Tapers tapers =
      estimator == SpectrumEstimator::welch ? hann(result.length) : slepian(result.length, options.time_bandwidth);
  ByTaper eigen(tapers.values.size(), std::vector<double>(result.length / 2 + 1, 0.0));
  std::size_t overlaps = 0;
  double squares = 0.0;
  Bench bench;
  for (const auto& run : runs) {
    std::size_t used = 0;
    for (std::size_t first = 0; first + result.length <= run.size; first += tapers.hop) {
      squares += add_segment(values.subspan(run.first + first, result.length), tapers, bench, eigen);
      ++result.segments;
      overlaps += first > 0 && tapers.hop < result.length ? 1 : 0;
      used = first + result.length;
    }
    result.left_out += run.size - used;
  }
  const double step = rate / static_cast<double>(result.length), segments = static_cast<double>(result.segments);
  result.bandwidth = tapers.bins * step;
  const auto gain = gains(tapers);
  const auto reach = static_cast<std::size_t>(
      estimator == SpectrumEstimator::welch ? 2.0 : std::max(2.0, std::ceil(options.time_bandwidth)));
  for (std::size_t a = 0; a < eigen.size(); ++a)
    for (std::size_t k = 0; k < eigen[a].size(); ++k) eigen[a][k] *= 2.0 / (rate * segments * gain[a][k]);
  const double level = 2.0 * squares / (rate * segments * static_cast<double>(result.length - 2));
  const ByTaper weights =
      options.adaptive
          ? adaptive_weights(eigen, tapers.leaks, level)
          : ByTaper(eigen.size(), std::vector<double>(eigen[0].size(), 1.0 / static_cast<double>(eigen.size())));
  std::vector<double> density(eigen[0].size(), 0.0);
  for (std::size_t a = 0; a < eigen.size(); ++a)
    for (std::size_t k = 0; k < density.size(); ++k) density[k] += weights[a][k] * eigen[a][k];
  add_points(density, weights, Freedom(tapers, result.segments, overlaps), step, reach, options, result);
  return result;
}

}  // namespace tumble
