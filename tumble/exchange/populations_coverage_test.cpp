#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <mutex>

#include "tumble/core/testing/asserts.hpp"
#include "tumble/exchange/comparison.hpp"
#include "tumble/exchange/populations.hpp"
#include "tumble/exchange/testing/fleet.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/math/square.hpp"
#include "tumble/reduce/with_prior.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/rigs/error_names.hpp"

namespace tumble {
namespace {

using testing::FleetModel;

std::size_t fleets() {
  const char* given = std::getenv("TUMBLE_COVERAGE_SEEDS");
  return given ? static_cast<std::size_t>(std::strtoul(given, nullptr, 10)) : 100;
}

/// Shares of fleets [1]: their mean, and its standard deviation by the scatter between them.
struct Share {
  std::vector<double> of_fleets;

  double mean() const {
    double sum = 0.0;
    for (const double one : of_fleets) sum += one / static_cast<double>(of_fleets.size());
    return sum;
  }
  double sd() const {
    double squares = 0.0;
    for (const double one : of_fleets) squares += square(one - mean());
    const auto n = static_cast<double>(of_fleets.size());
    return std::sqrt(squares / (n - 1.0) / n);
  }
};

bool holds(const Estimate& estimate, std::size_t i, double truth) {
  const auto [lower, upper] = interval95(estimate, i);
  return lower <= truth && truth <= upper;
}

// New units of fleets of few and of many units, whose spread is from half of the uncertainty of a result to three of
// them: the interval with prior holds the truth of 95 %, and the unit's own result is improved.
TEST(PriorCoverage, NewUnitsAreHeldByIntervalsWithPrior) {
  struct Case {
    std::uint64_t units;
    double spread;
  };
  constexpr std::uint64_t news = 20;
  for (const auto& [units, spread] : {Case{6, 1.0}, Case{6, 3.0}, Case{12, 0.5}, Case{20, 1.0}}) {
    const FleetModel model{.spread = spread};
    Share held, aliens, better;
    held.of_fleets.resize(fleets()), aliens.of_fleets.resize(fleets()), better.of_fleets.resize(fleets());
    parallel_for(fleets(), [&](std::size_t f) {
      const auto random = RandomStream(41).split(100 * units + static_cast<std::uint64_t>(10.0 * spread)).split(f);
      std::vector<TestedUnit> tested;
      for (auto& one : testing::fleet_results(model, random, units))
        tested.push_back({one.estimate.instrument_serial, "", false, std::move(one.estimate)});
      const auto population = population_of_units("m", "accelerometer_tumble", tested);
      double inside = 0.0, all = 0.0, strange = 0.0, ratio = 0.0;
      for (std::uint64_t i = 0; i < news; ++i) {
        const auto unit = testing::fleet_result(model, random, 1000 + i, i % 2, i % 4 == 3 ? "no K2" : "all");
        const auto use = with_population(unit.estimate, population);
        strange += !use.with_prior;
        const Estimate& estimate = use.with_prior ? *use.with_prior : unit.estimate;
        for (std::size_t k = 0; k < estimate.parameters.size(); ++k, all += 1.0)
          inside += holds(estimate, k, unit.truth[k]);
        ratio += standard_uncertainty(estimate, 0) / standard_uncertainty(unit.estimate, 0) / static_cast<double>(news);
      }
      held.of_fleets[f] = inside / all;
      aliens.of_fleets[f] = strange / static_cast<double>(news);
      better.of_fleets[f] = ratio;
    });
    const std::string what = std::to_string(units) + " units, spread " + std::to_string(spread);
    RecordProperty(what + ": held", std::to_string(held.mean()));
    EXPECT_GE(held.mean(), 0.95 - 4.0 * held.sd()) << what;
    EXPECT_LE(held.mean(), 0.99) << what << ": an interval of a narrow population may be too wide, but not by this";
    EXPECT_LE(aliens.mean() - 4.0 * aliens.sd(), 0.01) << what;
    EXPECT_LT(better.mean(), 1.0) << what;
  }
}

// With the errors of the rig taken as independent, 0.88 of the intervals hold where 0.95 are stated.
TEST(PriorCoverage, SharedErrorsOfTheRigAreCounted) {
  const FleetModel model{.spread = 1.0, .shared = 2.0};
  Share held;
  held.of_fleets.resize(fleets());
  parallel_for(fleets(), [&](std::size_t f) {
    const auto random = RandomStream(43).split(f);
    std::vector<TestedUnit> tested;
    for (auto& one : testing::fleet_results(model, random, 10))
      tested.push_back({one.estimate.instrument_serial, "", false, std::move(one.estimate)});
    const auto population = population_of_units("m", "accelerometer_tumble", tested);
    double inside = 0.0, all = 0.0;
    for (std::uint64_t i = 0; i < 20; ++i) {
      const auto unit = testing::fleet_result(model, random, 1000 + i, i % 3);  // one of three on a new rig
      const auto use = with_population(unit.estimate, population);
      const Estimate& estimate = use.with_prior ? *use.with_prior : unit.estimate;
      for (std::size_t k = 0; k < 3; ++k, all += 1.0) inside += holds(estimate, k, unit.truth[k]);
    }
    held.of_fleets[f] = inside / all;
  });
  RecordProperty("held", std::to_string(held.mean()));
  EXPECT_GE(held.mean(), 0.95 - 4.0 * held.sd());
  EXPECT_LE(held.mean(), 0.99);
}

// All units on one rig that no plan names. Taken as errors of each result alone, 0.7 of the intervals hold where 0.95 are
// stated.
TEST(PriorCoverage, ARigThatNoPlanNamesIsCounted) {
  const FleetModel model{.spread = 0.5, .shared = 2.0};
  const auto without_key = [](Estimate estimate) {
    for (auto& line : estimate.budget)
      if (line.source == "level") line.source = error_names::level_about_east, line.key.clear();
    return estimate;
  };
  Share held, said;
  held.of_fleets.resize(fleets()), said.of_fleets.resize(fleets());
  parallel_for(fleets(), [&](std::size_t f) {
    const auto random = RandomStream(59).split(f);
    std::vector<TestedUnit> tested;
    for (std::uint64_t i = 0; i < 10; ++i) {
      const auto one = testing::fleet_result(model, random, i, 0);
      tested.push_back({one.estimate.instrument_serial, "", false, without_key(one.estimate)});
    }
    const auto population = population_of_units("m", "accelerometer_tumble", tested);
    said.of_fleets[f] = has_finding(population.findings, "rig_not_stated") ? 1.0 : 0.0;
    double inside = 0.0, all = 0.0;
    for (std::uint64_t i = 0; i < 20; ++i) {
      const auto unit = testing::fleet_result(model, random, 1000 + i, 0);
      const auto own = without_key(unit.estimate);
      const auto use = with_population(own, population);
      const Estimate& estimate = use.with_prior ? *use.with_prior : own;
      for (std::size_t k = 0; k < 3; ++k, all += 1.0) inside += holds(estimate, k, unit.truth[k]);
    }
    held.of_fleets[f] = inside / all;
  });
  RecordProperty("held", std::to_string(held.mean()));
  EXPECT_GE(held.mean(), 0.95 - 4.0 * held.sd());
  EXPECT_NEAR(said.mean(), 1.0, 1e-9);
}

// 8 units on 2 to 3 days of 2 results, 3 rigs whose stated errors are shared by key.
TEST(ComponentsCoverage, IntervalsOfArchivedResultsHold) {
  const std::map<std::string, double> truth{
      {"bias_unit_sd", 1.0}, {"bias_day_sd", 0.5}, {"bias_turn_on_sd", 0.3}, {"bias_rig_sd", 0.4}};
  const Unit unit = Unit::parse("deg/h");
  std::map<std::string, double> held;
  std::mutex one_at_a_time;
  double count = 0.0;
  parallel_for(fleets(), [&](std::size_t f) {
    const auto random = RandomStream(47).split(f);
    std::vector<OccasionResult> results;
    std::uint64_t n = 0, d = 0;
    for (std::uint64_t u = 0; u < 8; ++u)
      for (std::uint64_t day = 0; day < 2 + u % 2; ++day, ++d) {
        const std::uint64_t rig = d % 3;
        for (int r = 0; r < 2; ++r, ++n) {
          const double sd = 0.1 + 0.2 * random.split("sd").uniform(n);
          const double value = random.split("unit").normal(u) + 0.5 * random.split("day").normal(d) +
                               0.4 * random.split("rig").normal(rig) + 0.3 * random.split("turn-on").normal(n) +
                               sd * random.split("noise").normal(n) + 0.2 * random.split("stated").normal(rig);
          results.push_back({std::to_string(u), std::to_string(n), std::to_string(day), "T-" + std::to_string(rig),
                             static_cast<double>(n),
                             testing::single_result(value, sd, "T-" + std::to_string(rig), 0.2)});
        }
      }
    const auto found = components_of_results("m", "bias", results);
    const std::scoped_lock lock(one_at_a_time);
    count += 1.0;
    for (const auto& parameter : found.parameters)
      if (const auto known = truth.find(parameter.name); known != truth.end())
        held[parameter.name] +=
            unit.from_si(parameter.lower) <= known->second && known->second <= unit.from_si(parameter.upper);
    held["bias_mean"] += holds(found, 0, 0.0);
  });
  const double band = 4.0 * std::sqrt(0.95 * 0.05 / count);
  EXPECT_EQ(held.size(), 5u);
  for (const auto& [name, number] : held) {
    RecordProperty(name, std::to_string(number / count));
    EXPECT_GE(number / count, 0.95 - band) << name;
  }
}

// Two results of one unit on one rig: the difference is judged by what they do not share.
TEST(DifferenceCoverage, OneInTwentyIsBeyondOneWhateverIsShared) {
  constexpr std::uint64_t pairs = 20;
  for (const double shared : {0.0, 1.0, 3.0}) {
    double beyond = 0.0, all = 0.0;
    for (std::size_t f = 0; f < fleets(); ++f) {
      const auto random = RandomStream(53).split(f).split(static_cast<std::uint64_t>(10.0 * shared));
      for (std::uint64_t i = 0; i < pairs; ++i, all += 1.0) {
        const double rig = shared * random.split("rig").normal(i), truth = random.split("unit").normal(i);
        std::vector<NamedResult> two;
        for (std::uint64_t k = 0; k < 2; ++k)
          two.push_back(
              {std::to_string(k),
               testing::single_result(truth + rig + random.split("noise").normal(2 * i + k), 1.0, "T-1", shared)});
        beyond += std::abs(compare(two).pairs[0].differences[0].e_n) > 1.0;
      }
    }
    RecordProperty("shared " + std::to_string(shared), std::to_string(beyond / all));
    EXPECT_NEAR(beyond / all, 0.05, 4.0 * std::sqrt(0.05 * 0.95 / all)) << shared;
  }
}

}  // namespace
}  // namespace tumble
