#include "tumble/math/noise/streaming_bands.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/noise_model.hpp"

namespace tumble {
namespace {

/// White noise and a random walk about a large mean.
std::vector<double> record(std::size_t samples) {
  std::vector<double> values(samples, 1.5);
  add_noise({.angle_random_walk = 0.01, .rate_random_walk = 1e-4}, 100.0, RandomStream(11), values);
  return values;
}

NoiseBands streamed(const std::vector<double>& values, std::size_t piece) {
  StreamingNoiseBands bands;
  for (std::size_t first = 0; first < values.size(); first += piece)
    bands.push(std::span(values).subspan(first, std::min(piece, values.size() - first)));
  return bands.bands();
}

/// Sums of up to 10^6 squares in another order: 1e-12 of them. Contrasts of ramps are signed sums, 1e-9 of their size.
void expect_same(const NoiseBands& a, const NoiseBands& b) {
  EXPECT_EQ(a.samples, b.samples);
  ASSERT_EQ(a.bands.size(), b.bands.size());
  for (std::size_t i = 0; i < a.bands.size(); ++i) {
    EXPECT_EQ(a.bands[i].frequency, b.bands[i].frequency);
    EXPECT_NEAR(a.bands[i].count, b.bands[i].count, 1e-12 * a.bands[i].count);
    EXPECT_NEAR(a.bands[i].mean_square, b.bands[i].mean_square, 1e-12 * a.bands[i].mean_square);
    const double ramp = std::sqrt(a.bands[i].ramp_square * a.bands[i].mean_square);
    EXPECT_NEAR(a.bands[i].with_ramp, b.bands[i].with_ramp, 1e-9 * ramp);
  }
  ASSERT_EQ(a.ordinates.size(), b.ordinates.size());
  for (std::size_t i = 0; i < a.ordinates.size(); ++i)
    EXPECT_NEAR(a.ordinates[i].square, b.ordinates[i].square, 1e-12 * a.ordinates[i].square);
}

TEST(StreamingBands, AreThoseOfTheWholeRecord) {
  // Below and above the lengths at which a first and a second scale of the widest blocks begin.
  for (const std::size_t samples : {100u, 20'000u, 131'071u, 131'072u, 131'081u, 2'097'151u, 2'097'152u, 2'500'011u}) {
    const auto values = record(samples);
    const NoiseBands whole(values);
    expect_same(whole, streamed(values, 70'001));
  }
}

TEST(StreamingBands, DoNotDependOnThePiecesAndTakeGaps) {
  auto values = record(300'000);
  for (std::size_t i = 150'003; i < 150'100; ++i) values[i] = std::nan("");
  const NoiseBands whole(values);
  for (const std::size_t piece : {1u, 17u, 65'536u, 300'000u}) expect_same(whole, streamed(values, piece));
}

TEST(StreamingBands, TakeSingleMissingSamplesAsTheWholeDoes) {
  for (const std::size_t samples : {5'000u, 100'000u, 300'000u}) {
    auto values = record(samples);
    for (std::size_t i = 0; i < samples; ++i)
      if (i * i % 23 == 3) values[i] = std::nan("");
    const NoiseBands whole(values), pieces = streamed(values, 1'001);
    expect_same(whole, pieces);
    for (std::size_t i = 0; i < whole.bands.size(); ++i)
      for (std::size_t t = 0; t < power_law_terms.size(); ++t)
        EXPECT_NEAR(whole.bands[i].expected[t], pieces.bands[i].expected[t], 1e-12 * whole.bands[i].expected[t]);
  }
}

TEST(StreamingBands, PartsAreEqualToAFiveHundredthOfTheRecord) {
  auto values = record(3'000'000);
  for (std::size_t i = 0; i < 3'000'000 / 16; ++i) values[i] = 1.5 + 2.0 * (values[i] - 1.5);
  const NoiseBands whole(values), pieces = streamed(values, 65'536);
  ASSERT_EQ(pieces.part_count.size(), NoiseBands::parts);
  for (std::size_t i = 0; i < NoiseBands::parts; ++i) {
    EXPECT_NEAR(pieces.part_count[i], whole.part_count[i], 3'000'000 / 256.0);
    // A 500th of the record is a 30th of a part: at most so much of the fourfold power at its edge.
    EXPECT_NEAR(pieces.part_mean_square[i] / whole.part_mean_square[i], 1.0, 0.13);
  }
}

}  // namespace
}  // namespace tumble
