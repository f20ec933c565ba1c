#include "tumble/math/stability/streaming_allan.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "tumble/math/stability/allan_edf.hpp"
#include "tumble/math/stability/allan_phase.hpp"
#include "tumble/math/state.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace {

using tumble::StreamingAllan;

constexpr std::size_t longest = 200000;

/// White noise and a random walk beside a large mean.
std::vector<double> record(std::size_t samples) {
  std::mt19937_64 engine(17);
  std::normal_distribution<double> normal;
  std::vector<double> rate(samples);
  double walk = 1e4;
  for (double& value : rate) {
    const double white = normal(engine);
    value = white + (walk += 0.01 * normal(engine));
  }
  return rate;
}

std::vector<double> with_gaps(std::vector<double> rate) {
  for (const std::size_t n : {0, 5000, 5001, 65535, 65536, 131072, 200100})
    rate[n] = std::numeric_limits<double>::quiet_NaN();
  return rate;
}

/// As it is defined: terms at multiples of `step` of the record that no missing sample touches.
void expect_defined(const std::vector<double>& rate, const tumble::DeviationPoint& point) {
  std::vector<long double> x(rate.size() + 1, 0.0L);
  std::vector<std::size_t> bad(rate.size() + 1, 0);
  for (std::size_t n = 0; n < rate.size(); ++n) {
    x[n + 1] = x[n] + (std::isnan(rate[n]) ? 0.0L : static_cast<long double>(rate[n]));
    bad[n + 1] = bad[n] + std::isnan(rate[n]);
  }
  std::size_t step = 1, count = 0;
  while (point.factor > StreamingAllan::exact_to * step) step *= StreamingAllan::decimation;
  long double sum = 0.0L;
  for (std::size_t n = 0; n + 2 * point.factor < x.size(); n += step) {
    if (bad[n + 2 * point.factor] != bad[n]) continue;
    const long double z = (x[n + 2 * point.factor] - x[n + point.factor]) - (x[n + point.factor] - x[n]);
    sum += z * z;
    ++count;
  }
  const double expected = static_cast<double>(std::sqrt(sum / (2.0L * count)) / point.factor);
  EXPECT_EQ(point.count, count) << point.factor;
  // The sum of 16 increments near 1e4 rounds at 1e-11 beside white noise of 4: 1e-9 is far away.
  EXPECT_NEAR(point.deviation / expected, 1.0, 1e-10) << point.factor;
}

std::vector<tumble::DeviationPoint> streamed(const std::vector<double>& rate) {
  StreamingAllan allan(longest, 10.0);
  allan.push(rate);
  return allan.points(100.0, 0.95);
}

}  // namespace

TEST(StreamingAllan, SumsTheTermsItIsDefinedBy) {
  for (const auto& rate : {record(300000), with_gaps(record(300000)), record(7)}) {
    const auto points = streamed(rate);
    ASSERT_GE(points.size(), rate.size() > 10 ? 40u : 3u);
    for (const auto& point : points) {
      expect_defined(rate, point);
      EXPECT_EQ(point.tau, static_cast<double>(point.factor) / 100.0);
    }
  }
}

TEST(StreamingAllan, DoesNotDependOnHowTheRecordIsCut) {
  const auto rate = with_gaps(record(300000));
  const auto whole = streamed(rate);
  StreamingAllan pieces(longest, 10.0);
  for (std::size_t start = 0, length = 1; start < rate.size(); start += length, length = (7 * length + 3) % 9973) {
    pieces.push(std::span(rate).subspan(start, std::min(length, rate.size() - start)));
  }
  const auto cut = pieces.points(100.0, 0.95);
  ASSERT_EQ(cut.size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) EXPECT_EQ(cut[i].deviation, whole[i].deviation);
}

