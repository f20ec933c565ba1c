#include "tumble/math/shaped_noise.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <cstdint>
#include <map>
#include <mutex>
#include <unsupported/Eigen/FFT>

#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

constexpr double times_of_line = 8.0, least_length = 64.0;  ///< over the distance of two frequencies; samples

constexpr std::size_t reach = 6;         ///< coefficients in a value
constexpr double lead = 3.0;             ///< coefficients before time 0
constexpr std::size_t longest = 131072;  ///< of the filter
constexpr std::size_t blocks_kept = 16;

using Spectrum = std::vector<std::complex<double>>;

/// Frequency response of the spline at f times its spacing.
double spline_response(double f) {
  const double x = pi * f, sinc = x == 0.0 ? 1.0 : std::sin(x) / x;
  return std::pow(sinc, static_cast<double>(reach));
}

/// Length of the filter in coefficients, odd.
std::size_t filter_length(const SpectralDensity& psd, double rate) {
  double duration = 16.0 / psd.frequency.front();
  for (std::size_t i = 0; i + 1 < psd.frequency.size(); ++i)
    duration = std::max(duration, times_of_line / (psd.frequency[i + 1] - psd.frequency[i]));
  return static_cast<std::size_t>(std::clamp(duration * rate, least_length, static_cast<double>(longest))) | 1u;
}

/// Even impulse response whose spectrum squared is the density over that of the spline, faded out by a Hann window;
/// scaled so that the process has exactly its variance.
std::vector<double> impulse_response(const SpectralDensity& psd, double rate, std::size_t length) {
  const std::size_t size = std::bit_ceil(4 * length);
  const auto frequency = [&](std::size_t k) { return static_cast<double>(k) / static_cast<double>(size); };
  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  Spectrum spectrum(size / 2 + 1);
  for (std::size_t k = 0; k < spectrum.size(); ++k)
    spectrum[k] = std::sqrt(0.5 * rate * density_at(psd, frequency(k) * rate)) / spline_response(frequency(k));
  std::vector<double> h(size);
  fft.inv(h, spectrum, static_cast<Eigen::Index>(size));
  const auto half = length / 2;
  for (std::size_t j = 0; j < size; ++j) {
    const std::size_t distance = std::min(j, size - j);
    const double x = static_cast<double>(distance) / static_cast<double>(half + 1);
    h[j] *= distance <= half ? 0.5 * (1.0 + std::cos(pi * x)) : 0.0;
  }
  fft.fwd(spectrum, h);
  double sum = 0.0;  // of 2/rate |H B|^2 over the frequencies
  for (std::size_t k = 0; k < spectrum.size(); ++k) {
    const double response = spline_response(frequency(k));
    sum += 2.0 / static_cast<double>(size) * std::norm(spectrum[k]) * response * response;
  }
  const double scale = std::sqrt(variance(psd) / sum);
  std::vector<double> centred(length);
  for (std::size_t j = 0; j < length; ++j) centred[j] = scale * h[(j + size - half) % size];
  return centred;
}

/// The parabola-like piece of a spline between two coefficients: powers of x from 0 to 1.
struct Piece {
  explicit Piece(const double* c)
      : p0((c[0] + 26.0 * c[1] + 66.0 * c[2] + 26.0 * c[3] + c[4]) / 120.0),
        p1((-c[0] - 10.0 * c[1] + 10.0 * c[3] + c[4]) / 24.0),
        p2((c[0] + 2.0 * c[1] - 6.0 * c[2] + 2.0 * c[3] + c[4]) / 12.0),
        p3((-c[0] + 2.0 * c[1] - 2.0 * c[3] + c[4]) / 12.0),
        p4((c[0] - 4.0 * c[1] + 6.0 * c[2] - 4.0 * c[3] + c[4]) / 24.0),
        p5((-c[0] + 5.0 * c[1] - 10.0 * c[2] + 10.0 * c[3] - 5.0 * c[4] + c[5]) / 120.0) {}
  double operator()(double x) const { return p0 + x * (p1 + x * (p2 + x * (p3 + x * (p4 + x * p5)))); }
  double p0, p1, p2, p3, p4, p5;
};

}  // namespace

double density_at(const SpectralDensity& psd, double f) {
  const auto& x = psd.frequency;
  if (x.empty() || f < x.front() || f > x.back()) return 0.0;
  const auto above = std::upper_bound(x.begin(), x.end(), f);
  const auto i = std::min(static_cast<std::size_t>(above - x.begin()), x.size() - 1) - 1;
  const double slope = std::log(psd.density[i + 1] / psd.density[i]) / std::log(x[i + 1] / x[i]);
  return psd.density[i] * std::pow(f / x[i], slope);
}

