#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tumble/models/model.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/unit.hpp"

namespace tumble::ring_laser_gyro_test {
namespace {

const Model& model() { return find_model("ring_laser_gyro"); }

Settings truth(const std::vector<std::pair<std::string, std::string>>& values) {
  std::vector<Given> given;
  for (const auto& [key, value] : values) given.push_back({key, value, "--set", true, true});
  Problems problems;
  Settings settings = resolve(truth_options(model()), given, "test", problems);
  EXPECT_TRUE(problems.empty()) << problems.front().text();
  return settings;
}

/// What is recorded at a constant indicated rate.
std::vector<double> recorded(const Settings& settings, double rate, double step, std::size_t samples) {
  const Recorded recorded = model().record(settings, 0, step, RandomStream(9));
  std::vector<double> values(samples, rate);
  if (recorded.response) recorded.response(values);
  return values;
}

double sum(const std::vector<double>& values) {
  double total = 0.0;
  for (const double value : values) total += value;
  return total;
}

TEST(RingLaserGyro, CountsEdgesOfFringes) {
  const double K = 91237.4003, rate = si(1.0, "deg/s");
  for (const int edges : {1, 2, 4}) {
    const auto counts = recorded(truth({{"edges", std::to_string(edges)}}), rate, 0.01, 500);
    EXPECT_NEAR(sum(counts), edges * K * rate * 5.0, 1.0);  // a difference of two counter readings
    for (const double count : counts) {
      EXPECT_EQ(count, std::round(count));
      EXPECT_NEAR(count, edges * K * rate * 0.01, 1.0);
    }
  }
  EXPECT_LT(sum(recorded(truth({}), -rate, 0.01, 500)), 0.0);
}

TEST(RingLaserGyro, ScaleFactorFromRingOrAsGiven) {
  const double rate = si(10.0, "deg/s"), angle = rate * 10.0;
  const auto counts = [&](const std::vector<std::pair<std::string, std::string>>& values) {
    return sum(recorded(truth(values), rate, 1.0, 10));
  };
  // One count: a difference of two counter readings.
  EXPECT_NEAR(counts({{"shape", "square"}, {"side", "50 mm"}}), angle * 0.05 / 632.8e-9, 1.0);
  EXPECT_NEAR(counts({{"area", "100 cm^2"}, {"perimeter", "400 mm"}, {"wavelength", "1 um"}}), angle * 1e5, 1.0);
  EXPECT_NEAR(counts({{"scale_factor", "0.5 pulse/arcsec"}}), angle * 0.5 / si(1.0, "arcsec"), 1.0);
}

TEST(RingLaserGyro, StandsStillInTheDeadBandAndNotBeside) {
  const Settings settings = truth({{"lock_in_rate", "0.1 deg/s"}});
  EXPECT_LE(std::abs(sum(recorded(settings, si(0.09, "deg/s"), 0.1, 600))), 1.0);
  const double expected = 91237.4003 * si(std::sqrt(0.2 * 0.2 - 0.1 * 0.1), "deg/s") * 60.0;
  EXPECT_NEAR(sum(recorded(settings, si(0.2, "deg/s"), 0.1, 600)), expected, 1.5);
}

TEST(RingLaserGyro, RateOutputIsTheMeanOverTheSample) {
  const double rate = si(3.0, "deg/s");
  for (const double value : recorded(truth({{"output", "rate"}}), rate, 0.1, 3)) EXPECT_NEAR(value, rate, 1e-12);
  const auto locked = recorded(truth({{"output", "rate"}, {"lock_in_rate", "0.1 deg/s"}}), rate, 10.0, 2);
  EXPECT_NEAR(locked[1], rate * std::sqrt(1.0 - 1.0 / 900.0), 1.0 / 91237.4 / 10.0);
}

// A readout on the block sees the dither; over whole periods without noise nothing of it is left.
TEST(RingLaserGyro, WholeDitherPeriodsTakeTheDitherAway) {
  const auto settings = [](const char* readout) {
    return truth({{"readout", readout}, {"output", "rate"}, {"dither_rate", "100 deg/s"}, {"lock_in_rate", "0 deg/s"}});
  };
  const double rate = si(1.0, "deg/s");
  for (const double value : recorded(settings("block"), rate, 0.01, 10)) EXPECT_NEAR(value, rate, 1e-9);
  double largest = 0.0;
  for (const double value : recorded(settings("block"), rate, 0.00125, 10))
    largest = std::max(largest, std::abs(value - rate));
  EXPECT_NEAR(largest, si(100.0, "deg/s") * 2.0 / 3.141592653589793, 1e-6);  // mean of half a sine
}

TEST(RingLaserGyro, TermsAreWhatTheyAreCalled) {
  const auto output = model().outputs(truth({}))[0];
  Felt felt;
  felt.rate = {1.0, 2.0, 3.0};
  ASSERT_EQ(output.terms.size(), 4u);
  EXPECT_EQ(output.input(felt), 1.0);
  EXPECT_EQ(output.terms[0].regressor(felt), 1.0);
  EXPECT_EQ(output.terms[1].regressor(felt), 1.0);
  EXPECT_EQ(output.terms[2].regressor(felt), 2.0);
  EXPECT_EQ(output.terms[3].regressor(felt), 3.0);
}

TEST(RingLaserGyro, RefusesWhatCannotBeAllAtOnce) {
  try {
    model().outputs(truth({{"edges", "3"}, {"area", "1 cm^2"}}));
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind, Error::Kind::bad_input);
    EXPECT_EQ(error.problems.size(), 2u);
  }
}

}  // namespace
}  // namespace tumble::ring_laser_gyro_test
