// An IMU at rest: noise and error model of six axes, block after block. Items are axis-samples; times are processor
// time of all threads.

#include <benchmark/benchmark.h>

#include "tumble/models/model.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/sim/power_up.hpp"
#include "tumble/units/unit.hpp"

namespace {

tumble::Plan plan_of(double seconds) {
  tumble::Plan plan;
  const auto& model = tumble::find_model("imu");
  plan.instrument_model = model.name;
  plan.sample_rate = 100.0;
  plan.rig_kind = "rate_table";
  plan.rig = tumble::defaults(tumble::find_rig(plan.rig_kind).options());
  plan.site = tumble::Site{0.6, 1.9, 400.0, std::nullopt};
  plan.schedule = {{"rest", seconds, 1, {}}};
  plan.truth = tumble::defaults(tumble::truth_options(model));
  const auto set = [&](const std::string& name, double value, const char* unit) {
    plan.truth.set_number(name, tumble::si(value, unit), tumble::Unit::parse(unit));
  };
  for (const char* axis : {"x", "y", "z"}) {
    set(std::string("gyro_") + axis + "_bias", 10.0, "deg/h");
    set(std::string("gyro_") + axis + "_scale_factor_error", 300.0, "ppm");
    set(std::string("accelerometer_") + axis + "_bias", 1.0, "mg");
  }
  set("gyro_x_misalignment_y", 60.0, "arcsec");
  return plan;
}

/// White noise and a Markov drift on every axis: what gyro_gen and acc_gen of the peer simulate.
void set_markov(tumble::Plan& plan) {
  for (const std::string kind : {"gyro_", "accelerometer_"}) {
    const bool gyro = kind == "gyro_";
    const auto set = [&](const char* name, double value, const char* unit) {
      plan.truth.set_number(kind + name, tumble::si(value, unit), tumble::Unit::parse(unit));
    };
    set("angle_random_walk", 0.25, gyro ? "deg/sqrt(h)" : "(m/s)/sqrt(h)");
    set("markov_sd", 3.5, gyro ? "deg/h" : "ug");
    set("markov_time", 100.0, "s");
  }
}

/// Quantization, white, bias instability, random walk, Markov: every term there is.
void set_all(tumble::Plan& plan) {
  set_markov(plan);
  for (const std::string kind : {"gyro_", "accelerometer_"}) {
    const bool gyro = kind == "gyro_";
    const auto set = [&](const char* name, double value, const char* unit) {
      plan.truth.set_number(kind + name, tumble::si(value, unit), tumble::Unit::parse(unit));
    };
    set("quantization_noise", 0.1, gyro ? "arcsec" : "mm/s");
    set("bias_instability", 2.0, gyro ? "deg/h" : "ug");
    set("rate_random_walk", 1.0, gyro ? "deg/h/sqrt(h)" : "ug/sqrt(h)");
  }
}

void run(benchmark::State& state, const tumble::Plan& plan) {
  const auto runs = tumble::power_ups(plan.schedule, plan.sample_rate);
  std::vector<std::vector<double>> samples(6, std::vector<double>(runs[0].samples));
  std::uint64_t seed = 0;
  for (auto _ : state) {
    const tumble::RandomStream random(++seed);
    const auto reference = tumble::reference_of(plan, runs[0], random);
    tumble::outputs_of(plan, reference, runs[0], random).next({samples.begin(), samples.end()});
    benchmark::DoNotOptimize(samples.data());
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * 6 * runs[0].samples));
}

void imu_white_and_markov(benchmark::State& state) {
  auto plan = plan_of(10000.0);
  set_markov(plan);
  run(state, plan);
}

void imu_all_noise(benchmark::State& state) {
  auto plan = plan_of(10000.0);
  set_all(plan);
  run(state, plan);
}

BENCHMARK(imu_white_and_markov)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(imu_all_noise)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

}  // namespace

BENCHMARK_MAIN();
