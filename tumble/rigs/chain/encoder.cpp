#include "tumble/rigs/chain/encoder.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tumble::chain {

namespace {

/// Normal numbers with rising indices: those between them are made as well where they are few, since many at once take
/// less time.
template <class Number>
void pick(const RandomStream& random, Number number, std::span<double> out) {
  std::array<double, 512> all;
  const std::uint64_t first = number(0), last = number(out.size() - 1);
  const bool dense = last - first < all.size() && last - first < 8 * out.size();
  if (dense) random.normal(first, std::span(all).first(last - first + 1));
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = dense ? all[number(i) - first] : random.normal(number(i));
}

}  // namespace

void add_reading_noise(double sd, double rate, const RandomStream& random, double first, double step,
                       std::span<double> readings) {
  if (sd == 0.0) return;
  // Just above the beginning of an interval, so that a rounding of the time does not fall into the one before.
  const auto number = [&](std::size_t i) {
    return static_cast<std::uint64_t>(std::max(0.0, std::floor((first + static_cast<double>(i) * step) * rate + 1e-6)));
  };
  const bool one_by_one = std::abs(step * rate - 1.0) > 1e-12;
  std::array<double, 256> batch;
  for (std::size_t done = 0; done < readings.size();) {
    const std::size_t count = std::min(batch.size(), readings.size() - done);
    if (one_by_one) {
      pick(
          random, [&](std::size_t i) { return number(done + i); }, std::span(batch).first(count));
    } else {
      random.normal(number(done), std::span(batch.data(), count));
    }
    for (std::size_t i = 0; i < count; ++i) readings[done + i] += sd * batch[i];
    done += count;
  }
}

namespace {

void round_to(double quantum, std::span<double> readings) {
  if (quantum > 0.0)
    for (double& reading : readings) reading = std::round(reading / quantum) * quantum;
}

}  // namespace

Sensor thermometer(const std::shared_ptr<const Chain>& chain, double noise, double quantum, double rate,
                   const RandomStream& random) {
  Sensor sensor{{"temperature", QuantityKind::temperature, Unit::parse("degC"), {0.0, rate, nullptr}, {}}, nullptr};
  sensor.read = [=, stream = random.split("thermometer")](double first, double step, std::span<double> readings) {
    std::size_t piece = 0;
    const Oven& oven = chain->oven;
    for (std::size_t i = 0; i < readings.size(); ++i) {
      const double time = first + static_cast<double>(i) * step;
      readings[i] = shown_by(oven, oven.pieces.empty() ? chain->temperature : at(oven, time, piece).temperature);
    }
    add_reading_noise(noise, rate, stream, first, step, readings);
    round_to(quantum, readings);
  };
  return sensor;
}

Sensor encoder(const std::string& name, const std::shared_ptr<const Chain>& chain, std::size_t axis, double noise,
               double quantum, double rate, const RandomStream& random) {
  Sensor sensor{{name, QuantityKind::angle, Unit::parse("deg"), {0.0, rate, nullptr}, {}}, nullptr};
  sensor.read = [=, stream = random.split(name)](double first, double step, std::span<double> readings) {
    std::size_t piece = 0;
    for (std::size_t i = 0; i < readings.size(); ++i)
      readings[i] = at(chain->axes[axis], first + static_cast<double>(i) * step, piece).angle;
    add_reading_noise(noise, rate, stream, first, step, readings);
    round_to(quantum, readings);
  };
  return sensor;
}

}  // namespace tumble::chain
