#include "tumble/math/noise/noise_likelihood.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tumble/math/noise_model.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using std::numbers::pi;

std::vector<double> simulated(const NoiseModel& model, double rate, std::size_t samples, std::uint64_t seed) {
  std::vector<double> values(samples, 0.0);
  add_noise(model, rate, RandomStream(seed), values);
  return values;
}

/// Weights of a contrast on the units it is made of.
std::vector<double> weights(const NoiseBand& band) {
  std::vector<double> w;
  if (band.radix > 0) {
    for (int i = 0; i < band.radix; ++i)
      w.push_back(std::sqrt(2.0 / band.radix) * std::cos(pi * band.order * (i + 0.5) / band.radix));
    return w;
  }
  const int size = static_cast<int>(std::lround(1.0 / band.shortness));
  w.assign(static_cast<std::size_t>(size), 0.0);
  for (std::size_t j = 1; j < w.size(); ++j) {
    const double sine =
        std::sqrt(2.0 / size) * std::sin(2.0 * pi * band.frequency * band.unit * static_cast<double>(j));
    w[j] += sine;
    w[j - 1] -= sine;
  }
  return w;
}

/// Variance of a contrast from the generalised autocovariance of the integral at its 2 w.size() ends.
double direct(const NoiseBand& band, NoiseTerm term) {
  const auto w = weights(band);
  std::vector<double> ends(w.size() + 1, 0.0);
  for (std::size_t i = 0; i < w.size(); ++i) {
    ends[i + 1] += w[i] / band.unit;
    ends[i] -= w[i] / band.unit;
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < ends.size(); ++i)
    for (std::size_t j = 0; j < ends.size(); ++j) {
      const double lag = std::abs(static_cast<double>(i) - static_cast<double>(j)) * band.unit;
      sum += ends[i] * ends[j] * generalised_autocovariance({term}, lag);
    }
  return sum;
}

double direct_markov(const NoiseBand& band, double time) {
  const auto w = weights(band);
  const double r = band.unit / time, gone = -std::expm1(-r);
  double sum = 0.0;
  for (std::size_t i = 0; i < w.size(); ++i)
    for (std::size_t j = 0; j < w.size(); ++j) {
      const double lag = std::abs(static_cast<double>(i) - static_cast<double>(j));
      sum +=
          w[i] * w[j] * (lag == 0.0 ? 2.0 * (r - gone) / (r * r) : std::exp(-(lag - 1.0) * r) * gone * gone / (r * r));
    }
  return sum;
}

TEST(NoiseBands, ExpectationsAreThoseOfTheCovariance) {
  // Double sums of up to 40 000 terms of either sign: 1e-7 is above their rounding.
  std::vector<NoiseBand> bands;
  const auto white = simulated({.angle_random_walk = 1.0}, 1.0, 300000, 1);
  for (const auto& band : NoiseBands(white).bands)
    if (band.radix > 0) bands.push_back(band);
  EXPECT_EQ(bands.size(), 15u + 1u);  // 16, then 2: 9375 values are left
  const NoiseBands slow{std::span<const double>(white).first(200)};
  for (std::size_t i = 0; i < 32; ++i) bands.push_back(slow.bands[i]);
  for (const auto& band : bands) {
    for (std::size_t t = 0; t < power_law_terms.size(); ++t)
      EXPECT_NEAR(band.expected[t] / direct(band, power_law_terms[t]), 1.0, 1e-7)
          << band.radix << " " << band.frequency;
    for (const double units : {0.3, 3.0})
      EXPECT_NEAR(expected_markov(band, units * band.unit) / direct_markov(band, units * band.unit), 1.0, 1e-7);
  }
}

TEST(NoiseBands, ContrastsKeepTheSumOfSquares) {
  // The cosines and the means of their blocks are an orthonormal basis; the sines are one of the differences.
  const auto values = simulated({.angle_random_walk = 1.0}, 1.0, 32768, 2);
  const NoiseBands bands(values);
  double fast = 0.0, slow = 0.0, squares = 0.0, means = 0.0, differences = 0.0, before = 0.0;
  for (const auto& band : bands.bands) (band.radix > 0 ? fast : slow) += band.count * band.mean_square;
  for (const double value : values) squares += value * value;
  for (std::size_t b = 0; b < values.size() / 2; ++b) {
    const double mean = 0.5 * (values[2 * b] + values[2 * b + 1]);
    means += 2.0 * mean * mean;
    if (b > 0) differences += (mean - before) * (mean - before);
    before = mean;
  }
  EXPECT_NEAR(fast, squares - means, 1e-9 * squares);
  EXPECT_NEAR(slow, differences, 1e-9 * differences);
}

