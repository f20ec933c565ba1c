#include "tumble/math/noise_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace tumble {
namespace {

using std::numbers::pi;
constexpr double log4 = 2.0 * std::numbers::ln2;
constexpr std::size_t block = 4096;  ///< normal numbers drawn at a time

double square(double x) { return x * x; }

/// The normal numbers of one stream in order, drawn in blocks.
class Normals {
 public:
  explicit Normals(const RandomStream& stream) : stream_(stream) {}
  double next() {
    if (at_ == block) {
      stream_.normal(drawn_, buffer_);
      drawn_ += block;
      at_ = 0;
    }
    return buffer_[at_++];
  }

 private:
  RandomStream stream_;
  std::uint64_t drawn_ = 0;
  std::size_t at_ = block;
  std::array<double, block> buffer_{};
};

/// Allan variance of a unit Gauss-Markov process over r = tau/T_c:
///   (2/r) (1 - (3 - 4 exp(-r) + exp(-2 r))/(2 r)),   for small r by its series (the first term left out is 31
///   r^4/2520)
double markov_shape(double r) {
  if (r < 1e-2) return 2.0 * r * (1.0 / 3.0 - r / 4.0 + 7.0 * r * r / 60.0 - r * r * r / 24.0);
  return 2.0 / r * (1.0 - (3.0 - 4.0 * std::exp(-r) + std::exp(-2.0 * r)) / (2.0 * r));
}

void add_white(double sd, const RandomStream& stream, std::span<double> signal) {
  std::array<double, block> normal;
  for (std::size_t first = 0; first < signal.size(); first += block) {
    const std::size_t size = std::min(block, signal.size() - first);
    stream.normal(first, std::span(normal).first(size));
    for (std::size_t i = 0; i < size; ++i) signal[first + i] += sd * normal[i];
  }
}

/// White noise of the angle at the interval ends, sd Q: the rate is its difference quotient.
void add_quantization(double q, double interval, const RandomStream& stream, std::span<double> signal) {
  Normals normals(stream);
  const double scale = q / interval;
  double before = normals.next();
  for (double& sample : signal) {
    const double after = normals.next();
    sample += scale * (after - before);
    before = after;
  }
}

/// Random walk from zero at the start of the first interval. The mean over an interval is that of its ends plus the
/// mean of a Brownian bridge, of variance K^2 T/12.
void add_random_walk(double k, double interval, const RandomStream& stream, std::span<double> signal) {
  Normals steps(stream.split("step"));
  Normals bridges(stream.split("bridge"));
  const double step = k * std::sqrt(interval), bridge = k * std::sqrt(interval / 12.0);
  double begin = 0.0;
  for (double& sample : signal) {
    const double end = begin + step * steps.next();
    sample += 0.5 * (begin + end) + bridge * bridges.next();
    begin = end;
  }
}

/// A Gauss-Markov process at the ends of intervals T, r = T/T_c. Given both ends, its mean over an interval has
///   expectation (begin + end) tanh(r/2)/r   and   variance 2 sd^2 (r - 2 tanh(r/2))/r^2
/// (normal theory on the joint covariance of ends and mean).
struct MarkovStep {
  MarkovStep(const MarkovComponent& component, double interval) {
    const double r = interval / component.time;
    const double decay = std::exp(-r);
    keep = decay;
    step = component.sd * std::sqrt(-std::expm1(-2.0 * r));
    ends = std::tanh(0.5 * r) / r;
    bridge_variance = square(component.sd) * (r < 1e-2 ? r / 6.0 : 2.0 * (r - 2.0 * std::tanh(0.5 * r)) / square(r));
  }
  double keep, step, ends, bridge_variance;
};

/// Means over each interval without the part that is independent from one interval to the next (see bridge_variance).
void add_markov_ends(const MarkovComponent& component, double interval, const RandomStream& stream,
                     std::span<double> signal) {
  const MarkovStep step(component, interval);
  Normals normals(stream);
  double begin = component.sd * normals.next();
  for (double& sample : signal) {
    const double end = step.keep * begin + step.step * normals.next();
    sample += step.ends * (begin + end);
    begin = end;
  }
}

/// The same for a component much slower than `stride` intervals: straight lines between every stride-th end.
void add_slow_markov(const MarkovComponent& component, double interval, std::size_t stride, const RandomStream& stream,
                     std::span<double> signal) {
  const MarkovStep step(component, interval * static_cast<double>(stride));
  Normals normals(stream);
  double begin = component.sd * normals.next();
  for (std::size_t first = 0; first < signal.size(); first += stride) {
    const double end = step.keep * begin + step.step * normals.next();
    const double slope = (end - begin) / static_cast<double>(stride);
    const std::size_t size = std::min(stride, signal.size() - first);
    for (std::size_t i = 0; i < size; ++i) signal[first + i] += begin + slope * (static_cast<double>(i) + 0.5);
    begin = end;
  }
}

/// Bias instability by the bank from T/4 to beyond four records. What is faster than the bank is white in the interval
/// means; components of T_c >= 64 strides are drawn at every stride-th sample, which loses less than 0.5 % of the PSD
/// at the frequencies that the stride cannot follow.
void add_flicker(double b, double interval, const RandomStream& stream, std::span<double> signal) {
  const double record = interval * static_cast<double>(signal.size());
  const auto bank = flicker_bank(b, interval / 4.0, 4.0 * record);
  const double beyond = 2.0 * square(bank.front().sd) * bank.front().time / 3.0;  // sum of 2 sd^2 T_c below the bank
  double independent = beyond / interval;
  for (std::size_t i = 0; i < bank.size(); ++i) {
    std::size_t stride = 1;
    while (64.0 * 4.0 * static_cast<double>(stride) * interval <= bank[i].time * (1.0 + 1e-9)) stride *= 4;
    const RandomStream own = stream.split(i);
    if (stride > 1) {
      add_slow_markov(bank[i], interval, stride, own, signal);
    } else {
      add_markov_ends(bank[i], interval, own, signal);
      independent += MarkovStep(bank[i], interval).bridge_variance;
    }
  }
  add_white(std::sqrt(independent), stream.split("independent"), signal);
}

void add_markov(const MarkovComponent& component, double interval, const RandomStream& stream,
                std::span<double> signal) {
  add_markov_ends(component, interval, stream.split("ends"), signal);
  add_white(std::sqrt(MarkovStep(component, interval).bridge_variance), stream.split("bridge"), signal);
}

}  // namespace

