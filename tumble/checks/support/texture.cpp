#include "tumble/checks/support/texture.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tumble::support {

namespace {

constexpr double least_steps = 16.0;  ///< steps that show whether they turn back: their share then has an sd of 0.12
/// [1] of the steps that turn back: 2/3 in white noise, 1/2 in a random walk, next to none in a smooth signal.
constexpr double least_turns = 0.3;
/// [quanta] mean of the steps: 1.0 where the signal only toggles, 1.5 in white noise of one quantum. Between the two.
constexpr double least_mean_step = 1.25;

struct Tally {
  std::vector<double> steps;  ///< between unequal neighbours, unsigned
  std::size_t turns = 0, samples = 0, runs = 0, long_runs = 0;
};

void add_stretch(std::span<const double> values, Tally& tally) {
  double last = NAN, last_step = 0.0;
  std::size_t length = 0;
  for (const double value : values) {
    if (std::isnan(value)) continue;
    ++tally.samples;
    if (value == last) {
      tally.long_runs += length++ == 1;
      continue;
    }
    if (!std::isnan(last)) {
      const double step = value - last;
      tally.steps.push_back(std::abs(step));
      tally.turns += step * last_step < 0.0;
      last_step = step;
    }
    last = value;
    length = 1;
    ++tally.runs;
  }
}

}  // namespace

Texture texture_of(std::span<const double> values) {
  constexpr std::size_t stretches = 64, length = 1024;
  Tally tally;
  if (values.size() <= stretches * length)
    add_stretch(values, tally);
  else
    for (std::size_t k = 0; k < stretches; ++k)
      add_stretch(values.subspan(k * (values.size() - length) / (stretches - 1), length), tally);
  Texture texture;
  if (tally.steps.empty()) return texture;
  double sum = 0.0;
  for (const double step : tally.steps) sum += step;
  const auto count = static_cast<double>(tally.steps.size());
  const auto tenth = tally.steps.begin() + static_cast<long>(tally.steps.size() / 10);
  std::nth_element(tally.steps.begin(), tenth, tally.steps.end());
  texture.quantum = *tenth;
  texture.repeats = static_cast<double>(tally.long_runs) / static_cast<double>(tally.runs);
  texture.equal_neighbours = 1.0 - static_cast<double>(tally.runs) / static_cast<double>(tally.samples);
  texture.noisy = count >= least_steps && static_cast<double>(tally.turns) > least_turns * count &&
                  sum / count > least_mean_step * texture.quantum;
  return texture;
}

}  // namespace tumble::support
