#include "tumble/math/stability/joint_stability.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <string>

#include "tumble/math/extremes.hpp"
#include "tumble/math/matrix.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/math/random.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/room.hpp"
#include "tumble/math/square.hpp"
#include "tumble/math/stability/allan.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// [1] of a diagonal element: rounding; a sd of the correlation needs more than 2.
constexpr double least_rest = 1e-14, least_edf = 3.0;

constexpr std::size_t draws = 4000;

using Points = std::vector<DeviationPoint>;

Points variances(std::span<const double> values, double rate, std::span<const std::size_t> factors) {
  return overlapping_allan(values, rate, factors, 0.95);
}

bool complete(std::span<const double> values) { return extremes_of(values).present == values.size(); }

void check_signals(std::span<const double> a, std::span<const double> b, double confidence) {
  if (a.size() != b.size() || !(confidence > 0.0 && confidence < 1.0))
    throw Error(Error::Kind::bad_input, "two signals of the same length and a confidence between 0 and 1 are needed");
}

/// P(|t| > value)
double tails(double value, double freedom) {
  return 2.0 * boost::math::cdf(boost::math::complement(boost::math::students_t(freedom), std::abs(value)));
}

/// a - b scale; missing where one is.
std::vector<double> difference(std::span<const double> a, std::span<const double> b, double scale) {
  std::vector<double> result;
  make_room(result, a.size());
  result.resize(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) result[i] = a[i] - scale * b[i];
  return result;
}

/// The samples of `a` where `b` has one.
std::vector<double> where_both(std::span<const double> a, std::span<const double> b) {
  std::vector<double> result(a.begin(), a.end());
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::isnan(b[i])) result[i] = b[i];
  return result;
}

/// Chi-square numbers of `freedom` >= 2 by G. Marsaglia and W. W. Tsang, ACM Trans. Math. Softw. 26 (2000) 363.
class ChiSquares {
 public:
  explicit ChiSquares(const RandomStream& stream)
      : normals_(stream.split("normal")), uniforms_(stream.split("uniform")) {}
  double normal() { return normals_.normal(normal_++); }
  double next(double freedom) {
    const double d = 0.5 * freedom - 1.0 / 3.0, c = 1.0 / std::sqrt(9.0 * d);
    while (true) {
      const double x = normal(), root = 1.0 + c * x, v = root * root * root;
      const double u = uniforms_.uniform(uniform_++);
      if (root > 0.0 && std::log(u) < 0.5 * x * x + d - d * v + d * std::log(v)) return 2.0 * d * v;
    }
  }

 private:
  RandomStream normals_, uniforms_;
  std::uint64_t normal_ = 0, uniform_ = 0;
};

/// Lower triangles T of Bartlett's decomposition of Wishart matrices with `edf` degrees of freedom.
std::vector<Matrix> triangles(std::size_t size, double edf) {
  ChiSquares random(RandomStream(1974).split("three_cornered_hat"));
  std::vector<Matrix> result(draws, Matrix(size, size));
  for (Matrix& triangle : result) {
    for (std::size_t i = 0; i < size; ++i) {
      for (std::size_t j = 0; j < i; ++j) triangle(i, j) = random.normal();
      triangle(i, i) = std::sqrt(random.next(edf - static_cast<double>(i)));
    }
  }
  return result;
}

/// Lower triangle L with L L' = a; false if a is not positive definite.
bool cholesky(const Matrix& a, Matrix& lower) {
  lower = Matrix(a.rows, a.rows);
  for (std::size_t i = 0; i < a.rows; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double rest = a(i, j);
      for (std::size_t k = 0; k < j; ++k) rest -= lower(i, k) * lower(j, k);
      if (i == j && !(rest > least_rest * a(i, i))) return false;
      lower(i, j) = i == j ? std::sqrt(rest) : rest / lower(j, j);
    }
  }
  return true;
}

double mean_beside_diagonal(const Matrix& a) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.rows; ++i)
    for (std::size_t j = 0; j < i; ++j) sum += a(i, j);
  return sum / (0.5 * static_cast<double>(a.rows * (a.rows - 1)));
}

