#include "tumble/math/regression/joint_model.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "tumble/math/eigen/view.hpp"
#include "tumble/math/random.hpp"

namespace tumble {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t segments = 8, rows_each = 6;

/// y = b0 + b1 u + tilt + where + noise, with a tilt common to the outputs, and an error of each place common to them
/// as well. `sense`: how the output shows them.
MixedData output_of(double sense, double noise, const RandomStream& random, const std::vector<double>& drawn) {
  MixedData data;
  const std::size_t n = segments * rows_each;
  data.design = Matrix(n, 2);
  KnownEffect tilt{"tilt", {}, false, {"tilt"}}, place{"place", {}, true, {}};
  for (std::size_t g = 0; g < segments; ++g) place.draws.push_back("place " + std::to_string(g));
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t g = i / rows_each;
    const double u = std::cos(0.9 * static_cast<double>(g));
    data.design(i, 0) = 1.0;
    data.design(i, 1) = u;
    tilt.column.push_back(sense * std::sin(0.7 * static_cast<double>(g)));
    place.column.push_back(0.3 * (1.0 + 0.5 * sense));
    data.weights.push_back(1.0 + static_cast<double>(i % 3));
    data.segment.push_back(g);
    data.observations.push_back(2.0 + 3.0 * u + tilt.column[i] * drawn[segments] + place.column[i] * drawn[g] +
                                noise * random.normal(i) / std::sqrt(data.weights[i]));
  }
  data.effects = {tilt, place};
  return data;
}

struct Pair {
  std::vector<double> drawn;
  std::vector<MixedData> outputs;
  std::vector<MixedFit> alone;
};

Pair pair_of(std::uint64_t seed) {
  const RandomStream random(seed);
  Pair pair;
  for (std::size_t g = 0; g <= segments; ++g) pair.drawn.push_back(random.split("draws").normal(g));
  pair.outputs = {output_of(1.0, 0.2, random.split("a"), pair.drawn),
                  output_of(-2.0, 0.05, random.split("b"), pair.drawn)};
  for (const auto& output : pair.outputs) pair.alone.push_back(fit_mixed_model(output));
  return pair;
}

TEST(JointModel, OfOneOutputIsTheMixedModel) {
  const Pair pair = pair_of(3);
  const auto joint = fit_joint_model(std::span(pair.outputs).first(1), std::span(pair.alone).first(1)).fit;
  const MixedFit& alone = pair.alone[0];
  for (std::size_t j = 0; j < 2; ++j) {
    EXPECT_NEAR(joint.parameters[j], alone.parameters[j], 1e-9);
    for (std::size_t k = 0; k < 2; ++k) EXPECT_NEAR(joint.covariance(j, k), alone.covariance(j, k), 1e-9);
    std::vector<double> one(2, 0.0);
    one[j] = 1.0;
    EXPECT_NEAR(degrees_of_freedom(joint, one), degrees_of_freedom(alone, one), 1e-6 * degrees_of_freedom(alone, one));
  }
  EXPECT_NEAR(joint.chi_square, alone.chi_square, 1e-6 * alone.chi_square);
}

TEST(JointModel, ASourceOfOneDrawKeepsItsSignsAndItsKey) {
  Pair pair = pair_of(6);
  for (auto& output : pair.outputs) output.effects[0].key = "table T1";
  const auto fit = fit_joint_model(pair.outputs, pair.alone).fit;
  const auto& tilt = *std::ranges::find(fit.sources, "tilt", &SourceCovariance::source);
  EXPECT_EQ(tilt.key, "table T1");
  ASSERT_EQ(tilt.shifts.rows, 4u);
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j)
      EXPECT_NEAR(tilt.covariance(i, j), tilt.shifts(i, 0) * tilt.shifts(j, 0),
                  1e-14 * std::sqrt(tilt.covariance(i, i) * tilt.covariance(j, j)));
  // The outputs show the tilt with opposite signs, and so do their biases.
  EXPECT_LT(tilt.shifts(0, 0) * tilt.shifts(2, 0), 0.0);
  const auto& place = *std::ranges::find(fit.sources, "place", &SourceCovariance::source);
  EXPECT_TRUE(place.key.empty() && place.shifts.empty());  // a draw for each segment
}