double expected_allan_variance(const NoiseModel& noise, double tau) {
  double variance = 3.0 * square(noise.quantization_noise / tau) + square(noise.angle_random_walk) / tau +
                    2.0 * std::numbers::ln2 / pi * square(noise.bias_instability) +
                    square(noise.rate_random_walk) * tau / 3.0 + square(noise.rate_ramp * tau) / 2.0;
  if (noise.markov_sd != 0.0 && noise.markov_time > 0.0)
    variance += square(noise.markov_sd) * markov_shape(tau / noise.markov_time);
  return variance;
}

std::vector<MarkovComponent> flicker_bank(double bias_instability, double shortest, double longest) {
  const double sd = bias_instability * std::sqrt(log4 / pi);
  std::vector<MarkovComponent> bank{{sd, shortest}};
  while (bank.back().time < longest) bank.push_back({sd, bank.back().time * 4.0});
  return bank;
}

void add_noise(const NoiseModel& noise, double sample_rate, const RandomStream& random, std::span<double> signal) {
  if (signal.empty()) return;
  const double interval = 1.0 / sample_rate;
  if (noise.quantization_noise != 0.0)
    add_quantization(noise.quantization_noise, interval, random.split("quantization_noise"), signal);
  if (noise.angle_random_walk != 0.0)
    add_white(noise.angle_random_walk / std::sqrt(interval), random.split("angle_random_walk"), signal);
  if (noise.bias_instability != 0.0)
    add_flicker(noise.bias_instability, interval, random.split("bias_instability"), signal);
  if (noise.rate_random_walk != 0.0)
    add_random_walk(noise.rate_random_walk, interval, random.split("rate_random_walk"), signal);
  if (noise.markov_sd != 0.0 && noise.markov_time > 0.0)
    add_markov({noise.markov_sd, noise.markov_time}, interval, random.split("markov"), signal);
  if (noise.rate_ramp != 0.0)
    for (std::size_t i = 0; i < signal.size(); ++i)
      signal[i] += noise.rate_ramp * interval * (static_cast<double>(i) + 0.5);
}

}  // namespace tumble
