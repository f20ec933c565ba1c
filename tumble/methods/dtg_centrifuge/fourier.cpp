#include "tumble/methods/dtg_centrifuge/fourier.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/clocks/stamp_slack.hpp"
#include "tumble/math/circle.hpp"
#include "tumble/methods/dtg_centrifuge/angles.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::dtg_centrifuge {
namespace {

/// docs/equations (1.6): the mean at rest of that power-up; the level's own where there is none.
double static_mean(const Test& test, const Measured& m, const Channel& channel) {
  for (const Spin& rest : test.rests)
    if (rest.start == m.stretch->start)
      if (const double mean = mean_of(channel, rest.begin, rest.end); std::isfinite(mean)) return mean;
  return mean_of(channel, m.stretch->begin, m.stretch->end);
}

}  // namespace

Observation fourier_observation(const Test& test, const Measured& m, const Reduction& reduction, std::size_t index,
                                const Relation& plain) {
  const Channels& channels = test.channels[m.stretch->recording];
  const Channel &g = *channels.signal[gyro], &f = *channels.signal[reference];
  const double step = m.of[gyro].step, rate = m.theta_rate();
  const double period = two_pi / std::abs(rate);
  const std::size_t first = index_at(g, m.stretch->begin - stamp_slack(m.stretch->begin, step));
  const std::size_t there = static_cast<std::size_t>(m.of[gyro].samples);
  // docs/equations (1.8): as many whole periods as there are
  const double periods = std::floor(static_cast<double>(there) * step / period);
  const auto count = std::min(there, static_cast<std::size_t>(std::llround(periods * period / step)));
  const double g0 = static_mean(test, m, g), f0 = static_mean(test, m, f);
  double start = 0.0;  // theta at the first sample
  if (test.encoders) {
    const Angles angles(channels, true, m.stretch->begin, m.stretch->end);
    std::vector<double> work;
    const double *arm = nullptr, *table = nullptr;
    angles.at(g, step, first, 1, work, arm, table);
    start = -table[0];
  }
  Complex sum = 0.0;
  for (std::size_t j = 0; j < count; ++j) {
    const double residual = (g.values[first + j] - g0) - (f.values[first + j] - f0);  // docs/equations (1.7)
    const CirclePoint p = on_circle((start + rate * step * static_cast<double>(j)) * 0.5 / pi);
    sum += residual * Complex(p.cosine, -p.sine);
  }
  sum *= 2.0 / static_cast<double>(count);  // A - iB, docs/equations (1.9)
  Observation out = observe(m, reduction, index, gyro, plain, 0.0, false);
  const Complex y = sum / out.force, value(y.real(), -m.stretch->spin_up * y.imag());
  for (Complex& part : out.part) part += value - out.value;
  out.value = value;
  return out;
}

}  // namespace tumble::dtg_centrifuge
