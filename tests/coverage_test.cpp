// Does the stated 95 % interval hold the truth 95 % of the time? Every method, over its own trial.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tumble/math/least_squares.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/methods/method.hpp"

namespace tumble {
namespace {

// 4 standard deviations of a binomial proportion are 4 sqrt(0.95 0.05 / 400) = 0.044, so that 400 seeds are the round
// number at which intervals that are too wide (coverage above 0.994) can fail as well as those that are too narrow.
constexpr std::size_t seeds = 400;
constexpr double stated = 0.95;

/// Seed by seed: is each true value inside, and how many standard uncertainties off is the estimate?
struct Outcomes {
  std::vector<std::string> names;
  std::vector<std::vector<bool>> inside;       // [seed][parameter]
  std::vector<std::vector<double>> deviation;  // [seed][parameter], NaN where the parameter is missing
  std::vector<std::string> errors;             // [seed], empty where the method ran
};

void judge_seed(const Method& method, std::size_t i, Outcomes& outcomes) {
  const Trial trial = method.trial(i + 1);
  outcomes.inside[i].assign(trial.truth.size(), false);
  outcomes.deviation[i].assign(trial.truth.size(), std::nan(""));
  try {
    const Estimate estimate = method.identify(trial.evidence, {});
    for (std::size_t j = 0; j < trial.truth.size(); ++j) {
      const auto& [name, truth] = trial.truth[j];
      const Parameter* parameter = find_parameter(estimate, name);
      if (parameter == nullptr) continue;
      const double sd =
          standard_uncertainty(estimate, static_cast<std::size_t>(parameter - estimate.parameters.data()));
      const double error = parameter->value - truth;
      outcomes.inside[i][j] = std::abs(error) <= student_quantile(0.975, parameter->degrees_of_freedom) * sd;
      outcomes.deviation[i][j] = error / sd;
    }
  } catch (const std::exception& error) {
    outcomes.errors[i] = error.what();
  }
}

Outcomes run(const Method& method) {
  Outcomes outcomes;
  for (const auto& [name, value] : method.trial(1).truth) outcomes.names.push_back(name);
  outcomes.inside.resize(seeds);
  outcomes.deviation.resize(seeds);
  outcomes.errors.resize(seeds);
  parallel_for(seeds, [&](std::size_t i) { judge_seed(method, i, outcomes); });
  return outcomes;
}

struct Row {
  std::size_t found = 0;
  double coverage = 0.0;
  double mean_deviation = 0.0;  // 0 +- 1/sqrt(seeds) for an unbiased estimate
  double rms_deviation = 0.0;   // 1 +- 1/sqrt(2 seeds) for an honest standard uncertainty
};

Row summarise(const Outcomes& outcomes, std::size_t j) {
  Row row;
  std::size_t inside = 0;
  double sum = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < seeds; ++i) {
    inside += outcomes.inside[i][j] ? 1 : 0;
    const double z = outcomes.deviation[i][j];
    if (std::isnan(z)) continue;
    ++row.found;
    sum += z;
    squares += z * z;
  }
  const double found = std::max<double>(1.0, static_cast<double>(row.found));
  row.coverage = static_cast<double>(inside) / seeds;
  row.mean_deviation = sum / found;
  row.rms_deviation = std::sqrt(squares / found);
  return row;
}

/// Mean over all parameters, and its standard error. The parameters of one seed share their data and are correlated,
/// so the seeds are the independent draws: the error comes from the spread of the fraction inside per seed, and is
/// never taken below what one parameter in the pool would have if all were independent.
struct Pooled {
  double coverage = 0.0;
  double standard_error = 0.0;
};

Pooled pool(const Outcomes& outcomes) {
  const double parameters = static_cast<double>(outcomes.names.size());
  std::vector<double> fraction;
  for (const auto& inside : outcomes.inside) {
    fraction.push_back(static_cast<double>(std::count(inside.begin(), inside.end(), true)) / parameters);
  }
  Pooled pooled;
  for (const double f : fraction) pooled.coverage += f / seeds;
  double squares = 0.0;
  for (const double f : fraction) squares += (f - pooled.coverage) * (f - pooled.coverage);
  const double independent = stated * (1.0 - stated) / parameters;
  pooled.standard_error = std::sqrt(std::max(squares / (seeds - 1), independent) / seeds);
  return pooled;
}

class Coverage : public testing::TestWithParam<const Method*> {};

TEST_P(Coverage, StatedIntervalsHoldTheTruth) {
  const Outcomes outcomes = run(*GetParam());
  ASSERT_FALSE(outcomes.names.empty()) << "the trial states no truth";
  const auto failures =
      std::count_if(outcomes.errors.begin(), outcomes.errors.end(), [](auto& e) { return !e.empty(); });
  for (std::size_t i = 0; i < seeds && failures > 0; ++i) {
    if (!outcomes.errors[i].empty()) {
      ADD_FAILURE() << failures << " of " << seeds << " seeds end in an error; seed " << i + 1 << ": "
                    << outcomes.errors[i];
      break;
    }
  }
  const double band = 4.0 * std::sqrt(stated * (1.0 - stated) / seeds);
  fmt::print("{:<32} {:>6} {:>9} {:>12} {:>12}\n", "parameter", "found", "coverage", "mean dev/sd", "rms dev/sd");
  for (std::size_t j = 0; j < outcomes.names.size(); ++j) {
    const Row row = summarise(outcomes, j);
    fmt::print("{:<32} {:>6} {:>9.3f} {:>12.2f} {:>12.2f}\n", outcomes.names[j], row.found, row.coverage,
               row.mean_deviation, row.rms_deviation);
    EXPECT_GE(row.coverage, stated - band) << outcomes.names[j] << ": the interval is too narrow";
    EXPECT_LE(row.coverage, stated + band) << outcomes.names[j] << ": the interval is too wide";
  }
  const Pooled pooled = pool(outcomes);
  fmt::print("{:<32} {:>6} {:>9.3f} +- {:.3f}\n", "all", seeds, pooled.coverage, pooled.standard_error);
  EXPECT_NEAR(pooled.coverage, stated, 4.0 * pooled.standard_error) << "over all parameters together";
}

INSTANTIATE_TEST_SUITE_P(Methods, Coverage, testing::ValuesIn(methods::catalogue()),
                         [](const auto& entry) { return std::string(entry.param->name); });

}  // namespace
}  // namespace tumble