/// -2 ln L of the differences under c_N and c_K, dense: covariance of neighbours -c_N + c_K/6 and diagonal 2 c_N + 2
/// c_K/3.
double dense_likelihood(const std::vector<double>& values, double white, double walk) {
  const auto n = static_cast<Eigen::Index>(values.size()) - 1;
  MatrixXd v = MatrixXd::Zero(n, n);
  VectorXd d(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    d[i] = values[static_cast<std::size_t>(i) + 1] - values[static_cast<std::size_t>(i)];
    v(i, i) = 2.0 * white + 2.0 * walk / 3.0;
    if (i > 0) v(i, i - 1) = v(i - 1, i) = -white + walk / 6.0;
  }
  const Eigen::LLT<MatrixXd> cholesky(v);
  return cholesky.matrixL().solve(d).squaredNorm() + 2.0 * MatrixXd(cholesky.matrixL()).diagonal().array().log().sum();
}

/// A record from which each sample is missing with this probability, independently of the others.
std::vector<double> with_losses(std::vector<double> values, double share, std::uint64_t seed) {
  const auto losses = RandomStream(seed).split("losses");
  for (std::size_t i = 0; i < values.size(); ++i)
    if (losses.uniform(i) < share) values[i] = std::nan("");
  return values;
}

TEST(NoiseBands, ExpectationsAreThoseOfThePatternOfMissingSamples) {
  // 30 records with every fifth sample missing at random, each with other losses: in each of 40 ranges of frequencies
  // the power over that expected, within 5 of its standard errors (160 comparisons). Before, white noise was 25 %
  // above.
  const std::size_t samples = 20000;
  const NoiseModel models[] = {
      {.quantization_noise = 1.0}, {.angle_random_walk = 1.0}, {.bias_instability = 1.0}, {.rate_random_walk = 1.0}};
  for (std::size_t t = 0; t < power_law_terms.size(); ++t) {
    std::vector<double> ratio(40, 0.0), count(40, 0.0);
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
      const NoiseBands bands(with_losses(simulated(models[t], 1.0, samples, seed), 0.2, seed));
      for (const auto& band : bands.bands) {
        const auto range =
            static_cast<std::size_t>(40.0 * std::log(2.0 * band.frequency * samples) / std::log(samples));
        ratio[std::min<std::size_t>(range, 39)] += band.count * band.mean_square / band.expected[t];
        count[std::min<std::size_t>(range, 39)] += band.count;
      }
    }
    // Flicker is simulated to 1 % of its power at any frequency; steep noise leaks between the cosines of a block.
    for (std::size_t r = 0; r < ratio.size(); ++r) {
      if (count[r] <= 30.0) continue;
      EXPECT_NEAR(ratio[r] / count[r], 1.0, 0.01 + (t == 1 ? 5.0 : 8.0) * std::sqrt(2.0 / count[r])) << t << " " << r;
    }
  }
}

TEST(NoiseLikelihood, TakesRecordsWithSingleSamplesMissing) {
  // 40 records each: 95 % intervals hold in 40 - 6 or more (4 sigma of the binomial distribution), the mean lies within
  // 4 standard errors, and a false process is as rare as in whole records (1 in 1000).
  for (const double share : {0.05, 0.2}) {
    int held = 0, processes = 0;
    double sum = 0.0, squares = 0.0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      const auto values = with_losses(simulated({.angle_random_walk = 1.0}, 1.0, 40000, seed), share, seed);
      const NoiseFit fit = fit_noise(NoiseBands(values), {});
      const FittedTerm& white = fit.terms[1];
      ASSERT_TRUE(white.kept);
      const double value = std::sqrt(white.squared) * white.root_correction,
                   sd = 0.5 * white.squared_sd / std::sqrt(white.squared);
      held += std::abs(value - 1.0) <= student_quantile(0.975, white.degrees_of_freedom) * sd ? 1 : 0;
      processes += fit.terms.size() > power_law_terms.size() ? 1 : 0;
      sum += value - 1.0;
      squares += (value - 1.0) * (value - 1.0);
    }
    EXPECT_GE(held, 34) << share;
    EXPECT_LE(processes, 1) << share;
    EXPECT_LT(std::abs(sum), 4.0 * std::sqrt(squares)) << share;
  }
}

