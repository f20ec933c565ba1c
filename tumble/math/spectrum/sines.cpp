#include "tumble/math/spectrum/sines.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <unsupported/Eigen/FFT>

#include "tumble/math/extremes.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

using Complex = std::complex<double>;
constexpr int rounds_of_summit = 20;
constexpr double summit_within = 1e-9;     ///< [1/record] of the frequency
constexpr std::size_t least_blocks = 256;  ///< of a record, so that a block is not longer than what changes within it
/// Of a sine at the ends of its support; [1] of the support.
constexpr double cycles_of_fade = 4.0, most_of_fade = 0.5;
constexpr int rounds_of_all = 6;            ///< of all sines, each beside the others
constexpr double settled_sd = 1e-3;         ///< [sd] of amplitude and phase, by which the last round changes them
constexpr double least_sd_of_sine = 1e-12;  ///< [1] of the amplitude, without noise
/// The noise about a sine: within the band of a block, and up to a quarter of the frequency.
constexpr double of_block_band = 0.125, of_frequency = 0.25;
/// Parts of the record, in which a sine is looked at: of four cycles and more, up to eight; with a quarter of their
/// samples.
constexpr double cycles_of_part = 4.0, most_parts = 8.0, least_of_part = 0.25, fewest_parts = 3.0;

constexpr std::size_t lanes = 4, longest_block = 256;

/// Discrete Fourier transform of the sums, padded with zeros to a power of two at least `times` as long.
std::vector<Complex> transformed(const std::vector<Complex>& sum, std::size_t times) {
  std::size_t length = 1;
  while (length < times * sum.size()) length *= 2;
  std::vector<Complex> padded(sum), spectrum;
  padded.resize(length);
  Eigen::FFT<double>().fwd(spectrum, padded);
  return spectrum;
}

/// Frequencies of such a spectrum, below zero in its second half.
double frequency_of(std::size_t j, std::size_t length, double step) {
  return step * (static_cast<double>(j) - (2 * j < length ? 0.0 : static_cast<double>(length)));
}

double sum_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum;
}

/// Moments of the weights in time.
struct Moments {
  double weight = 0.0, square = 0.0, mean = 0.0, spread = 0.0, square_spread = 0.0;
};

template <typename Baseband>
Moments moments_of(const Baseband& base) {
  Moments m{sum_of(base.weight), sum_of(base.square), 0.0, 0.0, 0.0};
  for (std::size_t k = 0; k < base.time.size(); ++k) m.mean += base.weight[k] * base.time[k] / m.weight;
  for (std::size_t k = 0; k < base.time.size(); ++k) {
    const double t = base.time[k] - m.mean;
    m.spread += base.weight[k] * t * t;
    m.square_spread += base.square[k] * t * t;
  }
  return m;
}

/// Frequency beside that of the baseband at which the sums are largest, from `beside` on, by Newton's method with the
/// curvature of a pure sine; `amplitude`: there.
template <typename Baseband>
double summit(const Baseband& base, double beside, double reach, Complex& amplitude) {
  const Moments m = moments_of(base);
  const double start = beside;
  for (int round = 0; round < rounds_of_summit; ++round) {
    Complex sum, by_time;
    for (std::size_t k = 0; k < base.sum.size(); ++k) {
      const Complex one = base.sum[k] * std::polar(1.0, -two_pi * beside * base.time[k]);
      sum += one;
      by_time += (base.time[k] - m.mean) * one;
    }
    amplitude = 2.0 * sum / m.weight;
    if (!(std::norm(sum) > 0.0) || round == rounds_of_summit - 1) break;
    const double step = (std::conj(sum) * by_time).imag() / std::norm(sum) * m.weight / m.spread / two_pi;
    const double next = std::clamp(beside + step, start - reach, start + reach);
    if (std::abs(next - beside) < summit_within / static_cast<double>(m.weight)) break;
    beside = next;
  }
  return beside;
}

}  // namespace

/// exp(-2 pi i f j) over a block, one part after the other.
struct Sines::Turning {
  Turning(double f, std::size_t block) : frequency(f), cosine(block), sine(block) {
    for (std::size_t j = 0; j < block; ++j) {
      const double angle = two_pi * frequency * static_cast<double>(j);
      cosine[j] = std::cos(angle);
      sine[j] = std::sin(angle);
    }
  }
  double frequency;
  std::vector<double> cosine, sine;

