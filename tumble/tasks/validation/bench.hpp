#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tumble/departures/judgement.hpp"
#include "tumble/tasks/validate.hpp"

namespace tumble::validation {

/// The answer to one test, with what a comparison with the same test needs.
struct Outcome {
  Answer answer;
  std::vector<double> values, sds;  ///< [SI] of each parameter of the bench; NaN: the result has none
};

/// Tests for which a departure is tried: least_named and named in "nine of ten" are of them.
inline constexpr std::size_t seeds = 10;

/// The sound tests of a plan and their answers.
struct Bench {
  Plan plan;
  std::uint64_t seed = 1;                                  ///< of the first test
  std::vector<std::pair<std::string, double>> truth = {};  ///< parameter, true value [SI]
  std::vector<Parameter> parameters = {};                  ///< that a sound result has; their values are of one test
  std::optional<Estimate> predicted = {};
  std::optional<Sentence> not_predicted = {};
  std::vector<Outcome> sound = {};  ///< by trial
  /// The tests of the first seeds, where memory has room for them; else null, and each is made again when it is wanted.
  std::vector<std::shared_ptr<const SimulatedTest>> kept = {};
};

/// The bench with its first test. Throws as validate().
Bench bench_of(const Plan& plan, std::uint64_t seed);

/// Test number `trial` as it is planned.
std::shared_ptr<const SimulatedTest> sound_test(const Bench& bench, std::size_t trial);

/// The method's answer to a test. A refusal of the method is an answer too.
Outcome outcome_of(const Bench& bench, const SimulatedTest& test);

/// Carries out the sound tests up to number `trials`; `done` is called after each, from any thread.
void carry_out_sound_tests(Bench& bench, std::size_t trials, const std::function<void()>& done);

}  // namespace tumble::validation