TEST(NoiseLikelihood, CountsTheTailsOfNoiseThatIsNotGaussian) {
  // Student's t of 5 degrees of freedom has a kurtosis of 9: the sd of a power is sqrt(4) times that of Gaussian noise.
  // 60 records: 95 % intervals hold in 57 - 7 (4 sigma of the binomial distribution); before, in two thirds.
  int held = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const auto stream = RandomStream(seed).split("tails");
    std::vector<double> values;
    for (std::uint64_t i = 0; i < 20000; ++i) {
      double squares = 0.0;
      for (std::uint64_t k = 1; k <= 5; ++k) squares += std::pow(stream.normal(6 * i + k), 2) / 5.0;
      values.push_back(stream.normal(6 * i) / std::sqrt(squares * 5.0 / 3.0));
    }
    const NoiseFit fit = fit_noise(NoiseBands(values), {});
    const FittedTerm& white = fit.terms[1];
    const double value = std::sqrt(white.squared) * white.root_correction,
                 sd = 0.5 * white.squared_sd / std::sqrt(white.squared);
    held += std::abs(value - 1.0) <= student_quantile(0.975, white.degrees_of_freedom) * sd ? 1 : 0;
    EXPECT_GT(fit.scatter_ratio,
              1.0);  // 2 in the mean over its square; the eighth moment is infinite: low in most records
  }
  EXPECT_GE(held, 50);
}

TEST(NoiseLikelihood, GaussianRecordsKeepTheirEfficientIntervals) {
  const NoiseModel models[] = {{.angle_random_walk = 1.0},
                               {.quantization_noise = 1.0},
                               {.bias_instability = 1.0},
                               {.rate_random_walk = 1.0},
                               {.angle_random_walk = 1.0, .bias_instability = 0.2, .rate_random_walk = 0.01}};
  for (const NoiseModel& model : models)
    for (const std::size_t samples : {1000u, 20000u, 140000u})
      for (std::uint64_t seed = 1; seed <= 8; ++seed)
        EXPECT_EQ(fit_noise(NoiseBands(simulated(model, 1.0, samples, seed)), {}).scatter_ratio, 1.0) << samples;
}

TEST(NoiseLikelihood, ShortRecordsOfAnyKindGiveNumbersOrAnError) {
  // Windows of 16 to 80 samples, some with gaps: every kept term has a standard deviation and degrees of freedom.
  const NoiseModel models[] = {{.quantization_noise = 1.0},
                               {.angle_random_walk = 1.0},
                               {.bias_instability = 1.0},
                               {.rate_random_walk = 1.0},
                               {.angle_random_walk = 1.0, .rate_random_walk = 1.0}};
  int fitted = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed)
    for (const NoiseModel& model : models) {
      auto values = simulated(model, 1.0, 16 + seed % 65, seed);
      if (seed % 3 == 0) values = with_losses(values, 0.1, seed);
      if (seed % 3 == 1) values.insert(values.begin() + 8, 200, std::nan(""));
      try {
        const NoiseFit fit = fit_noise(NoiseBands(values), {});
        for (const FittedTerm& term : fit.terms) {
          if (!term.kept) continue;
          EXPECT_TRUE(std::isfinite(term.squared_sd) && term.squared_sd > 0.0) << seed;
          EXPECT_TRUE(term.degrees_of_freedom > 0.0) << seed;
          EXPECT_TRUE(std::isfinite(term.upper_limit)) << seed;
        }
        ++fitted;
      } catch (const Error& error) {
        EXPECT_EQ(error.kind, Error::Kind::bad_data);
      }
    }
  EXPECT_GE(fitted, 200);
}

TEST(NoiseLikelihood, OfWhiteNoiseAndWalkIsExact) {
  // 33 values have 32 sines, none gathered: the sum over bands is the dense Gaussian likelihood, whatever the terms.
  const auto values = simulated({.angle_random_walk = 1.0, .rate_random_walk = 0.3}, 1.0, 33, 3);
  const NoiseBands bands(values);
  ASSERT_EQ(bands.bands.size(), 32u);
  for (const auto& [white, walk] : {std::pair{1.0, 0.09}, {0.1, 2.0}, {3.0, 1e-4}, {1e-3, 1.0}}) {
    double sum = 0.0;
    for (const auto& band : bands.bands) {
      const double s = white * band.expected[1] + walk * band.expected[3];
      sum += std::log(s) + band.mean_square / s;
    }
    const double dense = dense_likelihood(values, white, walk);
    EXPECT_NEAR(sum, dense, 1e-9 * std::abs(dense)) << white << " " << walk;
  }
}

