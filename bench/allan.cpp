// How long the Allan family takes. bench/allan_vs_allantools.py runs this beside allantools.

#include "tumble/math/stability/allan.hpp"

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <random>
#include <set>
#include <vector>

#include "tumble/math/parallel.hpp"
#include "tumble/math/stability/allan_differences.hpp"
#include "tumble/math/stability/allan_family.hpp"
#include "tumble/math/stability/allan_phase.hpp"
#include "tumble/math/stability/every_tau.hpp"
#include "tumble/math/stability/streaming_allan.hpp"

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

constexpr std::size_t ten_million = 10000000;
/// 5 factors an octave up to half of ten million samples: 104.
constexpr tumble::AllanOptions hundred{.points_per_decade = 16.6, .longest_fraction = 0.5};

/// Processor time is that of the one thread where the program is bound to one processor (taskset).
void hundred_factors(benchmark::State& state) {
  const auto rate = recording(ten_million, 1);
  for (auto _ : state) benchmark::DoNotOptimize(tumble::overlapping_allan(rate, 1.0, hundred));
}
BENCHMARK(hundred_factors)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

/// 104 factors between 1 and 10^6.5, even in their logarithm: they have no common factors, so that no sum serves two.
void hundred_free_factors(benchmark::State& state) {
  const auto rate = recording(ten_million, 1);
  std::set<std::size_t> factors;
  for (int k = 0; factors.size() < 104; ++k) factors.insert(static_cast<std::size_t>(std::pow(10.0, 6.5 / 112.0 * k)));
  tumble::AllanOptions options;
  options.factors.assign(factors.begin(), factors.end());
  for (auto _ : state) benchmark::DoNotOptimize(tumble::overlapping_allan(rate, 1.0, options));
}
BENCHMARK(hundred_free_factors)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

constexpr std::size_t million = 1000000;

void every_factor(benchmark::State& state) {
  const auto rate = recording(million, 1);
  for (auto _ : state) benchmark::DoNotOptimize(tumble::every_overlapping_allan(rate));
}
BENCHMARK(every_factor)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

/// The sum as it is defined, with the accumulators side by side that the compiler needs for vector registers.
double plain_sum(const double* x, std::size_t m, std::size_t count) {
  constexpr std::size_t lanes = 8;
  double sums[lanes] = {};
  for (std::size_t n = 0; n + lanes <= count; n += lanes) {
    for (std::size_t k = 0; k < lanes; ++k) {
      const double z = x[n + k] - 2.0 * x[n + k + m] + x[n + k + 2 * m];
      sums[k] += z * z;
    }
  }
  double sum = 0.0;
  for (const double part : sums) sum += part;
  return sum;
}

/// One factor in 10000, evenly over all; the time of all is 10000 times this. Range 1: with the instructions of this
/// processor (AVX2) instead of the compiler's choice.
void every_factor_by_loop(benchmark::State& state) {
  const auto rate = recording(million, 1);
  const auto phase = tumble::integrate_rate(rate, 3);
  for (auto _ : state) {
    for (std::size_t m = 5000; m < million / 2; m += 10000) {
      const std::size_t count = phase.values.size() - 2 * m;
      benchmark::DoNotOptimize(state.range(0) == 0 ? plain_sum(phase.values.data(), m, count)
                                                   : tumble::second_difference_squares(phase.values.data(), m, count));
    }
  }
}
BENCHMARK(every_factor_by_loop)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

void streaming(benchmark::State& state) {
  const auto rate = recording(ten_million, 1);
  for (auto _ : state) {
    tumble::StreamingAllan allan(ten_million / 4, 10.0);
    allan.push(rate);
    benchmark::DoNotOptimize(allan.points(1.0, 0.95));
  }
}
BENCHMARK(streaming)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

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

/// Deviations of a file of doubles at the hundred factors, for comparison with others'.
int print_deviations(const char* path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  std::vector<double> rate(static_cast<std::size_t>(file.tellg()) / sizeof(double));
  file.seekg(0).read(reinterpret_cast<char*>(rate.data()), static_cast<std::streamsize>(rate.size() * sizeof(double)));
  for (const auto& point : tumble::overlapping_allan(rate, 1.0, hundred))
    std::printf("%zu %.17g\n", point.factor, point.deviation);
  return file ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3 && std::strcmp(argv[1], "--deviations") == 0) return print_deviations(argv[2]);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
