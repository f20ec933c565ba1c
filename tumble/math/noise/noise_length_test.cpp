#include "tumble/math/noise/noise_length.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tumble/math/noise_model.hpp"

namespace tumble {
namespace {

std::vector<double> simulated(const NoiseModel& model, std::size_t samples, std::uint64_t seed) {
  std::vector<double> values(samples, 0.0);
  add_noise(model, 1.0, RandomStream(seed), values);
  return values;
}

NoiseLikelihoodOptions only(std::vector<NoiseTerm> terms) {
  NoiseLikelihoodOptions options;
  options.terms = std::move(terms);
  options.most_markov = 0;
  return options;
}

constexpr std::size_t short_record = 2000;
const NoiseModel walk{.angle_random_walk = 1.0, .rate_random_walk = 0.05};
const NoiseModel flicker{.angle_random_walk = 1.0, .bias_instability = 0.3};

/// A short record and its fit, the coefficients set to the truth: what is asked is the length, not the guess.
struct Known {
  Known(const NoiseModel& model, std::size_t term, double squared)
      : bands(simulated(model, short_record, 1)),
        fit(fit_noise(bands, only({NoiseTerm::white, power_law_terms[term]}))) {
    EXPECT_TRUE(fit.terms[term].kept && fit.terms[1].kept);
    fit.terms[1].squared = 1.0;
    fit.terms[term].squared = squared;
  }
  NoiseBands bands;
  NoiseFit fit;
};

double relative_scatter(const NoiseModel& model, std::size_t samples, std::size_t term, double truth, int records) {
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < records; ++i) {
    const NoiseFit fit = fit_noise(NoiseBands(simulated(model, samples, 5001 + static_cast<unsigned>(i))),
                                   only({NoiseTerm::white, power_law_terms[term]}));
    const double value = std::sqrt(fit.terms[term].squared) / truth;
    sum += value;
    squares += value * value;
  }
  const double mean = sum / records;
  return std::sqrt((squares - records * mean * mean) / (records - 1));
}

TEST(NoiseLength, IsThatOfTheBoundForAWalk) {
  // sd of K at least sqrt(2 N/(K T)) of it: 8 % take T = 2/(0.05 0.08^2) = 6250. The bound leaves out N, and that there
  // is no sine below the first: 2 % of the length.
  const Known known(walk, 3, 0.05 * 0.05);
  const RecordLength length(known.bands, known.fit);
  const double times = length.times_for(3, 2.0 * 0.08 * 0.05 * 0.05);
  EXPECT_NEAR(times * short_record / 6250.0, 1.0, 0.05);
  EXPECT_NEAR(length.sd_of(3, times) / (2.0 * 0.08 * 0.05 * 0.05), 1.0, 0.01);
}

TEST(NoiseLength, GivesTheScatterThatWasWanted) {
  // Records of the length advised scatter as wanted: 60 records show a sd to 1/sqrt(2 59) of itself; four of these.
  const double four_sd = 4.0 / std::sqrt(2.0 * 59.0);
  const Known k(walk, 3, 0.05 * 0.05), b(flicker, 2, 0.09);
  const double of_k = RecordLength(k.bands, k.fit).times_for(3, 2.0 * 0.08 * 0.05 * 0.05),
               of_b = RecordLength(b.bands, b.fit).times_for(2, 2.0 * 0.10 * 0.09);
  ASSERT_LT(of_k * short_record, 20000.0);
  ASSERT_LT(of_b * short_record, 20000.0);
  EXPECT_NEAR(relative_scatter(walk, static_cast<std::size_t>(of_k * short_record), 3, 0.05, 60) / 0.08, 1.0, four_sd);
  EXPECT_NEAR(relative_scatter(flicker, static_cast<std::size_t>(of_b * short_record), 2, 0.3, 60) / 0.10, 1.0,
              four_sd);
}

TEST(NoiseLength, AtItsOwnLengthRepeatsTheFit) {
  const NoiseBands bands(simulated(walk, short_record, 2));
  const NoiseFit fit = fit_noise(bands, only({NoiseTerm::white, NoiseTerm::random_walk}));
  const RecordLength length(bands, fit);
  // White noise and walk have no covariance between contrasts: the same information.
  EXPECT_NEAR(length.sd_of(1, 1.0) / fit.terms[1].squared_sd, 1.0, 0.01);
  EXPECT_NEAR(length.sd_of(3, 1.0) / fit.terms[3].squared_sd, 1.0, 0.01);
  // N is known by every sample: the sd falls as 1/sqrt(T).
  EXPECT_NEAR(length.sd_of(1, 100.0) / length.sd_of(1, 1.0), 0.1, 0.005);
}

TEST(NoiseLength, OfATermThatIsNotThereAndOfWhatNoRecordGives) {
  const NoiseBands bands(simulated({.angle_random_walk = 1.0}, short_record, 3));
  const NoiseFit fit = fit_noise(bands, {});
  ASSERT_FALSE(fit.terms[3].kept);
  const RecordLength length(bands, fit);
  // In white noise alone the sd of c_K is that of the lowest sines, of power N^2 (2 pi f)^2: as T^-2.
  EXPECT_NEAR(length.sd_of(3, 16.0) / length.sd_of(3, 4.0), 1.0 / 16.0, 0.1 / 16.0);
  EXPECT_TRUE(std::isinf(length.times_for(1, 0.0)));
}

}  // namespace
}  // namespace tumble