TEST(NoiseLikelihood, KeepsAllTermsBesideAProcessOfManyBlocks) {
  // A process over several of the last blocks: its covariance with them is summed to its end, so that all variances are
  // above zero and no term that is plainly shown is refused. Errors of 5 sd: 1 in 10^6.
  const double white = 1.0, step = 1.0, sd = 1.0, time = 200.0;
  const auto values = simulated(
      {.quantization_noise = step, .angle_random_walk = white, .markov_sd = sd, .markov_time = time}, 1.0, 360000, 31);
  const NoiseFit fit = fit_noise(NoiseBands(values), {});
  ASSERT_EQ(fit.terms.size(), 5u);
  const std::vector<std::pair<std::size_t, double>> truth{{0, step}, {1, white}, {4, sd}, {5, time}};
  for (const auto& [i, value] : truth) {
    ASSERT_TRUE(i > 4 || fit.shown[i]) << i;
    ASSERT_GT(fit.value_covariance(i, i), 0.0) << i;
    EXPECT_NEAR(fit.value[i], value, 5.0 * std::sqrt(fit.value_covariance(i, i))) << i;
  }
  EXPECT_EQ(fit.model_error, 0.0);
  EXPECT_FALSE(fit.filter.given());
}

TEST(NoiseLikelihood, GivesTheDensityOfFilteredNoiseAtFrequencyZero) {
  // White noise through one pole at a tenth of the rate, averaged over each sample: a process of T_c = 1/(2 pi 0.1).
  const double bandwidth = 0.1, time = 1.0 / (2.0 * pi * bandwidth);
  const auto values = simulated({.markov_sd = 1.0 / std::sqrt(2.0 * time), .markov_time = time}, 1.0, 60000, 32);
  const NoiseFit fit = fit_noise(NoiseBands(values), {});
  ASSERT_TRUE(fit.shown[1] && fit.filter.given());
  EXPECT_NEAR(fit.value[1], 1.0, 5.0 * std::sqrt(fit.value_covariance(1, 1)));
  EXPECT_LT(std::sqrt(fit.value_covariance(1, 1)), 0.02);
  EXPECT_NEAR(fit.filter.bandwidth, bandwidth, 0.05 * bandwidth);
  // None on white noise, whatever the record.
  for (std::uint64_t seed = 40; seed < 50; ++seed)
    EXPECT_FALSE(fit_noise(NoiseBands(simulated({.angle_random_walk = 1.0}, 1.0, 40000, seed)), {}).filter.given());
}

/// Means over each sample of white noise of density one through two poles of damping 0.7: 16 semi-implicit steps.
std::vector<double> two_poles(double bandwidth, std::size_t samples, std::uint64_t seed) {
  constexpr int steps = 16;
  const double w = 2.0 * pi * bandwidth, dt = 1.0 / steps;
  const auto white = simulated({.angle_random_walk = 1.0}, steps, samples * steps, seed);
  std::vector<double> values(samples, 0.0);
  double x = 0.0, v = 0.0;
  for (std::size_t i = 0; i < white.size(); ++i) {
    v += dt * (w * w * (white[i] - x) - 1.4 * w * v);
    x += dt * v;
    values[i / steps] += x / steps;
  }
  return values;
}

TEST(NoiseLikelihood, SteepFiltersAreFoundAndKeepACovariance) {
  // Two poles at 1/20 and 1/50 of the rate take all but 1e-5 and 1e-6 of the power at half the rate. Before, white
  // noise was not found there at all, or its variance was negative.
  for (const double bandwidth : {0.05, 0.02}) {
    const NoiseFit fit = fit_noise(NoiseBands(two_poles(bandwidth, 40000, 61)), {});
    ASSERT_TRUE(fit.filter.given()) << bandwidth;
    EXPECT_FALSE(fit.ramp.kept);
    for (std::size_t i = 0; i < fit.value.size(); ++i) EXPECT_GE(fit.value_covariance(i, i), 0.0) << bandwidth;
    EXPECT_NEAR(fit.value[1], 1.0, 4.0 * std::sqrt(fit.value_covariance(1, 1))) << bandwidth;
    EXPECT_NEAR(fit.filter.bandwidth, bandwidth, 0.1 * bandwidth);
  }
}

