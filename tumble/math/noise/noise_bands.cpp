#include "tumble/math/noise/noise_bands.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>

#include "tumble/math/noise/block_cosines.hpp"
#include "tumble/math/noise/noise_bands/expected.hpp"
#include "tumble/math/noise/noise_bands/lost_samples.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using Fft = Eigen::FFT<double>;

/// Longer runs are cut to products of small primes.
constexpr std::size_t values_transformed = 64, greatest_prime = 31;

constexpr std::size_t single_ordinates = 32;
constexpr double band_width = 0.03;  ///< relative

/// products: those of the cosine's weights; empty: of whole blocks.
NoiseBand cosine_band(double unit, int radix, int order, const std::vector<double>& beside_missing,
                      const std::shared_ptr<const LostSamples>& lost) {
  NoiseBand band;
  band.products = beside_missing;
  band.lost = lost;
  band.frequency = order / (2.0 * radix * unit);
  band.unit = unit;
  band.radix = radix;
  band.order = order;
  const auto& products = beside_missing.empty() ? cosine_products(radix, order) : beside_missing;
  for (std::size_t t = 0; t < power_law_terms.size(); ++t) {
    for (int h = 0; h < radix; ++h)
      band.expected[t] +=
          (h == 0 ? 1.0 : 2.0) * products[static_cast<std::size_t>(h)] * unit_covariance(power_law_terms[t], unit, h);
    if (lost != nullptr) band.expected[t] += products[0] * lost->variance(power_law_terms[t]);
  }
  double ramp = 0.0;
  for (int i = 0; i < radix; ++i) ramp += std::sqrt(2.0 / radix) * std::cos(pi * order * (i + 0.5) / radix) * i * unit;
  band.ramp_square = ramp * ramp;
  return band;
}

// ---- fast scales ---------------------------------------------------------------------------------------------------

int next_radix(std::size_t values) {
  if (values >= values_for_widest) return widest_block;
  int radix = 2;
  while (values / static_cast<std::size_t>(radix) > most_values) radix *= 2;
  return radix;
}

/// Values in a block that bridges gaps of a few values before the sines are taken; 0: there is no such gap, or the
/// record is too short.
int bridging_radix(std::span<const double> values) {
  constexpr std::size_t fewest_blocks = 64, longest_gap = widest_block / 2;
  int radix = widest_block;
  while (radix >= 4 && values.size() < fewest_blocks * static_cast<std::size_t>(radix)) radix /= 2;
  if (radix < 4) return 0;
  std::size_t gap = longest_gap + 1;  // what is missing before the first value is no gap
  for (const double value : values) {
    if (std::isnan(value)) {
      ++gap;
      continue;
    }
    if (gap > 0 && gap <= longest_gap) return radix;
    gap = 0;
  }
  return 0;
}

/// Takes the contrasts of one scale off; returns the values of the next.
std::vector<double> fast_scale(std::span<const double> values, double unit, int radix, NoiseBands& result) {
  const BlockCosines cosines(radix);
  const auto p = static_cast<std::size_t>(radix);
  const std::size_t blocks = values.size() / p;
  std::vector<double> means(blocks);
  ScaleSums whole;
  for (std::size_t part = 0; part < NoiseBands::parts; ++part) {
    const std::size_t first = blocks * part / NoiseBands::parts, last = blocks * (part + 1) / NoiseBands::parts;
    const ContrastGroup sums = whole.take(cosines, values.subspan(first * p, (last - first) * p), means.data() + first);
    if (unit == 1.0) result.add_part(sums, radix);
  }
  add_bands(whole, unit, radix, result);
  return means;
}

// ---- slow part -----------------------------------------------------------------------------------------------------

struct Run {
  std::size_t first = 0, values = 0;
};

/// The greatest length up to n whose prime factors a fast transform bears.
std::size_t smooth(std::size_t n) {
  for (;; --n) {
    std::size_t rest = n;
    for (std::size_t p = 2; p <= greatest_prime; ++p)
      while (rest % p == 0) rest /= p;
    if (rest == 1) return n;
  }
}

std::vector<Run> runs_without_gap(std::span<const double> values) {
  std::vector<Run> runs;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    if (runs.empty() || runs.back().first + runs.back().values != i) runs.push_back({i, 0});
    ++runs.back().values;
  }
  std::erase_if(runs, [](const Run& run) { return run.values < 2; });
  for (Run& run : runs)
    if (run.values > values_transformed) run.values = smooth(run.values);
  return runs;
}

