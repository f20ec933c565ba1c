// The noise of samples that are already in memory: the Allan deviation with its confidence limits, then the noise terms
// with their uncertainty.

#include <cstdio>
#include <exception>
#include <vector>

#include "tumble/tumble.hpp"

namespace {

constexpr double sample_rate = 100.0;  // [Hz]

/// One hour of a gyro at rest [rad/s]: 0.02 deg/sqrt(h) of angle random walk, 0.5 deg/h of bias instability.
std::vector<double> samples() {
  tumble::NoiseModel noise;
  noise.angle_random_walk = tumble::si(0.02, "deg/sqrt(h)");
  noise.bias_instability = tumble::si(0.5, "deg/h");
  std::vector<double> rate(360'000, tumble::si(3.0, "deg/h"));
  tumble::add_noise(noise, sample_rate, tumble::RandomStream(1), rate);
  return rate;
}

void print_curve(const std::vector<double>& rate) {
  const auto unit = tumble::Unit::parse("deg/h");
  std::printf("   tau [s]   deviation [deg/h]   95 %% confidence\n");
  for (const auto& point : tumble::overlapping_allan(rate, sample_rate, {.points_per_decade = 2.0}))
    std::printf("%10.2f   %17.4f   %.4f to %.4f\n", point.tau, unit.from_si(point.deviation), unit.from_si(point.lower),
                unit.from_si(point.upper));
}

/// A method takes a plan and recordings. A plan of allan_noise is no more than its name and its settings.
void print_terms(std::vector<double> rate) {
  tumble::Recording recording;
  recording.channels.push_back({.name = "gyro",
                                .kind = tumble::QuantityKind::angular_rate,
                                .unit = tumble::Unit::parse("deg/h"),
                                .timeline = {.start = 0.0, .rate = sample_rate, .stamps = nullptr},
                                .values = std::move(rate)});
  const tumble::Evidence evidence{tumble::plan_for_method("allan_noise", {}), {recording}};
  const auto estimate = tumble::identify(evidence, {});
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    const auto& parameter = estimate.parameters[i];
    const double sd = tumble::standard_uncertainty(estimate, i);
    std::printf("%-28s %10.5f +- %8.5f %s\n", parameter.name.c_str(), parameter.unit.from_si(parameter.value),
                parameter.unit.difference_from_si(sd), parameter.unit.text().c_str());
  }
}

}  // namespace

int main() {
  try {
    const auto rate = samples();
    print_curve(rate);
    print_terms(rate);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}