/// Dense generalised least squares of all rows at once.
TEST(JointModel, IsGeneralisedLeastSquaresOfAllRows) {
  const Pair pair = pair_of(4);
  const auto n = static_cast<Eigen::Index>(segments * rows_each);
  MatrixXd x = MatrixXd::Zero(2 * n, 4), d = MatrixXd::Zero(2 * n, static_cast<Eigen::Index>(segments + 1));
  VectorXd y(2 * n), white(2 * n);
  for (Eigen::Index o = 0; o < 2; ++o) {
    const auto& data = pair.outputs[static_cast<std::size_t>(o)];
    x.block(o * n, 2 * o, n, 2) = map(data.design);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      y[o * n + i] = data.observations[k];
      white[o * n + i] = pair.alone[static_cast<std::size_t>(o)].white_variance / data.weights[k];
      d(o * n + i, static_cast<Eigen::Index>(segments)) = data.effects[0].column[k];
      d(o * n + i, static_cast<Eigen::Index>(data.segment[k])) = data.effects[1].column[k];
    }
  }
  MatrixXd v = d * d.transpose();
  v.diagonal() += white;
  const Eigen::LLT<MatrixXd> root(v);
  const MatrixXd covariance = (x.transpose() * root.solve(x)).inverse();
  const VectorXd b = covariance * x.transpose() * root.solve(y), weighted = root.solve(VectorXd(y - x * b));

  const auto joint = fit_joint_model(pair.outputs, pair.alone);
  for (std::size_t j = 0; j < 4; ++j) {
    EXPECT_NEAR(joint.fit.parameters[j], b[at(j)], 1e-9);
    for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(joint.fit.covariance(j, k), covariance(at(j), at(k)), 1e-9);
  }
  ASSERT_EQ(joint.effects.size(), segments + 1);
  const MatrixXd left = MatrixXd::Identity(d.cols(), d.cols()) - d.transpose() * root.solve(d) +
                        d.transpose() * root.solve(x) * covariance * x.transpose() * root.solve(d);
  for (const auto& effect : joint.effects) {
    const Eigen::Index k = effect.draw == "tilt" ? at(segments) : std::stol(effect.draw.substr(6));
    EXPECT_NEAR(effect.value, d.col(k).dot(weighted), 1e-9) << effect.draw;
    EXPECT_NEAR(effect.sd * effect.sd, left(k, k), 1e-9) << effect.draw;
  }
}

/// What one output shows of the tilt is taken off the other: smaller uncertainties, and they hold.
TEST(JointModel, ItsCovarianceHoldsAndIsSmallerThanOfTheOutputsAlone) {
  constexpr int trials = 400;
  int inside = 0, of_draws = 0;
  for (int t = 0; t < trials; ++t) {
    const Pair pair = pair_of(100 + static_cast<std::uint64_t>(t));
    const auto joint = fit_joint_model(pair.outputs, pair.alone);
    const double truth[4] = {2.0, 3.0, 2.0, 3.0};
    for (std::size_t j = 0; j < 4; ++j) {
      const double sd = std::sqrt(joint.fit.covariance(j, j));
      EXPECT_LT(sd, std::sqrt(pair.alone[j / 2].covariance(j % 2, j % 2)) * (1.0 + 1e-9));
      inside += std::abs(joint.fit.parameters[j] - truth[j]) < 1.96 * sd;
    }
    for (const auto& effect : joint.effects) {
      const std::size_t k = effect.draw == "tilt" ? segments : std::stoul(effect.draw.substr(6));
      of_draws += std::abs(effect.value - pair.drawn[k]) < 1.96 * effect.sd;
    }
  }
  // trials are independent, parameters of one are not: 4 sigma as if each trial counted once
  const double band = 4.0 * std::sqrt(0.95 * 0.05 / trials);
  EXPECT_NEAR(inside / (4.0 * trials), 0.95, band);
  EXPECT_NEAR(of_draws / ((segments + 1.0) * trials), 0.95, band);
}

}  // namespace
}  // namespace tumble