TEST(NoiseLikelihood, MissingSamplesBesideAFilterAreExpected) {
  // 5 % missing one by one made N 21 % smaller, with a quantization and a process that are not there.
  auto values = two_poles(0.05, 40000, 62);
  const RandomStream random(63);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (random.uniform(i) < 0.05) values[i] = std::nan("");
  const NoiseFit fit = fit_noise(NoiseBands(values), {});
  EXPECT_EQ(fit.terms.size(), 4u);
  EXPECT_FALSE(fit.shown[0]);
  EXPECT_NEAR(fit.value[1], 1.0, 4.0 * std::sqrt(fit.value_covariance(1, 1)));
  EXPECT_LT(std::sqrt(fit.value_covariance(1, 1)), 0.05);
}

TEST(NoiseLikelihood, TheShapeOfAFilterIsNotKnown) {
  // A pole at 0.3 of the rate is hardly distinguished from running means: of a wrong shape quantization makes up for
  // the rest. 95 % intervals miss more than 3 of 20 with a probability of 1.6 %.
  const double bandwidth = 0.3, time = 1.0 / (2.0 * pi * bandwidth);
  const NoiseModel model{.markov_sd = 1.0 / std::sqrt(2.0 * time), .markov_time = time};
  int quantization = 0, missed = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const NoiseFit fit = fit_noise(NoiseBands(simulated(model, 1.0, 40000, 6400 + seed)), {});
    ASSERT_TRUE(fit.filter.given()) << seed;
    quantization += fit.shown[0] ? 1 : 0;
    missed += std::abs(fit.value[4] - bandwidth) > 1.96 * std::sqrt(fit.value_covariance(4, 4)) ? 1 : 0;
  }
  EXPECT_LE(quantization, 3);
  EXPECT_LE(missed, 3);
}

TEST(NoiseLikelihood, AProcessTooWeakToBeKeptIsInTheIntervalsOfTheOthers) {
  // Flicker takes the power of a process that the record hardly shows: before, B was 4.7 and 3.1 sd off here. These are
  // the two seeds that showed it. Seeds in a row have no limit that follows from 95 %: where the process is not kept,
  // B comes out too high and its intervals miss more often (5 of 39 with other streams, the farthest 3.9 sd).
  const NoiseModel model{.angle_random_walk = 1.0, .bias_instability = 0.08, .markov_sd = 0.12, .markov_time = 19.0};
  for (const std::uint64_t seed : {6601, 6607}) {
    const NoiseFit fit = fit_noise(NoiseBands(simulated(model, 1.0, 40000, seed)), {});
    EXPECT_EQ(fit.terms.size(), power_law_terms.size());
    EXPECT_LT(std::abs(fit.value[2] - 0.08), 3.0 * std::sqrt(fit.value_covariance(2, 2))) << seed;
  }
}

TEST(NoiseLikelihood, LiesAtTheMaximum) {
  const auto values = simulated({.angle_random_walk = 1.0, .rate_random_walk = 0.3}, 1.0, 400, 3);
  NoiseLikelihoodOptions options;
  options.terms = {NoiseTerm::white, NoiseTerm::random_walk};
  options.most_markov = 0;
  const NoiseFit fit = fit_noise(NoiseBands(values), options);
  ASSERT_TRUE(fit.terms[1].kept && fit.terms[3].kept);
  const double white = fit.terms[1].squared, walk = fit.terms[3].squared;
  const auto at = [&](double a, double b) {
    return dense_likelihood(values, white + a * fit.terms[1].squared_sd, walk + b * fit.terms[3].squared_sd);
  };
  // h sd of either coefficient, the other held, raise -2 ln L by h^2/(1 - correlation^2). The curvature of one record
  // scatters about its expectation, which the covariance is made of, by 10 % where about 100 ordinates carry the walk.
  // Frequencies gathered 3 % wide move the maximum by less than a tenth of a sd.
  const double correlation = fit.covariance(1, 3) / (fit.terms[1].squared_sd * fit.terms[3].squared_sd);
  const double expected = 1.0 / (1.0 - correlation * correlation);
  EXPECT_NEAR((at(0.2, 0) - 2.0 * at(0, 0) + at(-0.2, 0)) / 0.08, expected, 0.4 * expected);
  EXPECT_NEAR((at(0, 0.2) - 2.0 * at(0, 0) + at(0, -0.2)) / 0.08, expected, 0.4 * expected);
  EXPECT_NEAR(at(0.05, 0) - at(-0.05, 0), 0.0, 0.02 * expected);
  EXPECT_NEAR(at(0, 0.05) - at(0, -0.05), 0.0, 0.02 * expected);
}