TEST(StreamingAllan, PartsJoinToTheWhole) {
  for (const auto& rate : {record(300000), with_gaps(record(300000))}) {
    const auto whole = streamed(rate);
    // Parts that begin anywhere: shorter than a step of the second stage, of the last stage, and longer than the
    // longest factor of each stage; joined from the left and from the right, after a way through bytes.
    const std::size_t lengths[] = {1, 3, 40000, 7, 255, 1, 16, 300, 5001, 2, 256, 60000, 13, 70001};
    std::vector<StreamingAllan> parts;
    for (std::size_t start = 0, k = 0; start < rate.size(); ++k) {
      const std::size_t length = std::min(lengths[k % std::size(lengths)], rate.size() - start);
      StreamingAllan part(longest, 10.0, start);
      part.push(std::span(rate).subspan(start, length));
      tumble::StateWriter out;
      out(part);
      const std::string bytes = out.take();
      tumble::StateReader in(bytes);
      in(parts.emplace_back());
      EXPECT_TRUE(in.ended());
      start += length;
    }
    ASSERT_GT(parts.size(), 20u);
    auto left = parts.front(), right = parts.back();
    for (std::size_t k = 1; k < parts.size(); ++k) left.append(parts[k]);
    for (std::size_t k = parts.size() - 1; k-- > 0;) {
      auto joined = parts[k];
      joined.append(right);
      right = joined;
    }
    for (const auto& all : {left.points(100.0, 0.95), right.points(100.0, 0.95)}) {
      ASSERT_EQ(all.size(), whole.size());
      EXPECT_EQ(left.samples(), rate.size());
      for (std::size_t i = 0; i < whole.size(); ++i) {
        EXPECT_EQ(all[i].factor, whole[i].factor);
        EXPECT_EQ(all[i].count, whole[i].count) << whole[i].factor;
        EXPECT_NEAR(all[i].deviation / whole[i].deviation, 1.0, 1e-10) << whole[i].factor;
      }
    }
  }
}

TEST(StreamingAllan, GoesOnAfterPartsAreJoined) {
  const auto rate = record(300000);
  const auto whole = streamed(rate);
  StreamingAllan first(longest, 10.0), second(longest, 10.0, 2567);
  first.push(std::span(rate).first(2567));
  second.push(std::span(rate).subspan(2567, 100001));
  first.append(second);
  first.push(std::span(rate).subspan(102568));
  const auto all = first.points(100.0, 0.95);
  ASSERT_EQ(all.size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    EXPECT_EQ(all[i].count, whole[i].count);
    EXPECT_NEAR(all[i].deviation / whole[i].deviation, 1.0, 1e-10);
  }
}

TEST(StreamingAllan, LosesNoDegreesOfFreedomByItsSteps) {
  // A record of 20 tau with 64 terms in each tau, and with 16 times as many.
  for (const int alpha : {0, -1, -2}) {
    const double few = tumble::phase_difference_edf(alpha, {}, 64, 1152);
    const double many = tumble::phase_difference_edf(alpha, {}, 1024, 18432);
    EXPECT_NEAR(few / many, 1.0, 2e-3) << alpha;
  }
}

TEST(StreamingAllan, SaysWhatDoesNotFit) {
  EXPECT_TRUE(tumble::refuses(tumble::Error::Kind::bad_input, tumble::Asked{.pattern = "points per decade"},
                              [&] { StreamingAllan(longest, -1.0); }));
  StreamingAllan first(longest, 10.0), gap(longest, 10.0, 512), other(longest, 5.0, 256);
  first.push(record(256));
  EXPECT_TRUE(tumble::refuses(tumble::Error::Kind::bad_input, tumble::Asked{.values = {"512", "256"}},
                              [&] { first.append(gap); }));
  EXPECT_TRUE(tumble::refuses(tumble::Error::Kind::bad_input, tumble::Asked{.values = {"256", "256"}},
                              [&] { first.append(other); }));
  EXPECT_TRUE(tumble::refuses(tumble::Error::Kind::bad_data, tumble::Asked{.values = {"256"}, .pattern = "infinite"},
                              [&] { first.push(std::vector<double>{std::numeric_limits<double>::infinity()}); }));
}
