// Random vibration, simulated at 1 MHz for 100 s: how fast. Prints bench/results/random_vibration.md.
// usage: bench_random_vibration [seconds of vibration, 100]

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <ctime>
#include <fstream>
#include <string>

#include "tumble/methods/method.hpp"
#include "tumble/models/model.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/unit.hpp"

namespace {

using namespace tumble;

std::string machine() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown";
}

/// 0.1 g^2/Hz from 20 Hz to 2 kHz, counted every 5 ms.
Plan plan_of(double seconds, int steps, bool mean_reference, std::size_t units) {
  Plan plan;
  plan.method = "random_vibration";
  plan.instrument_model = "pendulous_accelerometer";
  plan.sample_rate = 200.0;
  plan.site = Site{si(34.25, "deg"), si(108.9, "deg"), 400.0, {}};
  plan.rig_kind = "shaker";
  plan.rig = defaults(find_rig("shaker").options());
  plan.rig.set_word("reference_output", mean_reference ? "mean" : "instant");
  plan.rig.set_flag("ideal", true);
  plan.settings = defaults(find_method("random_vibration").options());
  plan.settings.set_word("scale_factor", "2000 pulse/s/g");
  const double density = si(0.1, "g^2/Hz");
  const Motion shake{.kind = Motion::Kind::random, .psd_frequency = {20.0, 2000.0}, .psd = {density, density}};
  plan.schedule = {{"before", 10.0, 1, {{"shake", Motion{}}}},
                   {"random", seconds, 1, {{"shake", shake}}},
                   {"after", 10.0, 1, {{"shake", Motion{}}}}};
  plan.truth = defaults(truth_options(find_model(plan.instrument_model)));
  plan.truth.set_word("output", "count");
  plan.truth.set_integer("oversampling", steps);
  plan.truth.set_number("pulse_scale_factor", si(2000.0, "pulse/s/g"), Unit::parse("pulse/s/g"));
  plan.truth.set_number("second_order_coefficient", si(20.0, "ug/g^2"), Unit::parse("ug/g^2"));
  plan.truth.set_number("angle_random_walk", si(60.0, "ug/sqrt(Hz)"), Unit::parse("ug/sqrt(Hz)"));
  for (std::size_t u = 1; u < units; ++u)
    plan.beside.push_back({fmt::format("S{}", u + 1), plan.instrument_model, plan.truth});
  return plan;
}

struct Timed {
  double wall, processor;
};

template <typename Work>
Timed timed(Work work) {
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t clock = std::clock();
  work();
  return {std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(),
          static_cast<double>(std::clock() - clock) / CLOCKS_PER_SEC};
}

void row(double seconds, int steps, bool mean_reference, std::size_t units) {
  const Plan plan = plan_of(seconds, steps, mean_reference, units);
  Evidence evidence{plan, {}, {}};
  const Timed simulated = timed([&] { evidence.recordings = {simulate(plan, 1, {})}; });
  Estimate estimate;
  const Timed found = timed([&] { estimate = find_method("random_vibration").identify(evidence, {}); });
  const std::string name = (units > 1 ? "accelerometer." : "") + std::string("pulse_error_sd");
  const Parameter* sd = find_parameter(estimate, name);
  fmt::print("| {:.0f} kHz | {} | {} | {:.2f} | {:.2f} | {:.2f} | {:.4f} |\n", 0.2 * steps, units,
             mean_reference ? "mean" : "instant", simulated.wall, simulated.processor, found.wall,
             sd ? sd->value / 10.0 : std::nan(""));
}

}  // namespace

int main(int count, char** words) {
  const double seconds = count > 1 ? std::stod(words[1]) : 100.0;
  fmt::print(
      "# Random vibration\n\nMachine: {}. Compiler: g++ {}. Made by `bench/random_vibration.cpp`.\n\n{:.0f} s of 0.1 "
      "g^2/Hz from 20 Hz to 2 kHz and 2 x 10 s at rest, counted every 5 ms (2000 pulse/s/g), with second-order term "
      "and white noise; then the evaluation. 3.13: 2.8143 g of motion in the windows.\n\n"
      "| steps a second | units | reference | simulation [s] | processor [s] | evaluation [s] | s of the first [g] |\n"
      "|--:|--:|---|--:|--:|--:|--:|\n",
      machine(), __VERSION__, seconds);
  row(seconds, 100, false, 1);
  row(seconds, 100, true, 1);
  row(seconds, 100, true, 3);
  row(seconds, 5000, false, 1);
}