/// sum_j x_j sin(pi j k/(n + 1)), k = 1 .. n.
std::vector<double> sine_sums(Fft& fft, std::span<const double> x) {
  const std::size_t n = x.size();
  std::vector<double> odd(2 * (n + 1), 0.0);
  for (std::size_t j = 0; j < n; ++j) {
    odd[j + 1] = x[j];
    odd[2 * n + 1 - j] = -x[j];
  }
  std::vector<std::complex<double>> transformed;
  fft.fwd(transformed, odd);
  std::vector<double> sums(n);
  for (std::size_t k = 0; k < n; ++k) sums[k] = -0.5 * transformed[k + 1].imag();
  return sums;
}

/// Coefficients of the sines of the differences of a run.
std::vector<double> coefficients_of(Fft& fft, std::span<const double> values, const Run& run) {
  std::vector<double> differences(run.values - 1);
  for (std::size_t j = 0; j < differences.size(); ++j)
    differences[j] = values[run.first + j + 1] - values[run.first + j];
  auto sums = sine_sums(fft, differences);
  for (double& sum : sums) sum *= std::sqrt(2.0 / static_cast<double>(run.values));
  return sums;
}

/// Variances of the sine coefficients of n differences under unit flicker,
///   gamma_0 + 2 sum_h gamma_h ((1 - h/(n+1)) cos(h w_k) + sin(h w_k) cot(w_k)/(n+1)),   w_k = pi k/(n+1)
std::vector<double> flicker_of_sines(Fft& fft, std::size_t n) {
  std::vector<double> even(2 * (n + 1), 0.0), gamma(n, 0.0);
  const double size = static_cast<double>(n + 1);
  const double zero = fourth_difference(0.0) / (2.0 * pi);
  for (std::size_t h = 1; h < n; ++h) {
    gamma[h - 1] = fourth_difference(static_cast<double>(h)) / (2.0 * pi);
    even[h] = even[2 * (n + 1) - h] = gamma[h - 1] * (1.0 - static_cast<double>(h) / size);
  }
  std::vector<std::complex<double>> cosines;
  fft.fwd(cosines, even);
  const auto sines = sine_sums(fft, gamma);
  std::vector<double> variances(n);
  for (std::size_t k = 0; k < n; ++k) {
    const double w = pi * static_cast<double>(k + 1) / size;
    variances[k] = zero + cosines[k + 1].real() + 2.0 * sines[k] / (std::tan(w) * size);
  }
  return variances;
}

/// of_lost: variance of each power law by missing samples.
NoiseBand sine_band(double unit, std::size_t n, std::size_t k, double x, double flicker,
                    const std::array<double, power_law_terms.size()>& of_lost) {
  NoiseBand band;
  const double size = static_cast<double>(n + 1), w = pi * static_cast<double>(k + 1) / size;
  const double rise = 2.0 - 2.0 * std::cos(w), edge = std::sin(w);
  band.frequency = w / (2.0 * pi * unit);
  band.count = 1.0;
  band.mean_square = x * x;
  // A ramp has differences of `unit`, whose coefficient is sqrt(2/(n + 1)) cot(w/2) for odd k + 1.
  const double ramp = k % 2 == 0 ? unit * std::sqrt(2.0 / size) / std::tan(0.5 * w) : 0.0;
  band.with_ramp = x * ramp;
  band.ramp_square = ramp * ramp;
  // Of quantization the covariance is the square of that of white noise but at both ends.
  band.expected = {(rise * rise + 4.0 / size * edge * edge) / (unit * unit), rise / unit, flicker,
                   unit * (2.0 / 3.0 + std::cos(w) / 3.0)};
  for (std::size_t t = 0; t < of_lost.size(); ++t) band.expected[t] += rise * of_lost[t];
  band.unit = unit;
  band.shortness = 1.0 / size;
  return band;
}

void gather(const NoiseBand& one, NoiseBand& band) {
  const double all = band.count + one.count, share = one.count / all;
  const auto mean = [&](double& a, double b) { a += share * (b - a); };
  mean(band.frequency, one.frequency);
  mean(band.mean_square, one.mean_square);
  mean(band.with_ramp, one.with_ramp);
  mean(band.ramp_square, one.ramp_square);
  mean(band.shortness, one.shortness);
  for (std::size_t t = 0; t < band.expected.size(); ++t) mean(band.expected[t], one.expected[t]);
  band.count = all;
}