  /// sum_j x_j exp(-2 pi i f j); NaN if one is missing
  Complex sum(std::span<const double> x) const {
    std::array<double, lanes> re{}, im{};
    const std::size_t whole = x.size() / lanes * lanes;
    for (std::size_t j = 0; j < whole; j += lanes)
      for (std::size_t k = 0; k < lanes; ++k) {
        re[k] += x[j + k] * cosine[j + k];
        im[k] -= x[j + k] * sine[j + k];
      }
    for (std::size_t j = whole; j < x.size(); ++j) {
      re[0] += x[j] * cosine[j];
      im[0] -= x[j] * sine[j];
    }
    return {(re[0] + re[1]) + (re[2] + re[3]), (im[0] + im[1]) + (im[2] + im[3])};
  }
};

double Sines::Support::weight(std::size_t n) const {
  const double edge = static_cast<double>(std::min(n - begin, end - 1 - n)) + 0.5;
  if (edge >= taper) return 1.0;
  const double sine = std::sin(half_pi * edge / taper);
  return sine * sine;
}

/// tapering: half a turn over the taper. Half of a rise and of a fall are cosines, which turn from their first.
void Sines::Support::weights(std::size_t first, const Turning& tapering, std::span<double> result) const {
  const std::size_t last = first + result.size() - 1;
  const bool rises = last - begin <= end - 1 - last, falls = first - begin >= end - 1 - first;
  if (!rises && !falls) {
    for (std::size_t j = 0; j < result.size(); ++j) result[j] = weight(first + j);
    return;
  }
  const double sign = rises ? 1.0 : -1.0;
  const double from = static_cast<double>(rises ? first - begin : end - 1 - first) + 0.5;
  const double re = 0.5 * std::cos(two_pi * tapering.frequency * from);
  const double im = 0.5 * sign * std::sin(two_pi * tapering.frequency * from);
  for (std::size_t j = 0; j < result.size(); ++j) {
    const double edge = from + sign * static_cast<double>(j);
    const double rise = 0.5 - (re * tapering.cosine[j] - im * tapering.sine[j]);
    result[j] = edge >= taper ? 1.0 : rise;
  }
}

/// Blocks short enough that a sine two frequencies of the search off hardly turns within one.
Sines::Sines(std::span<const double> values) {
  room_ = borrow_room(values.size());
  rest_ = {room_.get(), values.size()};
  std::ranges::copy(values, rest_.begin());
  middle_ = 0.5 * static_cast<double>(rest_.size() - 1);
  while (block_ < longest_block && rest_.size() / (2 * block_) >= least_blocks) block_ *= 2;
  const bool complete = extremes_of(values).present == values.size();
  for (std::size_t n = 0; !complete && n < rest_.size(); ++n) {
    if (!std::isnan(rest_[n])) continue;
    if (gaps_.empty() || gaps_.back().end != n) gaps_.push_back({n, n, 0.0});
    ++gaps_.back().end;
  }
  find_trend();
}

/// Straight line through the rest.
void Sines::find_trend() {
  const auto there = std::ranges::find_if(rest_, [](double value) { return !std::isnan(value); });
  const double origin = there == rest_.end() ? 0.0 : *there;
  std::array<std::array<double, lanes>, 5> sums{};  // none waits for the one before
  for (std::size_t n = 0; n < rest_.size(); ++n) {
    if (std::isnan(rest_[n])) continue;
    const double time = static_cast<double>(n) - middle_, value = rest_[n] - origin;
    const std::size_t k = n % lanes;
    sums[0][k] += 1.0;
    sums[1][k] += time;
    sums[2][k] += time * time;
    sums[3][k] += value;
    sums[4][k] += time * value;
  }
  const auto of = [&](std::size_t i) { return (sums[i][0] + sums[i][1]) + (sums[i][2] + sums[i][3]); };
  const double count = of(0), t = of(1), tt = of(2), x = of(3), tx = of(4);
  slope_ = count > 2.0 ? (tx - t * x / count) / (tt - t * t / count) : 0.0;
  level_ = count > 0.0 ? origin + (x - slope_ * t) / count : 0.0;
}

double Sines::trend(std::size_t n) const { return level_ + slope_ * (static_cast<double>(n) - middle_); }

std::vector<Sines::Support> Sines::supports(double frequency) const {
  std::vector<Support> found;
  std::size_t begin = 0;
  const auto close = [&](std::size_t end) {
    if (end > begin)
      found.push_back(
          {begin, end, std::min(cycles_of_fade / frequency, most_of_fade * static_cast<double>(end - begin))});
  };
  for (const Support& gap : gaps_) {
    if (static_cast<double>(gap.end - gap.begin) * frequency < 1.0) continue;
    close(gap.begin);
    begin = gap.end;
  }
  close(rest_.size());
  return found;
}