double variance(const SpectralDensity& psd) {
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < psd.frequency.size(); ++i) {
    const double octaves = std::log(psd.frequency[i + 1] / psd.frequency[i]);
    const double q = std::log(psd.density[i + 1] / psd.density[i]) + octaves;  // (p + 1) ln(f_2/f_1)
    sum += psd.density[i] * psd.frequency[i] * octaves * (std::abs(q) < 1e-12 ? 1.0 : std::expm1(q) / q);
  }
  return sum;
}

struct ShapedNoise::State {
  RandomStream random;
  double rate;         ///< of the coefficients [Hz]
  std::size_t size;    ///< of a transform
  std::size_t filter;  ///< its length
  Spectrum response;   ///< of the filter

  using Block = std::shared_ptr<const std::vector<double>>;
  mutable std::mutex mutex = {};
  mutable std::map<std::uint64_t, Block> blocks = {};

  std::size_t block_length() const { return size - filter + 1; }
  /// Neighbouring blocks share reach - 1 coefficients, so that every value finds its own in one of them.
  std::size_t advance() const { return block_length() - (reach - 1); }

  Block made(std::uint64_t number) const {
    std::vector<double> noise(size);
    random.normal(number * advance(), noise);
    Eigen::FFT<double> fft;
    fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
    Spectrum spectrum(size / 2 + 1);
    fft.fwd(spectrum, noise);
    for (std::size_t k = 0; k < spectrum.size(); ++k) spectrum[k] *= response[k];
    fft.inv(noise, spectrum, static_cast<Eigen::Index>(size));
    return std::make_shared<const std::vector<double>>(noise.begin() + static_cast<std::ptrdiff_t>(filter - 1),
                                                       noise.end());
  }

  Block block(std::uint64_t number) const {
    {
      const std::lock_guard lock(mutex);
      if (const auto found = blocks.find(number); found != blocks.end()) return found->second;
    }
    Block block = made(number);  // two threads may make the same one; both get the same numbers
    const std::lock_guard lock(mutex);
    // The one farthest from here makes room.
    if (blocks.size() >= blocks_kept) blocks.erase(number > blocks.begin()->first ? blocks.begin() : --blocks.end());
    blocks[number] = block;
    return block;
  }
};

ShapedNoise::ShapedNoise(const SpectralDensity& psd, const RandomStream& random) {
  const double rate = 6.0 * psd.frequency.back();
  const std::size_t length = filter_length(psd, rate), size = std::bit_ceil(4 * length);
  std::vector<double> h = impulse_response(psd, rate, length);
  h.resize(size);
  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  Spectrum response(size / 2 + 1);
  fft.fwd(response, h);
  state_ = std::shared_ptr<const State>(new State{random, rate, size, length, std::move(response)});
}

void ShapedNoise::values(double first, double step, std::span<double> out) const {
  const State& state = *state_;
  const auto place = [&](std::size_t i) {
    return std::max(0.0, first + static_cast<double>(i) * step) * state.rate + lead;
  };
  State::Block block;
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < out.size();) {
    const double floor = std::floor(place(i));
    const auto begin = static_cast<std::uint64_t>(floor) - 2;
    if (!block || begin / state.advance() != number) block = state.block(number = begin / state.advance());
    const Piece piece(block->data() + begin % state.advance());
    std::size_t end = i + 1;
    if (step > 0.0) {
      const double left = (floor + 1.0 - place(i)) / (step * state.rate);
      end = std::min(out.size(), i + 1 + static_cast<std::size_t>(std::max(0.0, left - 1.0)));
    }
    for (; i < end; ++i) out[i] = piece(place(i) - floor);
  }
}

ShapedNoise::Value ShapedNoise::at(double time) const {
  const State& state = *state_;
  const double place = std::max(0.0, time) * state.rate + lead, floor = std::floor(place), x = place - floor;
  const auto begin = static_cast<std::uint64_t>(floor) - 2;
  const auto block = state.block(begin / state.advance());
  const Piece p(block->data() + begin % state.advance());
  return {p(x), state.rate * (p.p1 + x * (2.0 * p.p2 + x * (3.0 * p.p3 + x * (4.0 * p.p4 + x * 5.0 * p.p5)))),
          state.rate * state.rate * (2.0 * p.p2 + x * (6.0 * p.p3 + x * (12.0 * p.p4 + x * 20.0 * p.p5)))};
}

}  // namespace tumble
