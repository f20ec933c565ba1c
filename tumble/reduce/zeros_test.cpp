#include "tumble/reduce/zeros.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tumble/math/random.hpp"

namespace tumble {
namespace {

/// Of values in steps, whether zeros among them are taken out.
bool loses_zeros(const std::vector<double>& values) {
  EvenSignal signal;
  signal.rate = 10.0;
  signal.values = values;
  return !take_zeros_out(signal, "gyro").empty();
}

std::vector<double> rounded(double step, double mean, double sd) {
  std::vector<double> values(5000);
  const RandomStream random(7);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = step * std::round((mean + sd * random.normal(i)) / step);
  return values;
}

TEST(Zeros, AreAStepOfACoarseOutput) {
  for (const double step : {2.6, 3.0, 3.5, 6.0})
    for (const double mean : {0.4, 0.5, 0.6})
      EXPECT_FALSE(loses_zeros(rounded(step, mean * step, 1.0))) << step << " " << mean;
}

TEST(Zeros, AreTakenOutWhereTheOutputIsFarFromThem) {
  for (const double step : {1e-6, 0.5, 2.0}) {
    auto values = rounded(step, 100.0, 1.0);
    for (std::size_t i = 70; i < values.size(); i += 200) values[i] = 0.0;
    EXPECT_TRUE(loses_zeros(values)) << step;
  }
}

}  // namespace
}  // namespace tumble
