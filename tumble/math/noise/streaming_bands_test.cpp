#include "tumble/math/noise/streaming_bands.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <string>

#include "tumble/math/noise_model.hpp"
#include "tumble/math/state.hpp"
#include "tumble/units/testing/asserts.hpp"

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

/// Parts that begin anywhere, joined from the left or from the right after a way through bytes.
StreamingNoiseBands joined(const std::vector<double>& values, bool from_left) {
  const std::size_t lengths[] = {1, 400'003, 3, 17, 70'000, 5, 1'000'001, 16, 31, 256, 4097, 100'000, 15};
  std::deque<StreamingNoiseBands> parts;
  for (std::size_t start = 0, k = 0; start < values.size(); ++k) {
    const std::size_t length = std::min(lengths[k % std::size(lengths)], values.size() - start);
    StreamingNoiseBands part(start, values.size());
    for (std::size_t first = 0; first < length; first += 65'536)
      part.push(std::span(values).subspan(start + first, std::min<std::size_t>(65'536, length - first)));
    StateWriter out;
    out(part);
    const std::string bytes = out.take();
    StateReader in(bytes);
    in(parts.emplace_back());
    EXPECT_TRUE(in.ended());
    start += length;
  }
  while (from_left && parts.size() > 1) {
    parts[0].append(parts[1]);
    parts.erase(parts.begin() + 1);
  }
  while (parts.size() > 1) {
    parts[parts.size() - 2].append(parts.back());
    parts.pop_back();
  }
  return parts.front();
}

void expect_same_groups(const NoiseBands& a, const NoiseBands& b) {
  ASSERT_EQ(a.scatter.size(), b.scatter.size());
  for (std::size_t s = 0; s < a.scatter.size(); ++s) {
    const auto &mine = a.scatter[s]->groups, &other = b.scatter[s]->groups;
    ASSERT_EQ(mine.size(), other.size()) << s;
    for (std::size_t i = 0; i < mine.size(); ++i) {
      EXPECT_NEAR(mine[i].contrasts, other[i].contrasts, 1e-9) << s << " " << i;
      EXPECT_NEAR(mine[i].square[3], other[i].square[3], 1e-12 * other[i].square[3]) << s << " " << i;
    }
  }
}

TEST(StreamingBands, PartsJoinToTheWhole) {
  for (const std::size_t samples : {40u, 20'000u, 131'072u, 2'097'151u, 2'097'152u, 4'500'011u}) {
    auto values = record(samples);
    for (std::size_t i = samples / 3; i < samples / 3 + samples / 100; ++i) values[i] = std::nan("");
    const NoiseBands whole = streamed(values, 65'536);
    for (const bool from_left : {true, false}) {
      const NoiseBands parts = joined(values, from_left).bands();
      expect_same(whole, parts);
      expect_same_groups(whole, parts);
      ASSERT_EQ(whole.part_count.size(), parts.part_count.size());
      for (std::size_t i = 0; i < whole.part_count.size(); ++i)
        EXPECT_NEAR(whole.part_mean_square[i], parts.part_mean_square[i], 1e-12 * whole.part_mean_square[i]);
    }
  }
}

TEST(StreamingBands, SayWhichPartsDoNotFollow) {
  StreamingNoiseBands first(0, 1000), gap(20, 1000), other(10, 2000);
  first.push(record(10));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"20", "10"}}, [&] { first.append(gap); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"10", "10"}}, [&] { first.append(other); }));
  EXPECT_TRUE(
      refuses(Error::Kind::bad_input, Asked{.values = {"0", "0"}}, [&] { StreamingNoiseBands().append(first); }));
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
