#include "tumble/math/population/vector_population.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/random.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

/// Units of p parameters with three common causes; uncertainties are 1, spreads 0.3 to 4.
struct Fleet {
  std::size_t p;
  Matrix causes;  ///< [p x 3]
  std::vector<double> own;

  Fleet(std::size_t parameters, const RandomStream& random) : p(parameters), causes(parameters, 3) {
    for (std::size_t k = 0; k < p; ++k) {
      const double tau = 0.3 * std::pow(13.3, random.split("tau").uniform(k));
      own.push_back(tau / std::sqrt(2.0));
      double length = 0.0;
      for (std::size_t c = 0; c < 3; ++c)
        causes(k, c) = random.split("cause").normal(3 * k + c), length += std::pow(causes(k, c), 2);
      for (std::size_t c = 0; c < 3; ++c) causes(k, c) *= tau / std::sqrt(2.0 * length);
    }
  }

  UnitVector unit(const RandomStream& random, std::vector<double>& truth) const {
    truth.assign(p, 5.0);
    UnitVector out{{}, identity(p)};
    for (std::size_t k = 0; k < p; ++k) {
      for (std::size_t c = 0; c < 3; ++c) truth[k] += causes(k, c) * random.split("shared").normal(c);
      truth[k] += own[k] * random.split("own").normal(k);
      out.values.push_back(truth[k] + random.normal(k));
    }
    return out;
  }
};

TEST(VectorPopulation, OfExactResultsIsTheSampleCovariance) {
  const RandomStream random(3);
  const Fleet fleet(3, random);
  std::vector<UnitVector> units;
  std::vector<double> truth, mean(3, 0.0);
  for (std::uint64_t i = 0; i < 400; ++i) {
    auto unit = fleet.unit(random.split(i), truth);
    unit.values = truth;
    for (std::size_t k = 0; k < 3; ++k) unit.covariance(k, k) = 1e-12, mean[k] += truth[k] / 400.0;
    units.push_back(unit);
  }
  const auto found = vector_population(units);
  EXPECT_NEAR(found.mean[1], mean[1], 1e-6);
  double variance = 0.0;
  for (const auto& unit : units) variance += std::pow(unit.values[1] - mean[1], 2) / 399.0;
  EXPECT_NEAR(found.spread(1, 1), variance, 1e-4 * variance);
}

TEST(VectorPopulationCoverage, NewUnitsAreHeldAlsoByFewerUnitsThanParameters) {
  for (const auto& [p, n] : {std::pair<std::size_t, std::size_t>{6, 20}, {12, 8}}) {
    double held = 0.0, all = 0.0, aliens = 0.0, squares = 0.0;
    for (std::uint64_t f = 0; f < 10; ++f) {
      const RandomStream random = RandomStream(17).split(f);
      const Fleet fleet(p, random);
      std::vector<UnitVector> units;
      std::vector<double> truth;
      for (std::uint64_t i = 0; i < n; ++i) units.push_back(fleet.unit(random.split(i), truth));
      const auto population = vector_population(units);
      const double t = student_quantile(0.975, static_cast<double>(n) - 1.0);
      for (std::uint64_t i = 0; i < 40; ++i) {
        const auto found = vector_in_population(population, fleet.unit(random.split(1000 + i), truth));
        for (std::size_t k = 0; k < p; ++k, all += 1.0) {
          held += std::abs(found.values[k] - truth[k]) <= t * std::sqrt(found.covariance(k, k));
          squares += std::pow(found.values[k] - truth[k], 2);
        }
        aliens += found.belongs < 0.01;
      }
    }
    // 10 fleets decide, not 400 units: between fleets the share scatters by about 0.02
    EXPECT_NEAR(held / all, 0.95, 0.03) << p << " parameters, " << n << " units";
    EXPECT_LT(std::sqrt(squares / all), 0.95) << "better than without the population: 1";
    EXPECT_LE(aliens / 400.0, 0.04) << p << " parameters, " << n << " units";
  }
}

