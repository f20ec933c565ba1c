// Carries a test out by simulation and identifies the instrument from it. The plan says what the instrument really is,
// so that the answer can be compared with the truth, which `identify` never sees.
//
//   03_simulate_and_identify PLAN

#include <cmath>
#include <cstdio>
#include <exception>

#include "tumble/tumble.hpp"

namespace {

void print(const tumble::Estimate& predicted, const tumble::Estimate& estimate, const tumble::Settings& truth) {
  std::printf("%-6s %12s %12s %12s %10s\n", "", "identified", "sd", "predicted sd", "truth");
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    const auto& parameter = estimate.parameters[i];
    const tumble::Unit& unit = parameter.unit;
    double predicted_sd = std::nan("");
    for (std::size_t j = 0; j < predicted.parameters.size(); ++j)
      if (predicted.parameters[j].name == parameter.name) predicted_sd = tumble::standard_uncertainty(predicted, j);
    std::printf("%-6s %12.5f %12.5f %12.5f %10.4f %s\n", parameter.name.c_str(), unit.from_si(parameter.value),
                unit.difference_from_si(tumble::standard_uncertainty(estimate, i)),
                unit.difference_from_si(predicted_sd), unit.from_si(truth.number(parameter.name)), unit.text().c_str());
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: 03_simulate_and_identify PLAN\n");
    return 2;
  }
  try {
    const auto plan = tumble::load_plan(argv[1], {});
    const auto predicted = tumble::predict(plan);
    const auto recording = tumble::simulate(plan, 1, {});
    const auto estimate = tumble::identify({plan, {recording}}, {});
    print(predicted, estimate, plan.truth);
    for (const auto& finding : estimate.findings) std::printf("%s\n", finding.message.c_str());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}