/// Mean of the covariances in L T^-1 T^-T L'.
double drawn(const Matrix& lower, const Matrix& triangle) {
  const std::size_t size = lower.rows;
  Matrix c(size, size);  // C T = L
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t j = i + 1; j-- > 0;) {
      double rest = lower(i, j);
      for (std::size_t k = j + 1; k <= i; ++k) rest -= c(i, k) * triangle(k, j);
      c(i, j) = rest / triangle(j, j);
    }
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < size; ++i)
    for (std::size_t j = 0; j < i; ++j)
      for (std::size_t k = 0; k <= j; ++k) sum += c(i, k) * c(j, k);
  return sum / (0.5 * static_cast<double>(size * (size - 1)));
}

HatPoint::Instrument instrument(const Matrix& covariances, double edf, const std::vector<Matrix>& triangles,
                                double confidence) {
  HatPoint::Instrument result{mean_beside_diagonal(covariances), 0.0, 0.0};
  Matrix scaled = covariances, lower;
  for (double& value : scaled.values) value *= edf;
  if (!cholesky(scaled, lower))
    throw Error(Error::Kind::bad_data, "two of the instruments give the same signal, or one the sum of others");
  std::vector<double> values;
  values.reserve(triangles.size());
  for (const auto& triangle : triangles) values.push_back(drawn(lower, triangle));
  std::sort(values.begin(), values.end());
  const auto at = [&](double p) { return values[static_cast<std::size_t>(p * static_cast<double>(draws))]; };
  result.lower = std::max(0.0, at(0.5 * (1.0 - confidence)));
  result.upper = std::max(0.0, at(0.5 * (1.0 + confidence)));
  return result;
}

/// Samples that every instrument has; nothing where all have all.
std::vector<std::vector<double>> common_samples(std::span<const std::span<const double>> rates) {
  std::vector<std::vector<double>> result;
  if (std::ranges::all_of(rates, complete)) return result;
  for (const auto& one : rates) result.emplace_back(one.begin(), one.end());
  for (std::size_t n = 0; n < result.front().size(); ++n) {
    const bool missing = std::any_of(result.begin(), result.end(), [&](const auto& one) { return std::isnan(one[n]); });
    if (!missing) continue;
    for (auto& one : result) one[n] = std::nan("");
  }
  return result;
}

/// From the variances of both, of the samples that both have.
std::vector<AllanCorrelation> correlation(std::span<const double> a, std::span<const double> b, const Points& of_first,
                                          const Points& of_second, double rate, std::span<const std::size_t> factors,
                                          double confidence) {
  if (of_first.empty() || of_first.front().deviation == 0.0 || of_second.front().deviation == 0.0) return {};
  const double scale = of_first.front().deviation / of_second.front().deviation;
  const auto of_rest = variances(difference(a, b, scale), rate, factors);
  std::vector<AllanCorrelation> result;
  for (std::size_t i = 0; i < of_first.size(); ++i) {
    const auto &one = of_first[i], &other = of_second[i];
    const double edf = std::sqrt(one.edf * other.edf), of_other = scale * other.deviation;
    if (!(edf > least_edf) || one.deviation == 0.0 || of_other == 0.0) continue;
    const double covariance = 0.5 * (square(one.deviation) + square(of_other) - square(of_rest[i].deviation));
    const double r = std::clamp(covariance / (one.deviation * of_other), -1.0, 1.0);
    AllanCorrelation point{one.factor, one.tau, r, -1.0, 1.0, 0.0, edf};
    const double reach =
        student_quantile(0.5 * (1.0 + confidence), std::numeric_limits<double>::infinity()) / std::sqrt(edf - 2.0);
    if (std::abs(r) < 1.0) {
      point.lower = std::tanh(std::atanh(r) - reach);
      point.upper = std::tanh(std::atanh(r) + reach);
      point.chance = tails(r * std::sqrt((edf - 1.0) / (1.0 - r * r)), edf - 1.0);
    }
    result.push_back(point);
  }
  return result;
}

}  // namespace

