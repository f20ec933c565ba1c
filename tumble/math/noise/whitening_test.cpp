#include "tumble/math/noise/whitening.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

namespace tumble {
namespace {

using Eigen::MatrixXd;

/// Covariance of n averages by fine sums: the process sampled `fine` times in each interval.
MatrixXd covariance_by_fine_sums(const NoiseModel& noise, double interval, double longest, int n, int fine) {
  const int total = n * fine;
  const double step = interval / fine;
  MatrixXd full = MatrixXd::Zero(total, total);
  for (int i = 0; i < total; ++i)
    for (int j = 0; j < total; ++j) {
      const double lag = step * std::abs(i - j), first = step * (std::min(i, j) + 0.5);
      full(i, j) += noise.rate_random_walk * noise.rate_random_walk * first;
      for (const auto& m : flicker_bank(noise.bias_instability, interval, longest))
        full(i, j) += m.sd * m.sd * std::exp(-lag / m.time);
    }
  MatrixXd averages = MatrixXd::Zero(n, total);
  for (int i = 0; i < n; ++i)
    averages.row(i).segment(static_cast<Eigen::Index>(i) * fine, fine).setConstant(1.0 / fine);
  MatrixXd v = averages * full * averages.transpose();
  v.diagonal().array() += noise.angle_random_walk * noise.angle_random_walk / interval;
  return v;
}

TEST(Whitening, IsTheInverseCholeskyFactorOfTheCovariance) {
  NoiseModel noise;
  noise.angle_random_walk = 2.0;
  noise.bias_instability = 0.5;
  noise.rate_random_walk = 0.03;
  const double interval = 10.0, longest = 400.0;
  const int n = 12;
  const MatrixXd v = covariance_by_fine_sums(noise, interval, longest, n, 60);
  Matrix block(n, n);
  for (int i = 0; i < n; ++i) block(i, i) = 1.0;
  const std::vector<double> share(n, 1.0);
  const double log_determinant = Whitening(noise, interval, longest)(block, share);
  const Eigen::Map<MatrixXd> w(block.values.data(), n, n);
  // The fine sums replace integrals: relative error of the midpoint rule (interval/(fine T))^2/24 below 2e-5.
  EXPECT_LT((w * v * w.transpose() - MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff(), 2e-4);
  EXPECT_NEAR(log_determinant, v.llt().matrixL().toDenseMatrix().diagonal().array().log().sum() * 2.0, 1e-3);
}

TEST(Whitening, AMissingRowOnlyLetsTimePass) {
  NoiseModel noise;
  noise.angle_random_walk = 1.0;
  noise.rate_random_walk = 0.2;
  const int n = 6;
  const MatrixXd v = covariance_by_fine_sums(noise, 5.0, 30.0, n, 60);
  Matrix block(n, n);
  for (int i = 0; i < n; ++i) block(i, i) = 1.0;
  const std::vector<double> share{1, 1, 0, 1, 1, 1};
  Whitening(noise, 5.0, 30.0)(block, share);
  const Eigen::Map<MatrixXd> w(block.values.data(), n, n);
  MatrixXd expected = MatrixXd::Identity(n, n);
  expected(2, 2) = 0.0;
  EXPECT_LT((w * v * w.transpose() - expected).cwiseAbs().maxCoeff(), 2e-4);
  EXPECT_EQ(w.col(2).cwiseAbs().maxCoeff(), 0.0);
}

TEST(Whitening, SeriesAndClosedFormOfSlowProcessesMeet) {
  // Times just either side of the switch (ratio 1e-2): the whitened result may not jump.
  const auto last = [](double time) {
    NoiseModel noise;
    noise.angle_random_walk = 0.01;
    noise.markov_sd = 1.0;
    noise.markov_time = time;
    Matrix block(3, 1);
    block(2, 0) = 1.0;
    const std::vector<double> share(3, 1.0);
    Whitening(noise, 1.0, 10.0)(block, share);
    return block(2, 0);
  };
  // The derivative over 1e-9 of the time is of order 1e-9; the series is cut at 1.2e-7 of var e.
  EXPECT_NEAR(last(100.0 * (1 - 1e-9)) / last(100.0 * (1 + 1e-9)), 1.0, 2e-7);
}

}  // namespace
}  // namespace tumble