TEST(VectorPopulation, MissingParametersSayNothing) {
  const RandomStream random(8);
  const Fleet fleet(4, random);
  std::vector<UnitVector> units;
  std::vector<double> truth;
  for (std::uint64_t i = 0; i < 12; ++i) units.push_back(fleet.unit(random.split(i), truth));
  const auto whole = vector_population(units);
  auto more = units;
  more.push_back({std::vector<double>(4, std::nan("")), identity(4)});
  const auto population = vector_population(more);
  EXPECT_NEAR(population.mean[2], whole.mean[2], 0.2 * std::sqrt(whole.mean_covariance(2, 2)));
  auto unit = fleet.unit(random.split(100), truth);
  unit.values[3] = std::nan("");
  const auto found = vector_in_population(whole, unit);
  EXPECT_TRUE(std::isfinite(found.values[3]));
  EXPECT_GT(found.covariance(3, 3), 0.5 * whole.spread(3, 3)) << "the population alone says what it is";
}

// The information of both adds: (P^-1 + A' C^-1 A)^-1, as if the population were rows of the fit.
TEST(VectorPopulation, SumsOfParametersAreSeparatedByThePopulation) {
  const RandomStream random(13);
  const Fleet fleet(4, random);
  std::vector<UnitVector> units;
  std::vector<double> truth;
  for (std::uint64_t i = 0; i < 15; ++i) units.push_back(fleet.unit(random.split(i), truth));
  const auto population = vector_population(units);
  ShownOfUnit shown{Matrix(2, 4), {1.3, -0.4}, identity(2)};
  shown.combinations(0, 0) = 1.0, shown.combinations(0, 2) = -0.75;  // the first with part of the third
  shown.combinations(1, 1) = 1.0;
  shown.covariance(0, 1) = shown.covariance(1, 0) = 0.3;
  const auto found = vector_in_population(population, shown);
  const Matrix prior = inverse_symmetric(population.spread + population.mean_covariance);
  const Matrix weight = inverse_symmetric(shown.covariance);
  const Matrix covariance = inverse_symmetric(prior + transposed(shown.combinations) * weight * shown.combinations);
  const auto values =
      covariance * scaled_sum(prior * population.mean, 1.0, transposed(shown.combinations) * (weight * shown.values));
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(found.values[i], values[i], 1e-10) << i;
    for (std::size_t j = 0; j < 4; ++j) EXPECT_NEAR(found.covariance(i, j), covariance(i, j), 1e-10) << i << j;
  }
  EXPECT_LT(found.covariance(0, 0), population.spread(0, 0) + population.mean_covariance(0, 0));
}

TEST(VectorPopulation, AnAlienIsSeenAndSharedErrorsAreAFloor) {
  const RandomStream random(21);
  const Fleet fleet(6, random);
  std::vector<UnitVector> units;
  std::vector<double> truth;
  for (std::uint64_t i = 0; i < 40; ++i) units.push_back(fleet.unit(random.split(i), truth));
  const auto population = vector_population(units);
  auto unit = fleet.unit(random.split(500), truth);
  EXPECT_GT(vector_in_population(population, unit).belongs, 0.001);
  for (auto& value : unit.values) value += 20.0;
  EXPECT_LT(vector_in_population(population, unit).belongs, 1e-4);
  // an error of variance 0.8 in each parameter that the archive has too
  Matrix shared = identity(6);
  for (std::size_t k = 0; k < 6; ++k) shared(k, k) = 0.8;
  auto known = population;
  known.mean_covariance = known.mean_covariance + shared;
  EXPECT_GT(vector_in_population(known, unit, shared).covariance(0, 0), 0.8);
}

TEST(VectorPopulation, RefusesWhatIsNoPopulation) {
  const std::vector<UnitVector> units(4, UnitVector{{1.0}, identity(1)});
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"4"}, .pattern = "at least five units"},
                      [&] { vector_population(units); }));
  std::vector<UnitVector> mixed(6, UnitVector{{1.0, std::nan("")}, identity(2)});
  mixed[2].covariance(0, 0) = -1.0;
  mixed[3] = {{1.0}, identity(1)};
  const Refused refusal = refusal_of([&] { vector_population(mixed); });
  EXPECT_EQ(refusal.problems.size(), 3u);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, {{.values = {"4", "1", "2"}}, {.values = {"3"}}, {.values = {"2", "0"}}},
                      refusal));
}

}  // namespace
}  // namespace tumble
