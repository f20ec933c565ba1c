// How long the Allan family takes. bench/allan_vs_allantools.py runs this beside allantools.

#include "tumble/math/allan.hpp"

#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "tumble/math/allan_family.hpp"
#include "tumble/math/parallel.hpp"

namespace {

/// White noise and a random walk beside a mean, as of an accelerometer at rest.
std::vector<double> recording(std::size_t samples, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  std::vector<double> rate(samples);
  double walk = 9.8;
  for (auto& value : rate) value = normal(engine) + (walk += 1e-4 * normal(engine));
  return rate;
}

constexpr std::size_t long_record = 4400000;  // 11 000 s at 400 Hz

void overlapping_allan(benchmark::State& state) {
  const auto rate = recording(long_record, 1);
  const tumble::AllanOptions options{.points_per_decade = static_cast<double>(state.range(0))};
  for (auto _ : state) benchmark::DoNotOptimize(tumble::overlapping_allan(rate, 400.0, options));
}
BENCHMARK(overlapping_allan)->Arg(0)->Arg(10)->Arg(15)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

void overlapping_allan_six_axes(benchmark::State& state) {
  std::vector<std::vector<double>> axes;
  for (unsigned axis = 0; axis < 6; ++axis) axes.push_back(recording(long_record, axis));
  for (auto _ : state) {
    tumble::parallel_for(axes.size(), [&](std::size_t axis) {
      benchmark::DoNotOptimize(tumble::overlapping_allan(axes[axis], 400.0, {.points_per_decade = 15.0}));
    });
  }
}
BENCHMARK(overlapping_allan_six_axes)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

void family(benchmark::State& state, tumble::Stability measure, std::size_t samples, double longest) {
  const auto phase = tumble::phase_from_rate(recording(samples, 1), 1.0);
  auto factors = tumble::averaging_factors(static_cast<std::size_t>(longest * static_cast<double>(samples)), 0.0);
  // The noise type is given: what is timed is the measure.
  for (auto _ : state) benchmark::DoNotOptimize(tumble::stability(measure, phase, 1.0, factors, {.alpha = 0}));
}
using tumble::Stability;
BENCHMARK_CAPTURE(family, mdev, Stability::modified_allan, 1000000, 0.25)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(family, ohdev, Stability::overlapping_hadamard, 1000000, 0.25)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(family, totdev, Stability::total, 100000, 0.5)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(family, mtotdev, Stability::modified_total, 2000, 0.3)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(family, htotdev, Stability::hadamard_total, 2000, 0.3)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(family, theo1, Stability::theo1, 5000, 0.5)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(family, mtie, Stability::peak_interval_error, 100000, 0.25)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();

}  // namespace

BENCHMARK_MAIN();