TEST(NoiseLikelihood, MissingSamplesAndMeanDoNotMatter) {
  auto values = simulated({.angle_random_walk = 1.0, .rate_random_walk = 0.01}, 1.0, 60000, 4);
  const NoiseFit whole = fit_noise(NoiseBands(values), {});
  for (double& value : values) value += 1e6;
  const NoiseFit offset = fit_noise(NoiseBands(values), {});
  // 1e6 takes 1e-10 off each sample.
  EXPECT_NEAR(offset.terms[1].squared / whole.terms[1].squared, 1.0, 1e-6);
  EXPECT_NEAR(offset.terms[3].squared / whole.terms[3].squared, 1.0, 1e-6);
  for (std::size_t i = 20000; i < 23000; ++i) values[i] = std::nan("");
  for (std::size_t i = 100; i < 60000; i += 1000) values[i] = std::nan("");
  const NoiseFit gaps = fit_noise(NoiseBands(values), {});
  for (const std::size_t t : {1u, 3u})
    EXPECT_NEAR(gaps.terms[t].squared, whole.terms[t].squared, 3.0 * whole.terms[t].squared_sd) << t;
}

/// Estimate over truth of one coefficient over several records.
struct Scatter {
  double mean = 0.0, sd = 0.0;
  int kept = 0;
};

Scatter scatter(const NoiseModel& model, std::size_t samples, std::size_t term, double truth, int seeds) {
  Scatter result;
  double sum = 0.0, squares = 0.0;
  for (int seed = 0; seed < seeds; ++seed) {
    const NoiseFit fit = fit_noise(NoiseBands(simulated(model, 1.0, samples, 100 + static_cast<unsigned>(seed))), {});
    const FittedTerm& one = fit.terms[term];
    if (!one.kept) continue;
    const double value = std::sqrt(one.squared) * one.root_correction / truth;
    sum += value;
    squares += value * value;
    ++result.kept;
  }
  result.mean = sum / result.kept;
  result.sd = std::sqrt(squares / result.kept - result.mean * result.mean);
  return result;
}

TEST(NoiseLikelihood, ReachesTheBoundForTheWalkWithoutBias) {
  // Information of ln K^2 in white noise and walk of K T/N = 150: T K/(8 N) = 18.75, so sd of K at least 11.5 %. Over
  // 60 records the mean stays within 4 sd and the scatter within 4 of its own, 1/sqrt(120).
  const Scatter k =
      scatter({.angle_random_walk = 1.0, .rate_random_walk = 150.0 / 6000.0}, 6000, 3, 150.0 / 6000.0, 60);
  EXPECT_GE(k.kept, 58);
  EXPECT_NEAR(k.mean, 1.0, 4.0 * 0.115 / std::sqrt(60.0));
  EXPECT_LT(k.sd, 0.115 * (1.0 + 4.0 / std::sqrt(120.0)));
}

TEST(NoiseLikelihood, FindsAGaussMarkovProcessAndOnlyOneThatIsThere) {
  const NoiseModel model{.angle_random_walk = 1.0, .markov_sd = 1.0, .markov_time = 100.0};
  const NoiseFit fit = fit_noise(NoiseBands(simulated(model, 1.0, 40000, 5)), {});
  ASSERT_EQ(fit.terms.size(), 5u);
  const double sd = std::sqrt(fit.covariance(5, 5));
  EXPECT_NEAR(fit.terms[4].unit.markov_time, 100.0, 4.0 * sd);
  EXPECT_NEAR(fit.terms[4].squared, 1.0, 4.0 * fit.terms[4].squared_sd);
  EXPECT_LT(sd, 20.0);
  EXPECT_EQ(fit_noise(NoiseBands(simulated({.angle_random_walk = 1.0}, 1.0, 40000, 5)), {}).terms.size(), 4u);
}

