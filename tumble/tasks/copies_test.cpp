#include "tumble/tasks/copies.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tumble/math/random.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

Recording recording_of(std::size_t samples, const std::function<double(std::size_t)>& value,
                       const std::string& file = "a.csv") {
  Channel channel{"N", QuantityKind::count, Unit::parse("pulse"), {0.0, 1.0, nullptr}, {}};
  for (std::size_t i = 0; i < samples; ++i) channel.values.push_back(value(i));
  Recording recording{.channels = {channel}};
  recording.origin = {file, [] { return std::string("one checksum"); }};
  return recording;
}

// One value throughout, and 2 of 3 windows with one pulse more, which is what a fixed part of a pulse gives: nothing is
// left to chance but the first two values.
TEST(Copies, QuietCountsAreEqualByChance) {
  EXPECT_EQ(log_chance_of_equal(recording_of(60, [](std::size_t) { return 16.0; })), 0.0);
  EXPECT_GT(log_chance_of_equal(recording_of(60, [](std::size_t i) { return i % 3 == 0 ? 16.0 : 17.0; })), -3.0);
}

// Even odds of two values: ln 2 a window, 100 of them; the counted odds scatter by 10 %.
TEST(Copies, NoiseOfOnePulseIsAFactorOfTwoForEachWindow) {
  const RandomStream random(3);
  const auto coin = recording_of(100, [&](std::size_t i) { return random.normal(i) > 0.0 ? 1.0 : 0.0; });
  EXPECT_NEAR(log_chance_of_equal(coin), -100.0 * std::log(2.0), 15.0);
}

TEST(Copies, ACopyOfNoiseIsRefusedAndEqualQuietCountsAreNot) {
  const RandomStream random(4);
  const auto noise = [&](std::size_t i) { return random.normal(i); };
  std::vector<Recording> copies{recording_of(40, noise, "a.csv"), recording_of(40, noise, "b.csv")};
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"b.csv", "a.csv"}}, [&] { look_at_copies(copies); }));
  const auto quiet = [](std::size_t) { return 3.0; };
  std::vector<Recording> equal{recording_of(40, quiet, "a.csv"), recording_of(40, quiet, "b.csv")};
  look_at_copies(equal);
  ASSERT_EQ(equal[1].findings.size(), 1u);
  EXPECT_EQ(equal[1].findings[0].code, "equal_to_another_recording");
  EXPECT_EQ(equal[1].findings[0].severity, Finding::Severity::info);
  std::vector<Recording> twice{recording_of(40, quiet, "a.csv"), recording_of(40, quiet, "a.csv")};
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"a.csv", "a.csv"}}, [&] { look_at_copies(twice); }));
}

}  // namespace
}  // namespace tumble