void slow_part(std::span<const double> values, double unit, NoiseBands& result) {
  Fft fft;
  fft.SetFlag(Fft::HalfSpectrum);
  std::array<double, power_law_terms.size()> of_lost{};
  for (std::size_t t = 0; result.lost != nullptr && t < of_lost.size(); ++t)
    of_lost[t] = result.lost->variance(power_law_terms[t]);
  std::vector<NoiseBand> sines;
  for (const Run& run : runs_without_gap(values)) {
    const std::size_t n = run.values - 1;
    const auto coefficients = coefficients_of(fft, values, run);
    const auto flicker = flicker_of_sines(fft, n);
    for (std::size_t k = 0; k < n; ++k) sines.push_back(sine_band(unit, n, k, coefficients[k], flicker[k], of_lost));
  }
  for (NoiseBand& band : sines) band.lost = result.lost;
  std::stable_sort(sines.begin(), sines.end(),
                   [](const NoiseBand& a, const NoiseBand& b) { return a.frequency < b.frequency; });
  if (sines.empty() && result.bands.empty())
    throw Error(Error::Kind::bad_data, "no two samples are neighbours: they do not show the noise");
  std::size_t index = 0;
  double first = 0.0;
  for (const NoiseBand& one : sines) {
    if (index++ < single_ordinates || one.frequency > first * (1.0 + band_width)) {
      result.bands.push_back(one);
      first = one.frequency;
    } else {
      gather(one, result.bands.back());
    }
    result.ordinates.push_back({one.frequency, one.mean_square, result.bands.size() - 1});
  }
}

/// Cosines of the slow values, for their scatter alone: the sines do not tell one time from another.
void add_scatter_of_slow(std::span<const double> values, double unit, NoiseBands& result) {
  const BlockCosines cosines(widest_block);
  const std::size_t blocks = values.size() / widest_block;
  std::vector<double> means(blocks);
  ScaleSums sums;
  sums.take(cosines, values.first(blocks * widest_block), means.data());
  NoiseBands apart;
  apart.lost = result.lost;
  add_bands(sums, unit, widest_block, apart);
  result.scatter.push_back(apart.scatter[0]);
}

}  // namespace

std::vector<double> slow_sines(std::span<const double> values) {
  Fft fft;
  fft.SetFlag(Fft::HalfSpectrum);
  struct One {
    double frequency, coefficient;
  };
  std::vector<One> all;
  for (const Run& run : runs_without_gap(values)) {
    const auto coefficients = coefficients_of(fft, values, run);
    for (std::size_t k = 0; k < coefficients.size(); ++k)
      all.push_back({static_cast<double>(k + 1) / static_cast<double>(run.values), coefficients[k]});
  }
  std::stable_sort(all.begin(), all.end(), [](const One& a, const One& b) { return a.frequency < b.frequency; });
  std::vector<double> coefficients;
  for (const One& one : all) coefficients.push_back(one.coefficient);
  return coefficients;
}

void add_bands(const ScaleSums& sums, double unit, int radix, NoiseBands& result) {
  const ContrastSums& whole = sums.whole();
  PowerScatter scatter{{}, sums.groups()};
  const bool complete = whole.patterns.empty() && result.lost == nullptr;
  const noise_bands::PatternsOfScale patterns = complete ? noise_bands::PatternsOfScale{} : patterns_of(whole, radix);
  if (whole.contrasts > 0.0) {
    for (int k = 1; k < radix; ++k) {
      NoiseBand band =
          cosine_band(unit, radix, k, complete ? std::vector<double>{} : patterns.products[k], result.lost);
      band.count = whole.contrasts;
      band.mean_square = whole.second[k] / whole.contrasts;
      const double ramp = std::sqrt(band.ramp_square) * (k % 2 == 1 ? -1.0 : 1.0);
      band.with_ramp = (ramp * whole.first[k] + unit * whole.with_ramp[k]) / whole.contrasts;
      band.ramp_square = (whole.count * band.ramp_square + unit * unit * whole.ramp_square[k]) / whole.contrasts;
      scatter.bands.push_back(band);
    }
  }
  result.bands.insert(result.bands.end(), scatter.bands.begin(), scatter.bands.end());
  result.scatter.push_back(std::make_shared<const PowerScatter>(std::move(scatter)));
  if (!complete) result.lost = lost_after(result.lost, patterns, unit);
}

NoiseBands::NoiseBands(std::span<const double> rate) : NoiseBands({}, rate, 1.0) { samples = rate.size(); }

NoiseBands::NoiseBands(NoiseBands fast, std::span<const double> rate, double unit) : NoiseBands(std::move(fast)) {
  std::vector<double> values;
  for (;;) {
    const int bridging = bridging_radix(rate), radix = std::max(bridging, next_radix(rate.size()));
    if (bridging == 0 && rate.size() <= most_values) break;
    values = fast_scale(rate, unit, radix, *this);
    rate = values;
    unit *= radix;
  }
  add_scatter_of_slow(rate, unit, *this);
  slow_part(rate, unit, *this);
  slow.assign(rate.begin(), rate.end());
  slow_unit = unit;
}

void NoiseBands::add_part(const ContrastGroup& sums, int radix) {
  double square = 0.0;
  for (int k = 1; k < radix; ++k) square += sums.square[static_cast<std::size_t>(k)];
  part_count.push_back(sums.contrasts * (radix - 1));
  part_mean_square.push_back(square / std::max(1.0, part_count.back()));
}

}  // namespace tumble
