#include "tumble/math/population/components/likelihood.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/math/random.hpp"

namespace tumble::components {
namespace {

/// Units of two to four days on three rigs, with unequal uncertainties and an error that every third result shares.
ManyResults crossed_fleet(std::size_t units) {
  const RandomStream random(7);
  ManyResults out{{}, {}, {{"unit", {}}, {"day", {}}, {"rig", {}}}};
  std::size_t day = 0;
  for (std::size_t u = 0; u < units; ++u)
    for (std::size_t d = 0; d < 2 + u % 3; ++d, ++day)
      for (std::size_t r = 0; r < 1 + day % 2; ++r) {
        out.sds.push_back(0.1 + 0.5 * random.uniform(out.values.size()));
        out.values.push_back(10.0 + random.split("a").normal(u) + 0.5 * random.split("b").normal(day) +
                             random.split("c").normal(day % 3) +
                             std::hypot(1.0, out.sds.back()) * random.split("e").normal(out.values.size()));
        out.factors[0].level.push_back(u);
        out.factors[1].level.push_back(day);
        out.factors[2].level.push_back(day % 3);
      }
  out.shared = Matrix(out.values.size(), 2);
  for (std::size_t i = 0; i < out.values.size(); ++i) out.shared(i, i % 3 == 0) = i % 3 == 2 ? -0.7 : 0.4;
  return out;
}

TEST(SpreadLikelihood, SparseAndDenseAreTheSame) {
  const auto results = crossed_fleet(12);
  const Model model = model_of(results);
  SparseLikelihood sparse(model, 1.0);
  for (const std::vector<double>& variances :
       {std::vector<double>{1.0, 0.25, 1.0, 1.0}, {0.1, 2.0, 0.01, 0.3}, {0.0, 0.5, 0.0, 0.2}, {1.0, 0.0, 0.4, 0.0}}) {
    const auto a = dense_at(model, variances), b = sparse.at(variances);
    EXPECT_NEAR(b.log_likelihood, a.log_likelihood, 1e-6);
    EXPECT_NEAR(b.mean, a.mean, 1e-8);
    EXPECT_NEAR(b.mean_variance, a.mean_variance, 1e-8);
    for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(b.score[c], a.score[c], 1e-4 * (1.0 + std::abs(a.score[c]))) << c;
  }
}

TEST(SpreadLikelihood, TheScoreIsTheSlope) {
  const auto results = crossed_fleet(150);
  const Model model = model_of(results);
  SparseLikelihood sparse(model, 1.0);
  const std::vector<double> variances{0.8, 0.3, 1.2, 0.7};
  const auto at = sparse.at(variances);
  for (std::size_t c = 0; c < 4; ++c) {
    auto above = variances, below = variances;
    above[c] += 1e-4, below[c] -= 1e-4;
    const double slope = (sparse.at(above).log_likelihood - sparse.at(below).log_likelihood) / 2e-4;
    EXPECT_NEAR(at.score[c], slope, 1e-5 * (1.0 + std::abs(slope))) << c;
  }
}

TEST(SpreadLikelihood, AverageInformationIsNearTheExpectedOne) {
  const auto results = crossed_fleet(150);
  const Model model = model_of(results);
  const auto found = components_of_spread(results);
  std::vector<double> variances;
  for (const auto& component : found.components) variances.push_back(component.sd * component.sd);
  const auto a = dense_at(model, variances);
  const auto b = SparseLikelihood(model, 1.0).at(variances);
  for (std::size_t c : {0u, 1u, 3u}) EXPECT_NEAR(b.information(c, c) / a.information(c, c), 1.0, 0.5) << c;
}

TEST(SpreadLikelihood, ManyResultsGiveTheirComponents) {
  const auto results = crossed_fleet(3000);  // 13500 results
  const auto found = components_of_spread(results);
  EXPECT_LE(found.components[0].lower, 1.0);
  EXPECT_GE(found.components[0].upper, 1.0);
  // The interval of components[0], 0.07 wide as below, is 3.92 of its standard deviations: 0.07 is four of them.
  EXPECT_NEAR(found.components[0].sd, 1.0, 0.07);
  EXPECT_NEAR(found.components[1].sd, 0.5, 0.07);
  EXPECT_NEAR(found.components[3].sd, 1.0, 0.05);
  EXPECT_NEAR((found.components[0].upper - found.components[0].lower) / found.components[0].sd, 0.07, 0.03);
}

}  // namespace
}  // namespace tumble::components
