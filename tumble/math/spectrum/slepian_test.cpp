#include "tumble/math/spectrum/slepian.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

double product(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// Largest element of A v - lambda v, A_ij = sin(2 pi W (i - j))/(pi (i - j)): what defines the sequences.
double residual_of_kernel(const SlepianTaper& taper, double bandwidth) {
  const auto& v = taper.values;
  double worst = 0.0;
  for (std::size_t i = 0; i < v.size(); ++i) {
    double sum = 0.0;
    for (std::size_t j = 0; j < v.size(); ++j) {
      const double t = std::numbers::pi * (static_cast<double>(i) - static_cast<double>(j));
      sum += v[j] * (i == j ? 2.0 * bandwidth : std::sin(2.0 * bandwidth * t) / t);
    }
    worst = std::max(worst, std::abs(sum - taper.concentration * v[i]));
  }
  return worst;
}

TEST(SlepianTapers, SolveTheKernelTheyMaximiseAndAreOrthonormal) {
  for (const std::size_t length : {16u, 101u, 1000u}) {
    const auto tapers = slepian_tapers(length, 4.0, 7);
    for (std::size_t k = 0; k < tapers.size(); ++k) {
      EXPECT_LT(residual_of_kernel(tapers[k], 4.0 / static_cast<double>(length)), 1e-11) << length << " " << k;
      for (std::size_t j = 0; j <= k; ++j)
        EXPECT_NEAR(product(tapers[j].values, tapers[k].values), j == k ? 1.0 : 0.0, 1e-11) << length << " " << k;
      if (k > 0) {
        EXPECT_LT(tapers[k].concentration, tapers[k - 1].concentration);
      }
    }
  }
}

// D. Slepian and H. O. Pollak, Bell Syst. Tech. J. 40 (1961) 43, table I: lambda_n(c), five digits. N W = c/pi in the
// limit of long sequences, whose concentration differs by less than 1e-6 at N = 4096.
TEST(SlepianTapers, HaveThePublishedConcentrations) {
  const double published[3][4] = {{0.57258, 0.062791, 0.0012375, 0.0000092010},
                                  {0.88056, 0.35564, 0.035868, 0.0011522},
                                  {0.99589, 0.91211, 0.51905, 0.11021}};
  for (int row = 0; row < 3; ++row) {
    const auto tapers = slepian_tapers(4096, std::exp2(row) / std::numbers::pi, 4);
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_NEAR(tapers[k].concentration, published[row][k], std::max(1e-8, 5.5e-5 * published[row][k])) << row << k;
  }
}

TEST(SlepianTapers, AreSymmetricAndOfTheUsualSign) {
  const auto tapers = slepian_tapers(101, 3.0, 5);
  for (std::size_t k = 0; k < tapers.size(); ++k) {
    const auto& v = tapers[k].values;
    for (std::size_t i = 0; i < v.size(); ++i) EXPECT_EQ(v[i], (k % 2 == 0 ? 1.0 : -1.0) * v[v.size() - 1 - i]);
    double sum = 0.0, first = 0.0;
    for (std::size_t i = 0; i < v.size(); ++i) {
      sum += v[i];
      first += v[i] * (50.0 - static_cast<double>(i));
    }
    EXPECT_GT(k % 2 == 0 ? sum : first, 0.0) << k;
  }
  EXPECT_TRUE(refuses(Error::Kind::bad_input,
                      {{.pattern = "a length of 2"}, {.pattern = "time-bandwidth"}, {.pattern = "not more tapers"}},
                      [&] { slepian_tapers(1, 0.0, 2); }));
}

}  // namespace
}  // namespace tumble
