#include "tumble/math/regression/added_terms.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/random.hpp"

namespace tumble {
namespace {

constexpr std::size_t segments_made = 16, rows_made = 12;

/// Segments of a slow line and a level of their own, with white noise of sd 1 a row; two terms fitted: 1 and the position.
struct MadeSegments {
  MixedData data;
  Matrix candidates;  ///< a wave within the segments, and a square of the position
};

MadeSegments made_segments(std::uint64_t seed, double wave, double square_of_position, double drift) {
  MadeSegments out;
  const std::size_t n = segments_made * rows_made;
  out.data.design = Matrix(n, 2);
  out.candidates = Matrix(n, 2);
  const RandomStream noise(seed);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t g = i / rows_made;
    const double position = static_cast<double>(g % 8) - 3.5, course = std::sin(2.1 * static_cast<double>(i));
    out.data.design(i, 0) = 1.0;
    out.data.design(i, 1) = position;
    out.candidates(i, 0) = course;
    out.candidates(i, 1) = position * position;
    out.data.observations.push_back(3.0 - 2.0 * position + wave * course + square_of_position * position * position +
                                    drift * noise.split("drift").normal(g) + noise.normal(i));
    out.data.weights.push_back(1.0);
    out.data.segment.push_back(g);
  }
  Matrix own(segments_made, segments_made);
  for (std::size_t g = 0; g < segments_made; ++g) own(g, g) = 1.0;
  out.data.slow = {{"drift", own}};
  return out;
}

struct TermTests {
  std::vector<AddedTerm> within, between;
};

TermTests term_tests_of(const MadeSegments& one) {
  const MixedFit fit = fit_mixed_model(one.data);
  std::vector<double> left;
  for (std::size_t i = 0; i < fit.fitted.size(); ++i) left.push_back(one.data.observations[i] - fit.fitted[i]);
  return {added_within_segments(one.data, left, one.candidates, fit.white_variance),
          added_between_segments(segment_means(one.data, left, one.candidates, fit.white_variance))};
}

TEST(AddedTerms, ATermWithinTheSegmentsIsFoundThere) {
  const TermTests tests = term_tests_of(made_segments(1, 0.8, 0.0, 0.0));
  EXPECT_LT(tests.within[0].probability, 1e-8);
  EXPECT_NEAR(tests.within[0].coefficient, 0.8, 0.3);
  EXPECT_EQ(tests.within[1].error_freedom, 0.0);  // the position does not change within a segment
}

TEST(AddedTerms, ATermBetweenTheSegmentsIsFoundAlthoughItLooksLikeDrift) {
  const TermTests tests = term_tests_of(made_segments(2, 0.0, 1.0, 0.3));
  EXPECT_LT(tests.between[1].probability, 1e-8);
  EXPECT_NEAR(tests.between[1].coefficient, 1.0, 0.15);
}

TEST(AddedTerms, NoiseAndDriftAreNoTerm) {
  constexpr int seeds = 400;
  int within = 0, between = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    const TermTests tests =
        term_tests_of(made_segments(static_cast<std::uint64_t>(seed) + 10, 0.0, 0.0, seed % 2 == 0 ? 0.0 : 2.0));
    within += tests.within[0].probability < 0.05;
    between += tests.between[1].probability < 0.05;
  }
  // 20 expected with an sd of 4.4; 4 sd. The size of the drift is found for the candidate, which gains a little by it.
  EXPECT_NEAR(within, 20, 18);
  EXPECT_NEAR(between, 20, 18);
}

TEST(AddedTerms, AKnownEffectExplainsWhatItMayDo) {
  MadeSegments one = made_segments(3, 5.0, 0.0, 0.0);
  one.data.effects = {{"known", std::vector<double>(one.data.weights.size(), 0.0), false}};
  for (std::size_t i = 0; i < one.data.weights.size(); ++i)
    one.data.effects[0].column[i] = 5.0 * one.candidates(i, 0) + 0.01 * std::cos(0.3 * static_cast<double>(i));
  EXPECT_GT(term_tests_of(one).within[0].probability, 1e-3);
}

}  // namespace
}  // namespace tumble
