#include "tumble/math/noise_model.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "tumble/math/square.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

constexpr double series_below = 1e-2;  ///< [correlation times] where a formula cancels and its series is exact to 1e-9

constexpr double log4 = 2.0 * std::numbers::ln2;
constexpr std::size_t normals_at_a_time = 4096;  ///< normal numbers drawn at a time

/// The normal numbers of one stream in order, drawn in blocks.
class Normals {
 public:
  explicit Normals(const RandomStream& stream) : stream_(stream), buffer_(normals_at_a_time) {}
  double next() {
    if (at_ == normals_at_a_time) draw();
    return buffer_[at_++];
  }
  /// The next numbers, as many as are left of those drawn but no more than `wanted`; never empty.
  std::span<const double> some(std::size_t wanted) {
    if (at_ == normals_at_a_time) draw();
    const auto out = std::span<const double>(buffer_).subspan(at_, std::min(wanted, normals_at_a_time - at_));
    at_ += out.size();
    return out;
  }

 private:
  void draw() {
    stream_.normal(drawn_, buffer_);
    drawn_ += normals_at_a_time;
    at_ = 0;
  }

  RandomStream stream_;
  std::uint64_t drawn_ = 0;
  std::size_t at_ = normals_at_a_time;
  std::vector<double> buffer_;
};

/// Allan variance of a unit Gauss-Markov process over r = tau/T_c:
///   (2/r) (1 - (3 - 4 exp(-r) + exp(-2 r))/(2 r)),   for small r by its series (the first term left out is 31
///   r^4/2520)
double markov_shape(double r) {
  if (r < series_below) return 2.0 * r * (1.0 / 3.0 - r / 4.0 + 7.0 * r * r / 60.0 - r * r * r / 24.0);
  return 2.0 / r * (1.0 - (3.0 - 4.0 * std::exp(-r) + std::exp(-2.0 * r)) / (2.0 * r));
}

class White {
 public:
  White(double sd, const RandomStream& stream) : sd_(sd), normals_(stream) {}
  void operator()(std::span<double> signal) {
    while (!signal.empty()) {
      const auto normals = normals_.some(signal.size());
      for (std::size_t i = 0; i < normals.size(); ++i) signal[i] += sd_ * normals[i];
      signal = signal.subspan(normals.size());
    }
  }

 private:
  double sd_;
  Normals normals_;
};

/// White noise of the angle at the interval ends, sd Q: the rate is its difference quotient.
class Quantization {
 public:
  Quantization(double q, double interval, const RandomStream& stream)
      : scale_(q / interval), normals_(stream), before_(normals_.next()) {}
  void operator()(std::span<double> signal) {
    for (double& sample : signal) {
      const double after = normals_.next();
      sample += scale_ * (after - before_);
      before_ = after;
    }
  }

 private:
  double scale_;
  Normals normals_;
  double before_;
};

/// Random walk from zero at the start of the first interval. The mean over an interval is that of its ends plus the
/// mean of a Brownian bridge, of variance K^2 T/12.
class Walk {
 public:
  Walk(double k, double interval, const RandomStream& stream)
      : step_(k * std::sqrt(interval)),
        bridge_(k * std::sqrt(interval / 12.0)),
        steps_(stream.split("step")),
        bridges_(stream.split("bridge")) {}
  void operator()(std::span<double> signal) {
    for (double& sample : signal) {
      const double end = begin_ + step_ * steps_.next();
      sample += 0.5 * (begin_ + end) + bridge_ * bridges_.next();
      begin_ = end;
    }
  }

 private:
  double step_, bridge_;
  Normals steps_, bridges_;
  double begin_ = 0.0;
};

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
    bridge_variance =
        square(component.sd) * (r < series_below ? r / 6.0 : 2.0 * (r - 2.0 * std::tanh(0.5 * r)) / square(r));
  }
  double keep, step, ends, bridge_variance;
};

/// Means over each interval without the part that is independent from one interval to the next (see bridge_variance).
class MarkovEnds {
 public:
  MarkovEnds(const MarkovComponent& component, double interval, const RandomStream& stream)
      : step_(component, interval), normals_(stream), begin_(component.sd * normals_.next()) {}
  void operator()(std::span<double> signal) {
    for (double& sample : signal) {
      const double end = step_.keep * begin_ + step_.step * normals_.next();
      sample += step_.ends * (begin_ + end);
      begin_ = end;
    }
  }

 private:
  MarkovStep step_;
  Normals normals_;
  double begin_;
};

/// The same for a component much slower than `stride` intervals: straight lines between every stride-th end.
class SlowMarkov {
 public:
  SlowMarkov(const MarkovComponent& component, double interval, std::size_t stride, const RandomStream& stream)
      : step_(component, interval * static_cast<double>(stride)),
        stride_(stride),
        at_(stride),
        normals_(stream),
        end_(component.sd * normals_.next()) {}
  void operator()(std::span<double> signal) {
    while (!signal.empty()) {
      if (at_ == stride_) {
        begin_ = end_;
        end_ = step_.keep * begin_ + step_.step * normals_.next();
        at_ = 0;
      }
      const double slope = (end_ - begin_) / static_cast<double>(stride_);
      const std::size_t size = std::min(stride_ - at_, signal.size());
      for (std::size_t i = 0; i < size; ++i) signal[i] += begin_ + slope * (static_cast<double>(at_ + i) + 0.5);
      at_ += size;
      signal = signal.subspan(size);
    }
  }