TEST(NoiseLikelihood, AProcessThatIsNotSeenBesideAllPowerLawsIsNotTakenForFlicker) {
  // Too short to show a process beside flicker and walk, which imitate it: 15 of these 20 records showed a bias
  // instability. An interval of 95 % that is right misses more than 3 of 20 with a probability of 1.6 %, more than 4
  // with 0.3 %.
  const double time = 35.0;
  int false_flicker = 0, held = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const NoiseModel model{.angle_random_walk = 1.0, .markov_sd = 0.3, .markov_time = time};
    const NoiseFit fit = fit_noise(NoiseBands(simulated(model, 1.0, 5000, 4100 + seed)), {});
    false_flicker += fit.shown[2] ? 1 : 0;
    const double sd = std::sqrt(fit.value_covariance(1, 1));
    held += std::abs(fit.value[1] - 1.0) < 1.96 * sd ? 1 : 0;
  }
  EXPECT_LE(false_flicker, 3);
  EXPECT_GE(held, 16);
}

TEST(NoiseLikelihood, AllSetsAreComparedUnderOneErrorOfTheModel) {
  // A sine that no term follows makes the error of the ranges large; a term more can only be likelier, to the rounding
  // of the search.
  auto values = simulated({.angle_random_walk = 1.0}, 1.0, 50000, 4200);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] += 0.3 * std::sin(0.7 * static_cast<double>(i));
  const NoiseFit fit = fit_noise(NoiseBands(values), {});
  ASSERT_GT(fit.model_error, 0.0);
  for (std::size_t t = 0; t < 4; ++t) EXPECT_GT(fit.terms[t].improvement, -0.01) << t;
}

TEST(NoiseLikelihood, DistinguishesTwoProcesses) {
  const NoiseModel model{.angle_random_walk = 1.0, .markov_sd = 1.0, .markov_time = 20.0};
  auto values = simulated(model, 1.0, 200000, 6);
  add_noise({.markov_sd = 2.0, .markov_time = 2000.0}, 1.0, RandomStream(7), values);
  const NoiseFit fit = fit_noise(NoiseBands(values), {});
  ASSERT_EQ(fit.terms.size(), 6u);
  const std::size_t fast = fit.terms[4].unit.markov_time < fit.terms[5].unit.markov_time ? 4 : 5, slow = 9 - fast;
  const auto sd = [&](std::size_t t) { return std::sqrt(fit.covariance(t + 2, t + 2)); };
  EXPECT_NEAR(fit.terms[fast].unit.markov_time, 20.0, 4.0 * sd(fast));
  EXPECT_NEAR(fit.terms[slow].unit.markov_time, 2000.0, 4.0 * sd(slow));
}

/// Records of `model` in which something happened.
template <typename Happened>
int times(const NoiseModel& model, std::size_t samples, int records, Happened happened) {
  int sum = 0;
  for (int i = 0; i < records; ++i)
    sum += happened(fit_noise(NoiseBands(simulated(model, 1.0, samples, 9001 + static_cast<unsigned>(i))), {})) ? 1 : 0;
  return sum;
}

TEST(NoiseLikelihood, QuantizationAloneIsNotMistakenForWhiteNoise) {
  // The two ends of quantization are shared by all slow sines, which once gave a false term in 18 % of records. At the
  // 1 % of each of the three other terms 400 records have 12 +- 3.5 at most: 4 sigma are 26.
  const int false_terms = times({.quantization_noise = 1.0}, 2000, 400, [](const NoiseFit& fit) {
    return fit.terms[1].kept || fit.terms[2].kept || fit.terms[3].kept;
  });
  EXPECT_LE(false_terms, 26);
}

TEST(NoiseLikelihoodCoverage, FalseTermsAreAsRareAsAsked) {
  // Beside white noise, and beside a walk: 400 records, three or two terms of 1 % at most, 4 sigma.
  EXPECT_LE(times({.angle_random_walk = 1.0}, 1000, 400,
                  [](const NoiseFit& fit) { return fit.terms[0].kept || fit.terms[2].kept || fit.terms[3].kept; }),
            26);
  EXPECT_LE(times({.angle_random_walk = 1.0, .rate_random_walk = 0.15}, 1000, 400,
                  [](const NoiseFit& fit) { return fit.terms[0].kept || fit.terms[2].kept; }),
            20);
}