/// Samples of a block one by one, those of one support.
void Sines::weigh(const Support& support, std::size_t block, const Turning& turning, const Turning& tapering,
                  Baseband& result) const {
  const std::size_t origin = block * block_;
  const std::size_t first = std::max(support.begin, origin), last = std::min(support.end, origin + block_);
  std::array<double, longest_block> room;
  const std::span<double> weights = std::span(room).first(last - first);
  support.weights(first, tapering, weights);
  double re = 0.0, im = 0.0;
  for (std::size_t n = first; n < last; ++n) {
    if (std::isnan(rest_[n])) continue;
    const double weight = weights[n - first], value = weight * (rest_[n] - trend(n));
    result.weight[block] += weight;
    result.square[block] += weight * weight;
    re += value * turning.cosine[n - origin];
    im -= value * turning.sine[n - origin];
  }
  result.sum[block] +=
      Complex(re, im) * std::polar(1.0, -two_pi * turning.frequency * (static_cast<double>(origin) - middle_));
}

Sines::Baseband Sines::baseband(double frequency) const {
  const Turning turning(frequency, block_);
  const std::size_t blocks = (rest_.size() + block_ - 1) / block_;
  Baseband result{std::vector<Complex>(blocks), std::vector<double>(blocks, 0.0), std::vector<double>(blocks, 0.0), {}};
  Complex ones, ramp;
  for (std::size_t j = 0; j < block_; ++j) {
    const Complex one{turning.cosine[j], -turning.sine[j]};
    ones += one;
    ramp += static_cast<double>(j) * one;
  }
  for (std::size_t k = 0; k < blocks; ++k)
    result.time.push_back((static_cast<double>(k) + 0.5) * static_cast<double>(block_) - 0.5 - middle_);
  for (const Support& support : supports(frequency)) {
    const Turning tapering(0.5 / support.taper, block_);
    for (std::size_t k = support.begin / block_; k * block_ < support.end; ++k) {
      const std::size_t first = k * block_, last = first + block_;
      const bool flat = first >= support.begin && last <= support.end && support.weight(first) == 1.0 &&
                        support.weight(last - 1) == 1.0;
      const Complex sum = flat ? turning.sum(rest_.subspan(first, block_)) : Complex(std::nan(""));
      if (std::isnan(sum.real())) {
        weigh(support, k, turning, tapering, result);
        continue;
      }
      result.weight[k] = result.square[k] = static_cast<double>(block_);
      result.sum[k] = (sum - trend(first) * ones - slope_ * ramp) *
                      std::polar(1.0, -two_pi * frequency * (static_cast<double>(first) - middle_));
    }
  }
  return result;
}

/// Adds a sine to the rest, or takes it off.
void Sines::put(const Sine& sine, double sign) {
  const Turning turning(sine.frequency, block_);
  for (std::size_t first = 0; first < rest_.size(); first += block_) {
    const Complex from =
        sign * sine.amplitude * std::polar(1.0, two_pi * sine.frequency * (static_cast<double>(first) - middle_));
    const double re = from.real(), im = from.imag();
    const std::size_t count = std::min(block_, rest_.size() - first);
    for (std::size_t j = 0; j < count; ++j) rest_[first + j] += re * turning.cosine[j] - im * turning.sine[j];
  }
}

void Sines::add(double frequency, double width) {
  const Baseband base = baseband(frequency);
  const auto spectrum = transformed(base.sum, 4);
  const double step = 1.0 / static_cast<double>(spectrum.size() * block_);
  double most = -1.0, beside = 0.0;
  for (std::size_t j = 0; j < spectrum.size(); ++j) {
    const double at = frequency_of(j, spectrum.size(), step);
    if (std::abs(at) > width || !(std::norm(spectrum[j]) > most)) continue;
    most = std::norm(spectrum[j]);
    beside = at;
  }
  Sine sine;
  sine.frequency = frequency + summit(base, beside, 4.0 * step, sine.amplitude);
  put(sine, -1.0);
  sines_.push_back(sine);
}

void Sines::remove(std::size_t which) {
  put(sines_[which], 1.0);
  sines_.erase(sines_.begin() + static_cast<std::ptrdiff_t>(which));
}

