// The campaign of plans/sine_vibration.toml as the method sees it: 13 tones of 100 s, 14 rests of 20 s, 200 windows a
// second, three units and a reference. Data are made here, so that only identify is timed.

#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>
#include <string>

#include "tumble/math/random.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/rigs/rig.hpp"

namespace tumble {
namespace {

constexpr double rate = 200.0, pi = std::numbers::pi;

Evidence campaign() {
  Evidence evidence;
  Plan& plan = evidence.plan;
  const Method& method = find_method("sine_vibration");
  plan.method = method.name;
  plan.sample_rate = rate;
  plan.site = Site{0.6, 1.9, 400.0, {}};
  plan.rig_kind = "shaker";
  plan.rig = defaults(find_rig("shaker").options());
  plan.settings = defaults(method.options());
  plan.settings.set_word("scale_factor", "20000 pulse/s/g");
  Recording recording;
  for (const char* name : {"S1", "S2.accelerometer", "S3.accelerometer", "reference"})
    recording.channels.push_back({name == std::string("S1") ? "accelerometer" : name,
                                  QuantityKind::count,
                                  Unit::parse("pulse"),
                                  {0.0, rate, nullptr},
                                  {}});
  recording.channels.back().kind = QuantityKind::specific_force;
  recording.channels.back().unit = Unit::parse("g");
  double begin = 0.0;
  const auto add = [&](const std::string& label, double seconds, double f) {
    Segment segment{label, seconds, 1, {}};
    if (f > 0.0) segment.axes["shake"] = {.kind = Motion::Kind::sine, .amplitude = 29.42, .frequency = f};
    plan.schedule.push_back(segment);
    recording.marks.push_back({label, begin, 1});
    const auto n = static_cast<std::size_t>(seconds * rate);
    std::vector<double> noise(n);
    for (std::size_t c = 0; c < recording.channels.size(); ++c) {
      RandomStream(c + 1).normal(recording.channels[c].values.size(), noise);
      double total = 0.0, given = 0.0;
      for (std::size_t i = 0; i < n; ++i) {
        const double tone =
            f > 0.0 ? 3.0 * std::cos(2.0 * pi * std::fmod(f * (static_cast<double>(i) + 0.5) / rate, 1.0)) : 0.0;
        if (c == 3) {
          recording.channels[c].values.push_back(9.80665 * tone + 0.01 * noise[i]);
          continue;
        }
        const double x = f / rate, window = f > 0.0 ? std::sin(pi * x) / (pi * x) : 1.0;
        total += 100.0 * (1.0 + window * tone) + 0.03 * noise[i];
        recording.channels[c].values.push_back(std::floor(total) - given);
        given = std::floor(total);
      }
    }
    begin += seconds;
  };
  for (const double f : {10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.005, 99.7, 110.0, 120.0, 130.0}) {
    add("rest before " + std::to_string(f), 20.0, 0.0);
    add(std::to_string(f), 100.0, f);
  }
  add("rest", 20.0, 0.0);
  evidence.recordings.push_back(std::move(recording));
  return evidence;
}

void identify(benchmark::State& state) {
  const Evidence evidence = campaign();
  const Method& method = find_method("sine_vibration");
  for (auto _ : state) benchmark::DoNotOptimize(method.identify(evidence, {}));
}
BENCHMARK(identify)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace tumble

BENCHMARK_MAIN();