TEST(NoiseLikelihood, DistinguishesARampInWhiteNoiseFromAWalk) {
  // 2e-4 a sample over 4000 is 14.6 sd of the slope in white noise alone. A walk explains it nearly as well, and once
  // took it in 97 % of records. Found in two of three (200 records: 67 %); 60 records have 40 +- 3.7.
  const NoiseModel ramp{.angle_random_walk = 1.0, .rate_ramp = 2e-4};
  EXPECT_GE(times(ramp, 4000, 60, [](const NoiseFit& fit) { return fit.ramp.kept && fit.ramp.slope > 0.0; }), 25);
  EXPECT_EQ(
      times(ramp, 4000, 60,
            [](const NoiseFit& fit) { return fit.ramp.kept && std::abs(fit.ramp.slope - 2e-4) > 4.0 * fit.ramp.sd; }),
      0);
  // None in a walk of every strength: at 0.5 % 300 records have 1.5 +- 1.2.
  for (const double walk : {0.005, 0.02, 0.05})
    EXPECT_LE(times({.angle_random_walk = 1.0, .rate_random_walk = walk}, 1000, 300,
                    [](const NoiseFit& fit) { return fit.ramp.kept; }),
              6)
        << walk;
}

TEST(NoiseLikelihoodCoverage, IntervalsOfAProcessHold) {
  // 80 correlation times: the time is known to 20 %, and its sd is smaller where the estimate is low. 200 records, of
  // which 95 % are 190 +- 3.1; the interval is made for a normal logarithm, which it is not quite.
  int found = 0, held = 0;
  for (unsigned seed = 9001; seed < 9201; ++seed) {
    const NoiseModel model{.angle_random_walk = 1.0, .markov_sd = 1.0, .markov_time = 50.0};
    const NoiseFit fit = fit_noise(NoiseBands(simulated(model, 1.0, 4000, seed)), {});
    if (fit.terms.size() != 5) continue;
    ++found;
    const double factor = student_quantile(0.975, fit.terms[4].degrees_of_freedom);
    held += std::abs(fit.terms[4].unit.markov_time - 50.0) < factor * std::sqrt(fit.covariance(5, 5)) ? 1 : 0;
  }
  EXPECT_GE(found, 180);
  EXPECT_GE(held, 0.95 * found - 4.0 * std::sqrt(0.95 * 0.05 * found));
}

// Two pieces with nothing between them: no two slow values are neighbours, and nothing shows a ramp.
TEST(NoiseLikelihood, TwoShortPiecesFarApartShowTheirNoise) {
  std::vector<double> values(4'000'000, NAN);
  const auto piece = simulated({.angle_random_walk = 1.0}, 1.0, 4000, 5);
  std::ranges::copy(piece, values.begin());
  std::ranges::copy(piece, values.end() - 4000);
  const auto fit = fit_noise(NoiseBands(values), {});
  EXPECT_FALSE(fit.ramp.kept);
  ASSERT_TRUE(fit.terms[1].kept);
  EXPECT_NEAR(fit.terms[1].squared, 1.0, 0.1);  // 4000 values: 0.022 each, 4 sigma
}

TEST(NoiseLikelihood, RefusesASampleFarBeyondTheOthers) {
  auto values = simulated({.angle_random_walk = 1.0}, 1.0, 2000, 5);
  values[700] = 1e200;
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "differ too much in size"},
                      [&] { fit_noise(NoiseBands(values), {}); }));
}

TEST(NoiseLikelihood, RefusesWhatDoesNotChange) {
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "nothing that changes"},
                      [&] { fit_noise(NoiseBands(std::vector<double>(100, 1.0)), {}); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "no two samples are neighbours"},
                      [&] { NoiseBands(std::vector<double>(100, std::nan(""))); }));
}

// The bank of processes that simulates flicker must not show: neither in B nor as terms that are not there.
TEST(NoiseLikelihood, SimulatedFlickerIsFlicker) {
  constexpr int records = 24;
  double sum = 0.0, variance = 0.0;
  int alone = 0;
  for (int seed = 1; seed <= records; ++seed) {
    const auto fit = fit_noise(NoiseBands(simulated({.bias_instability = 1.0}, 1.0, 1 << 18, 7000 + seed)), {});
    const auto kept = std::count_if(fit.terms.begin(), fit.terms.end(), [](const auto& term) { return term.kept; });
    alone += fit.terms[2].kept && kept == 1;
    sum += std::sqrt(fit.terms[2].squared) - 1.0;
    variance += fit.terms[2].squared_sd * fit.terms[2].squared_sd / 4.0;
  }
  EXPECT_LT(std::abs(sum), 4.0 * std::sqrt(variance));
  EXPECT_GE(alone, 18);  // 1 % of chance for each of a few terms more: 5 % of records; 5 of 24 have a chance of 0.6 %
}

}  // namespace
}  // namespace tumble