std::vector<AllanCorrelation> allan_correlation(std::span<const double> a, std::span<const double> b, double rate,
                                                std::span<const std::size_t> factors, double confidence) {
  check_signals(a, b, confidence);
  const auto first = where_both(a, b), second = where_both(b, a);
  return correlation(first, second, variances(first, rate, factors), variances(second, rate, factors), rate, factors,
                     confidence);
}

std::vector<SignalPair> allan_correlations(std::span<const std::span<const double>> signals, double rate,
                                           std::span<const std::size_t> factors, double confidence) {
  std::vector<SignalPair> pairs;
  for (std::size_t a = 0; a < signals.size(); ++a)
    for (std::size_t b = a + 1; b < signals.size(); ++b) {
      check_signals(signals[a], signals[b], confidence);
      pairs.push_back({a, b, {}});
    }
  std::vector<Points> whole(signals.size());  // of signals that miss no sample
  parallel_for(signals.size(), [&](std::size_t i) {
    if (complete(signals[i])) whole[i] = variances(signals[i], rate, factors);
  });
  parallel_for(pairs.size(), [&](std::size_t i) {
    const auto &a = signals[pairs[i].a], &b = signals[pairs[i].b];
    const auto &of_a = whole[pairs[i].a], &of_b = whole[pairs[i].b];
    pairs[i].points = of_a.empty() || of_b.empty() ? allan_correlation(a, b, rate, factors, confidence)
                                                   : correlation(a, b, of_a, of_b, rate, factors, confidence);
  });
  return pairs;
}

std::vector<HatPoint> three_cornered_hat(std::span<const std::span<const double>> rates, double rate,
                                         std::span<const std::size_t> factors, double confidence) {
  const std::size_t count = rates.size();
  const bool even = std::all_of(rates.begin(), rates.end(), [&](auto one) { return one.size() == rates[0].size(); });
  if (count < 3 || !even || !(confidence > 0.0 && confidence < 1.0))
    throw Error(Error::Kind::bad_input,
                "a three-cornered hat needs three or more signals of the same length and a confidence between 0 and 1");
  const auto common = common_samples(rates);
  std::vector<std::span<const double>> signals(rates.begin(), rates.end());
  if (!common.empty()) signals.assign(common.begin(), common.end());
  std::vector<Points> pairs(count * count);
  parallel_for(count * count, [&](std::size_t at) {
    const std::size_t i = at / count, j = at % count;
    if (j < i) pairs[at] = variances(difference(signals[i], signals[j], 1.0), rate, factors);
  });
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j < i; ++j) pairs[j * count + i] = pairs[i * count + j];
  std::vector<HatPoint> result;
  for (std::size_t n = 0; n < pairs[1].size(); ++n) {
    const auto v = [&](std::size_t i, std::size_t j) {
      return i == j ? 0.0 : square(pairs[i * count + j][n].deviation);
    };
    HatPoint point{pairs[1][n].factor, pairs[1][n].tau, pairs[1][n].edf, {}};
    for (const auto& pair : pairs)
      if (!pair.empty()) point.edf = std::min(point.edf, pair[n].edf);
    if (point.edf < static_cast<double>(count)) continue;  // the last chi-square then has 2 or more
    const auto random = triangles(count - 1, point.edf);
    for (std::size_t i = 0; i < count; ++i) {
      Matrix covariances(count - 1, count - 1);
      for (std::size_t a = 0; a + 1 < count; ++a)
        for (std::size_t b = 0; b + 1 < count; ++b) {
          const std::size_t j = a < i ? a : a + 1, k = b < i ? b : b + 1;
          covariances(a, b) = 0.5 * (v(i, j) + v(i, k) - v(j, k));
        }
      point.instruments.push_back(instrument(covariances, point.edf, random, confidence));
    }
    result.push_back(std::move(point));
  }
  return result;
}

}  // namespace tumble
