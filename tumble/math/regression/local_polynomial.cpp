#include "tumble/math/regression/local_polynomial.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tumble/math/fourier.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using Spectrum = std::vector<std::complex<double>>;

constexpr std::size_t lines_of_high_order = 24;           ///< from which on the response has the fifth order
constexpr std::size_t fewest_lines = 11;                  ///< of a band: nine columns, and residuals
constexpr double same_span = 1e-6;                        ///< [1] of the time, by which input and output may differ
constexpr double least_half_band = 6.0;                   ///< [lines]
constexpr double below_band = 0.005, above_band = 0.995;  ///< [1] of the power, outside of the band that is occupied

/// Fourier integral at k/T, first half; mean subtracted.
Spectrum spectrum_of(std::span<const double> signal, double rate) {
  const double mean =
      std::accumulate(signal.begin(), signal.end(), 0.0) / static_cast<double>(std::max<std::size_t>(1, signal.size()));
  std::vector<double> moved(signal.begin(), signal.end());
  for (double& v : moved) v -= mean;
  Spectrum full;
  real_transform(moved, full);
  for (auto& v : full) v /= rate;
  return full;
}

struct Lines {
  std::size_t first = 0, count = 0;
};

/// Lines of the spectrum within the band, at least `least` of them where the excitation has so many.
Lines lines_about(double f, double half, double bin, std::size_t lowest, std::size_t highest, std::size_t least) {
  if (highest < lowest) return {};
  const auto at = [&](double x) {
    return static_cast<std::size_t>(std::clamp(x / bin, static_cast<double>(lowest), static_cast<double>(highest)));
  };
  std::size_t first = at(f - half + bin), last = at(f + half);
  while (last - first + 1 < least && (first > lowest || last < highest)) {
    if (first > lowest) --first;
    if (last < highest) ++last;
  }
  return {first, last - first + 1};
}

double square_of(const Spectrum& a) {
  double sum = 0.0;
  for (const auto& value : a) sum += std::norm(value);
  return sum;
}

/// sum conj(a_i) b_i, and b less its part along a, which has length 1.
std::complex<double> subtract_projection(const Spectrum& a, Spectrum& b) {
  double real = 0.0, imag = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    real += a[i].real() * b[i].real() + a[i].imag() * b[i].imag();
    imag += a[i].real() * b[i].imag() - a[i].imag() * b[i].real();
  }
  for (std::size_t i = 0; i < a.size(); ++i)
    b[i] -= std::complex(a[i].real() * real - a[i].imag() * imag, a[i].real() * imag + a[i].imag() * real);
  return {real, imag};
}

/// Columns of the band's model: r^q X_k for q = 1, 2, ..., r^q for q = 0, 1, 2, and last X_k, whose factor is the
/// response.
std::vector<Spectrum> model_of(const Spectrum& x, double f, double half, double bin, Lines lines) {
  const std::size_t response_order = lines.count >= lines_of_high_order ? 5 : 3, leak = 3;
  std::vector<Spectrum> columns(response_order + leak, Spectrum(lines.count));
  for (std::size_t i = 0; i < lines.count; ++i) {
    const std::size_t k = lines.first + i;
    const double r = (static_cast<double>(k) * bin - f) / half;
    double power = 1.0;
    for (std::size_t q = 0; q < response_order; ++q, power *= r) {
      (q == 0 ? columns.back() : columns[q - 1])[i] = power * x[k];
      if (q < leak) columns[response_order - 1 + q][i] = power;
    }
  }
  return columns;
}

/// Least squares by the modified method of Gram and Schmidt, as accurate as reflections (Bjorck 1967): the last
/// column's factor needs no other.
BandResponse solve(const Spectrum& x, const Spectrum& y, double f, double half, double bin, Lines lines) {
  BandResponse out;
  out.frequency = f;
  if (lines.count < fewest_lines) return out;
  auto columns = model_of(x, f, half, bin, lines);
  const auto first = y.begin() + static_cast<std::ptrdiff_t>(lines.first);
  Spectrum rest(first, first + static_cast<std::ptrdiff_t>(lines.count));
  const double in_power = square_of(columns.back()), out_power = square_of(rest);
  if (!(out_power > 0.0) || !std::ranges::all_of(columns, [](const auto& c) { return square_of(c) > 0.0; })) return out;
  double length = 0.0;
  std::complex<double> along;
  for (std::size_t j = 0; j < columns.size(); ++j) {
    length = std::sqrt(square_of(columns[j]));
    for (auto& value : columns[j]) value /= length;
    for (std::size_t k = j + 1; k < columns.size(); ++k) subtract_projection(columns[j], columns[k]);
    along = subtract_projection(columns[j], rest);
  }
  const double n = static_cast<double>(lines.count), freedom = n - static_cast<double>(columns.size());
  const double noise = square_of(rest) / freedom;
  out.response = along / length;
  out.variance = noise / std::norm(along) / 2.0;
  out.degrees_of_freedom = 2.0 * freedom;
  out.coherence = std::clamp(1.0 - noise * n / out_power, 0.0, 1.0);
  // Both halves of the spectrum: mean square = 2 sum |X|^2 bin / T, amplitude = sqrt(2 mean square), T = 1/bin.
  out.input_amplitude = 2.0 * std::sqrt(in_power) * bin;
  out.found = std::norm(along) > 0.0;
  return out;
}

}  // namespace

std::vector<BandResponse> local_polynomial_response(std::span<const double> input, double input_rate,
                                                    std::span<const double> output, double output_rate,
                                                    std::span<const double> frequencies, double lowest, double highest,
                                                    double width) {
  const double time = static_cast<double>(input.size()) / input_rate;
  if (input.empty() || std::abs(static_cast<double>(output.size()) / output_rate - time) > same_span * time)
    throw Error(Error::Kind::bad_input, say("local polynomial response: {:.9g} s of input, {:.9g} s of output", time,
                                            static_cast<double>(output.size()) / output_rate));
  const Spectrum x = spectrum_of(input, input_rate), y = spectrum_of(output, output_rate);
  const double bin = 1.0 / time;
  const auto first = static_cast<std::size_t>(std::max(1.0, std::ceil(lowest / bin)));
  const auto last = std::min<std::size_t>({x.size() - 2, y.size() - 2, static_cast<std::size_t>(highest / bin)});
  std::vector<BandResponse> found;
  for (const double f : frequencies) {
    const double half = std::max(width * f, least_half_band * bin);
    found.push_back(solve(x, y, f, half, bin, lines_about(f, half, bin, first, last, fewest_lines)));
  }
  return found;
}

std::pair<double, double> occupied_band(std::span<const double> signal, double rate) {
  const Spectrum x = spectrum_of(signal, rate);
  double total = 0.0, sum = 0.0;
  for (const auto& v : x) total += std::norm(v);
  const double bin = rate / static_cast<double>(signal.size());
  double low = 0.0, high = 0.0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    sum += std::norm(x[k]);
    if (sum < below_band * total) low = static_cast<double>(k) * bin;
    if (sum < above_band * total) high = static_cast<double>(k) * bin;
  }
  return {low, high};
}

std::size_t smooth_length(std::size_t most, std::size_t multiple) {
  for (std::size_t n = most / multiple * multiple; n > 0; n -= multiple) {
    std::size_t rest = n;
    for (const std::size_t factor : {2u, 3u, 5u})
      while (rest % factor == 0) rest /= factor;
    if (rest == 1) return n;
  }
  return 0;
}

}  // namespace tumble
