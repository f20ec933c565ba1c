// A linear method of one's own: which terms the output has, and a simulated trial whose answer is known. The library
// turns the terms into parameters with a budget. Then the question that every method has to answer: does its 95 %
// interval hold the truth in 95 % of all cases?
//
//   05_write_a_method PLAN

#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "tumble/tumble.hpp"

namespace {

constexpr std::size_t seeds = 200;

/// y = f_x + b + S f_x + a_y f_y + a_z f_z: each term is a coefficient times what it multiplies.
tumble::TermProblem terms() {
  tumble::TermProblem problem;
  problem.channel = "accelerometer_x";
  problem.input = [](const tumble::Felt& felt) { return felt.specific_force.x; };
  problem.columns = {
      {"bias", "b", "ug", "output without any input", [](const tumble::Felt&) { return 1.0; }},
      {"scale_factor_error", "S", "ppm", "", [](const tumble::Felt& felt) { return felt.specific_force.x; }},
      {"misalignment_y", "a_y", "arcsec", "", [](const tumble::Felt& felt) { return felt.specific_force.y; }},
      {"misalignment_z", "a_z", "arcsec", "", [](const tumble::Felt& felt) { return felt.specific_force.z; }}};
  problem.settling = 1.0;
  problem.averaging = 10.0;
  return problem;
}

/// A simulated test whose answer is known.
struct Trial {
  tumble::Evidence evidence;
  std::vector<std::pair<std::string, double>> truth;  // name of a parameter, and its value in SI
};

/// The test with this seed, and the values that the method should find.
Trial trial(const tumble::Plan& plan, std::uint64_t seed) {
  Trial trial{{plan, {tumble::simulate(plan, seed, {})}}, {}};
  for (const auto& term : terms().columns)
    trial.truth.emplace_back(term.name, plan.truth.number("accelerometer_x_" + term.name));
  return trial;
}

/// Is the truth inside the 95 % interval? The quantile is of Student's t where few data told the uncertainty.
bool holds(const tumble::Estimate& estimate, std::size_t index, double truth) {
  const auto& parameter = estimate.parameters[index];
  const double half_width =
      tumble::student_quantile(0.975, parameter.degrees_of_freedom) * tumble::standard_uncertainty(estimate, index);
  return std::abs(parameter.value - truth) <= half_width;
}

std::size_t index_of(const tumble::Estimate& estimate, const std::string& name) {
  const auto* parameter = tumble::find_parameter(estimate, name);
  if (parameter == nullptr)
    throw tumble::Error(tumble::Error::Kind::bad_data, tumble::say("the test does not show {}", tumble::Name{name}));
  return static_cast<std::size_t>(parameter - estimate.parameters.data());
}

void print_answer(const tumble::Estimate& estimate, const Trial& trial) {
  for (const auto& [name, truth] : trial.truth) {
    const auto i = index_of(estimate, name);
    const auto& unit = estimate.parameters[i].unit;
    std::printf("%-20s %9.2f +- %6.2f %-7s truth %8.2f\n", name.c_str(), unit.from_si(estimate.parameters[i].value),
                unit.difference_from_si(tumble::standard_uncertainty(estimate, i)), unit.text().c_str(),
                unit.from_si(truth));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: 05_write_a_method PLAN\n");
    return 2;
  }
  try {
    const auto plan = tumble::load_plan(argv[1], {});
    std::vector<std::size_t> inside(terms().columns.size(), 0);
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      const auto test = trial(plan, seed);
      const auto estimate = tumble::identify_terms(test.evidence, terms());
      if (seed == 1) print_answer(estimate, test);
      for (std::size_t j = 0; j < test.truth.size(); ++j)
        inside[j] += holds(estimate, index_of(estimate, test.truth[j].first), test.truth[j].second) ? 1 : 0;
    }
    // Four standard deviations of a proportion of 0.95 over that many seeds.
    const double band = 4.0 * std::sqrt(0.95 * 0.05 / seeds);
    bool honest = true;
    for (std::size_t j = 0; j < inside.size(); ++j) {
      const double coverage = static_cast<double>(inside[j]) / seeds;
      std::printf("%-20s the interval holds the truth in %.1f %% of %zu seeds\n", terms().columns[j].name.c_str(),
                  100.0 * coverage, seeds);
      honest = honest && std::abs(coverage - 0.95) <= band;
    }
    std::printf("%s\n", honest ? "the intervals are honest" : "the intervals are NOT honest");
    return honest ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}
