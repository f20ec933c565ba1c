// Bias and degrees of freedom from the tables against those of the quadratic forms themselves.

#include "tumble/math/stability/allan_edf_extended.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "tumble/math/stability/allan_family.hpp"
#include "tumble/math/stability/allan_sums.hpp"

namespace tumble {
namespace {

/// Greenhall and Riley (2003), eq. (7), (8): phase averaged over t0 (alpha > 0) or the integral of a rate.
double covariance(long lag, int alpha) {
  const auto w = [&](long double t) {
    t = std::abs(t);
    const long double logarithm = t > 0.0L ? std::log(t) : 0.0L;
    switch (alpha > 0 ? alpha : alpha + 2) {
      case 2:
        return -t;
      case 1:
        return t * t * logarithm;
      default:
        return t * t * t;
    }
  };
  const auto t = static_cast<long double>(std::abs(lag));
  return static_cast<double>(alpha > 0 ? 2.0L * w(t) - w(t - 1.0L) - w(t + 1.0L) : w(t));
}

using Form = std::vector<std::vector<double>>;

/// The matrix of a measure's variance, by v(e_i + e_j) - v(e_i) - v(e_j).
Form form_of(const std::function<double(std::span<const double>)>& variance, std::size_t points) {
  std::vector<double> x(points, 0.0), alone(points);
  Form form(points, std::vector<double>(points));
  for (std::size_t i = 0; i < points; ++i) {
    x[i] = 1.0;
    form[i][i] = alone[i] = variance(x);
    x[i] = 0.0;
  }
  for (std::size_t i = 0; i < points; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      x[i] = x[j] = 1.0;
      form[i][j] = form[j][i] = 0.5 * (variance(x) - alone[i] - alone[j]);
      x[i] = x[j] = 0.0;
    }
  }
  return form;
}

struct Moments {
  double mean = 0.0, edf = 0.0;
};

Moments moments(const Form& form, int alpha) {
  const std::size_t points = form.size();
  Form product(points, std::vector<double>(points, 0.0));
  std::vector<double> of_lag(points);
  for (std::size_t lag = 0; lag < points; ++lag) of_lag[lag] = covariance(static_cast<long>(lag), alpha);
  for (std::size_t i = 0; i < points; ++i)
    for (std::size_t k = 0; k < points; ++k)
      for (std::size_t j = 0; j < points; ++j) product[i][j] += form[i][k] * of_lag[k > j ? k - j : j - k];
  Moments result;
  double squares = 0.0;
  for (std::size_t i = 0; i < points; ++i) {
    result.mean += product[i][i];
    for (std::size_t j = 0; j < points; ++j) squares += product[i][j] * product[j][i];
  }
  result.edf = result.mean * result.mean / squares;
  return result;
}

constexpr std::size_t points = 97;
constexpr int types[] = {2, 1, 0, -1, -2};

Form form_of(Stability measure, std::size_t m) {
  return form_of(
      [&](std::span<const double> x) {
        const std::size_t factors[1] = {m};
        const auto found = stability(measure, x, 1.0, factors, {.alpha = 0, .remove_bias = false});
        return std::pow(found.at(0).deviation, 2);
      },
      points);
}

void expect_tables(Stability measure, Stability plain, double (*bias)(int, std::size_t, double),
                   double (*edf)(int, std::size_t, double), std::initializer_list<std::size_t> factors) {
  for (const std::size_t m : factors) {
    const Form extended = form_of(measure, m), stands_for = form_of(plain, m);
    const double ratio = static_cast<double>(points - 1) / static_cast<double>(m);
    for (const int alpha : types) {
      const Moments found = moments(extended, alpha), same = moments(stands_for, alpha);
      EXPECT_NEAR(bias(alpha, m, ratio) / (found.mean / same.mean), 1.0, alpha > 0 ? 0.015 : 0.006)
          << alpha << " " << m;
      EXPECT_NEAR(edf(alpha, m, ratio) / found.edf, 1.0, m < 8 || alpha == 1 ? 0.12 : 0.05) << alpha << " " << m;
    }
  }
}

TEST(EdfExtended, OfTheTotalVarianceIsThatOfItsMatrix) {
  expect_tables(Stability::total, Stability::overlapping_allan, total_bias, total_edf, {1, 2, 6, 12, 24, 40});
}

TEST(EdfExtended, OfTheModifiedTotalVarianceIsThatOfItsMatrix) {
  const auto bias = [](int alpha, std::size_t m, double) { return modified_total_bias(alpha, m); };
  expect_tables(Stability::modified_total, Stability::modified_allan, bias, modified_total_edf, {1, 2, 3, 8, 16, 24});
}

TEST(EdfExtended, OfTheHadamardTotalVarianceIsThatOfItsMatrix) {
  const auto bias = [](int alpha, std::size_t m, double) { return hadamard_total_bias(alpha, m); };
  expect_tables(Stability::hadamard_total, Stability::overlapping_hadamard, bias, hadamard_total_edf,
                {2, 4, 8, 16, 24});
}

TEST(EdfExtended, OfTheo1IsThatOfItsMatrix) {
  for (const std::size_t m : {10u, 20u, 36u, 60u, 84u}) {
    const Form form = form_of(Stability::theo1, m);
    for (const int alpha : types)
      EXPECT_NEAR(theo1_edf(alpha, m, points) / moments(form, alpha).edf, 1.0, 0.12) << alpha << " " << m;
  }
}

}  // namespace
}  // namespace tumble