void Sines::refine() {
  double most = 1.0;
  for (int round = 0; round < rounds_of_all && most > settled_sd; ++round) {
    most = 0.0;
    find_trend();
    for (Sine& sine : sines_) {
      Baseband base = baseband(sine.frequency);
      const Moments m = moments_of(base);
      for (std::size_t k = 0; k < base.sum.size(); ++k) base.sum[k] += 0.5 * sine.amplitude * base.weight[k];
      Sine better;
      better.frequency = sine.frequency + summit(base, 0.0, 1.0 / m.weight, better.amplitude);
      // A change matters by the standard deviation that the rest would give it.
      double square = 0.0;
      for (std::size_t k = 0; k < base.sum.size(); ++k)
        square += std::norm(base.sum[k] - 0.5 * better.amplitude * base.weight[k]);
      const double sd = 2.0 * std::sqrt(square) / m.weight;
      const double change = std::abs(better.amplitude - sine.amplitude);
      const double turned = two_pi * std::abs(better.frequency - sine.frequency) * std::sqrt(m.spread / m.weight);
      most = std::max(most, (change + turned * std::abs(sine.amplitude)) /
                                std::max(sd, least_sd_of_sine * std::abs(better.amplitude)));
      put(sine, 1.0);
      put(better, -1.0);
      sine = better;
    }
    if (sines_.size() < 2 && round > 0) break;
  }
}

namespace {

/// Mean power density of the spectrum beside a sine of this frequency, whose line is `1 / m.weight` wide; absent where
/// there are too few frequencies. Given: samples in a block.
template <typename Baseband>
std::optional<double> level_beside(const Baseband& base, const Moments& m, double frequency, std::size_t block) {
  constexpr double nearest = 3.0, farthest = 40.0, fewest = 20.0;
  const auto spectrum = transformed(base.sum, 1);
  const double step = 1.0 / static_cast<double>(spectrum.size() * block), width = 1.0 / m.weight;
  double power = 0.0, count = 0.0;
  for (std::size_t j = 0; j < spectrum.size(); ++j) {
    const double at = frequency_of(j, spectrum.size(), step);
    const double away = std::abs(at);
    if (away < nearest * width || away > std::min(farthest * width, of_block_band / static_cast<double>(block)) ||
        away > of_frequency * frequency || frequency + away > 0.5)
      continue;
    power += std::norm(spectrum[j]);
    ++count;
  }
  if (!(count * step / width >= fewest)) return std::nullopt;
  return power / count / m.square;
}

/// Sets wander and unsteadiness of a sine from its differences between parts of the record, unless these are too few.
template <typename Baseband>
void set_steadiness(const Baseband& base, const Moments& m, double amplitude, std::size_t parts, SineQuality& quality) {
  double off = 0.0, square = 0.0, used = 0.0;
  for (std::size_t p = 0; p < parts; ++p) {
    Complex sum;
    double weight = 0.0, squares = 0.0;
    for (std::size_t k = base.sum.size() * p / parts; k < base.sum.size() * (p + 1) / parts; ++k) {
      sum += base.sum[k];
      weight += base.weight[k];
      squares += base.square[k];
    }
    if (weight < least_of_part * m.weight / static_cast<double>(parts)) continue;
    off += 2.0 * std::norm(sum) / (quality.level * squares);
    square += weight / m.weight * std::norm(2.0 * sum / weight);
    ++used;
  }
  if (used < fewest_parts) return;
  quality.wander = off / (2.0 * used - 3.0);
  quality.unsteadiness = std::sqrt(square) / amplitude;
}

}  // namespace

SineQuality Sines::quality(std::size_t which, const std::function<double(double)>& level) const {
  const Sine& sine = sines_[which];
  const Baseband base = baseband(sine.frequency);
  const Moments m = moments_of(base);
  SineQuality quality;
  const auto measured = level_beside(base, m, sine.frequency, block_);
  quality.level = measured ? *measured : level(sine.frequency);
  const double amplitude = std::abs(sine.amplitude);
  quality.amplitude_sd = std::sqrt(2.0 * quality.level * m.square) / m.weight;
  quality.frequency_sd = std::sqrt(2.0 * quality.level * m.square_spread) / (amplitude * m.spread) / two_pi;
  quality.power = 0.5 * std::pow(amplitude / quality.amplitude_sd, 2);
  const auto parts = static_cast<std::size_t>(std::clamp(sine.frequency * m.weight / cycles_of_part, 1.0, most_parts));
  if (parts >= 3) set_steadiness(base, m, amplitude, parts, quality);
  return quality;
}

}  // namespace tumble