 private:
  MarkovStep step_;
  std::size_t stride_, at_;
  Normals normals_;
  double begin_ = 0.0, end_;
};

using Parts = std::vector<std::function<void(std::span<double>)>>;

/// Bias instability B as Markov processes in the middles of equal cells of ln T_c from `shortest` to `longest`, at most
/// a factor 2.5 wide: sd^2 = B^2 ln(width)/pi each.
std::vector<MarkovComponent> fine_bank(double b, double shortest, double longest) {
  const double span = std::log(longest / shortest);
  const double cells = std::ceil(span / std::log(2.5)), width = span / cells;
  std::vector<MarkovComponent> bank;
  for (double cell = 0.5; cell < cells; ++cell)
    bank.push_back({b * std::sqrt(width / pi), shortest * std::exp(cell * width)});
  return bank;
}

/// Bias instability by the fine bank from T/64 to where flicker_bank() ends (the level of a record depends on that
/// end): its PSD is that of flicker within 1e-4. What is faster is white in the interval means; components of T_c >=
/// 1024 strides are drawn at every stride-th sample. B of a million samples is then true within 1e-4; by flicker_bank()
/// itself with 64 strides it was 0.26 % off, and white noise and quantization were seen that were not there.
void append_flicker(double b, double interval, std::size_t count, const RandomStream& stream, Parts& parts) {
  const double record = interval * static_cast<double>(count), shortest = interval / 64.0;
  const double end = 2.0 * flicker_bank(b, interval / 4.0, 4.0 * record).back().time;  // of the last cell, 4 wide
  const auto bank = fine_bank(b, shortest, end);
  const double ratio = bank[1].time / bank[0].time;
  const double beyond = 2.0 * square(bank[0].sd) * bank[0].time / (ratio - 1.0);  // sum of 2 sd^2 T_c below the bank
  double independent = beyond / interval;
  for (std::size_t i = 0; i < bank.size(); ++i) {
    std::size_t stride = 1;
    while (1024.0 * 4.0 * static_cast<double>(stride) * interval <= bank[i].time) stride *= 4;
    const RandomStream own = stream.split(i);
    if (stride > 1) {
      parts.emplace_back(SlowMarkov(bank[i], interval, stride, own));
    } else {
      parts.emplace_back(MarkovEnds(bank[i], interval, own));
      independent += MarkovStep(bank[i], interval).bridge_variance;
    }
  }
  parts.emplace_back(White(std::sqrt(independent), stream.split("independent")));
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

NoiseSource::NoiseSource(const NoiseModel& noise, double sample_rate, std::size_t count, const RandomStream& random) {
  const double interval = 1.0 / sample_rate;
  if (noise.quantization_noise != 0.0)
    parts_.emplace_back(Quantization(noise.quantization_noise, interval, random.split("quantization_noise")));
  if (noise.angle_random_walk != 0.0)
    parts_.emplace_back(White(noise.angle_random_walk / std::sqrt(interval), random.split("angle_random_walk")));
  if (noise.bias_instability != 0.0)
    append_flicker(noise.bias_instability, interval, count, random.split("bias_instability"), parts_);
  if (noise.rate_random_walk != 0.0)
    parts_.emplace_back(Walk(noise.rate_random_walk, interval, random.split("rate_random_walk")));
  if (noise.markov_sd != 0.0 && noise.markov_time > 0.0) {
    const MarkovComponent component{noise.markov_sd, noise.markov_time};
    const RandomStream stream = random.split("markov");
    parts_.emplace_back(MarkovEnds(component, interval, stream.split("ends")));
    parts_.emplace_back(White(std::sqrt(MarkovStep(component, interval).bridge_variance), stream.split("bridge")));
  }
  if (noise.rate_ramp != 0.0)
    parts_.emplace_back([step = noise.rate_ramp * interval, at = std::size_t{0}](std::span<double> signal) mutable {
      for (double& sample : signal) sample += step * (static_cast<double>(at++) + 0.5);
    });
}

void NoiseSource::add(std::span<double> signal) {
  // Small enough that they stay in the first cache while the parts pass over them.
  for (std::size_t first = 0; first < signal.size(); first += normals_at_a_time / 2)
    for (auto& part : parts_) part(signal.subspan(first, std::min(normals_at_a_time / 2, signal.size() - first)));
}

void add_noise(const NoiseModel& noise, double sample_rate, const RandomStream& random, std::span<double> signal) {
  if (!signal.empty()) NoiseSource(noise, sample_rate, signal.size(), random).add(signal);
}

}  // namespace tumble
