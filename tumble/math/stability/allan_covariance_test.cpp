#include "tumble/math/stability/allan_covariance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tumble/math/noise_model.hpp"

namespace tumble {
namespace {

const std::vector<UnitTerm> all_terms{
    {NoiseTerm::quantization}, {NoiseTerm::white}, {NoiseTerm::flicker}, {NoiseTerm::random_walk}};

std::vector<double> allan_variances(const std::vector<double>& rate, const std::vector<std::size_t>& factors) {
  std::vector<double> angle(rate.size() + 1, 0.0), variances;
  for (std::size_t i = 0; i < rate.size(); ++i) angle[i + 1] = angle[i] + rate[i];
  for (const std::size_t m : factors) {
    double sum = 0.0;
    const std::size_t count = angle.size() - 2 * m;
    for (std::size_t i = 0; i < count; ++i) {
      const double d = angle[i + 2 * m] - 2.0 * angle[i + m] + angle[i];
      sum += d * d;
    }
    variances.push_back(sum / (2.0 * static_cast<double>(m * m * count)));
  }
  return variances;
}

/// Empirical covariance over independent records against the formula, each entry within 4 standard errors. The error of
/// a covariance of n records is sqrt((V_ii V_jj + V_ij^2)/n) for Gaussian variates; the variances are skewed and have
/// excess kurtosis 12/edf, which the factor from the sampled fourth moment takes in.
void expect_covariance(const NoiseModel& noise, std::size_t samples, double model_error = 0.0) {
  const std::vector<std::size_t> factors{1, 2, 4, 8, 16, 40, 100, 250};
  const AllanCovariance covariance(all_terms, factors, samples);
  const auto square = [](double x) { return x * x; };
  const Matrix expected = covariance.at({square(noise.quantization_noise), square(noise.angle_random_walk),
                                         square(noise.bias_instability), square(noise.rate_random_walk)});
  const std::size_t records = 3000, n = factors.size();
  std::vector<std::vector<double>> drawn;
  for (std::size_t seed = 0; seed < records; ++seed) {
    std::vector<double> signal(samples, 0.0);
    add_noise(noise, 1.0, RandomStream(900000 + seed), signal);
    drawn.push_back(allan_variances(signal, factors));
  }
  std::vector<double> mean(n, 0.0);
  for (const auto& one : drawn)
    for (std::size_t i = 0; i < n; ++i) mean[i] += one[i] / static_cast<double>(records);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = 0.0, squares = 0.0;
      for (const auto& one : drawn) {
        const double product = (one[i] - mean[i]) * (one[j] - mean[j]);
        sum += product;
        squares += product * product;
      }
      const auto count = static_cast<double>(records);
      const double found = sum / count;
      const double error = std::sqrt((squares / count - found * found) / count);
      const double scale = std::sqrt(expected(i, i) * expected(j, j));
      EXPECT_NEAR(found / scale, expected(i, j) / scale, 4.0 * error / scale + model_error)
          << factors[i] << " and " << factors[j];
    }
}

TEST(allan_covariance, quantization) { expect_covariance({.quantization_noise = 1.0}, 1000); }
TEST(allan_covariance, white) { expect_covariance({.angle_random_walk = 1.0}, 1000); }
// The simulated bank is within 1 % of the power law over these factors (noise_model_test), twice that in its square.
TEST(allan_covariance, flicker) { expect_covariance({.bias_instability = 1.0}, 1000, 0.02); }
TEST(allan_covariance, random_walk) { expect_covariance({.rate_random_walk = 1.0}, 1000); }
TEST(allan_covariance, mix) {
  expect_covariance(
      {.quantization_noise = 1.0, .angle_random_walk = 1.0, .bias_instability = 0.2, .rate_random_walk = 0.02}, 1000,
      0.01);
}

TEST(allan_covariance, white_noise_has_the_known_degrees_of_freedom) {
  // m = 1: differences of neighbours; sum of C^2 = 4 N - 4 + 2 (N - 2) over N - 1 terms, exactly 2 N^2 sum/...:
  // edf = (N-1)^2 4 / (4 (N-1) + 2 (N-2)).
  const double n = 500.0;
  const AllanCovariance covariance({{NoiseTerm::white}}, {1}, 500);
  EXPECT_NEAR(2.0 / covariance.at({1.0})(0, 0), 4.0 * (n - 1.0) * (n - 1.0) / (4.0 * (n - 1.0) + 2.0 * (n - 2.0)),
              1e-9);
}

TEST(allan_covariance, integrals_agree_with_sums) {
  // The same factors scaled: long records are integrated, and must approach what short ones sum.
  const std::vector<UnitTerm> terms{{NoiseTerm::white}, {NoiseTerm::flicker}, {NoiseTerm::random_walk}};
  const AllanCovariance small(terms, {24, 48, 200}, 1000), large(terms, {2400, 4800, 20000}, 100000);
  for (const auto& c : std::vector<std::vector<double>>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
    const Matrix a = small.at(c), b = large.at(c);
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) {
        const double of_small = a(i, j) / std::sqrt(a(i, i) * a(j, j)),
                     of_large = b(i, j) / std::sqrt(b(i, i) * b(j, j));
        EXPECT_NEAR(of_small, of_large, 0.005);
      }
  }
}

}  // namespace
}  // namespace tumble
