#include "tumble/reduce/linear/slow.hpp"

#include <gtest/gtest.h>

namespace tumble::linear {
namespace {

/// Three looks at each of two power-ups, by clocks that begin at these times [s].
std::vector<Interval> looks(double first, double second) {
  std::vector<Interval> intervals;
  for (const double begin : {0.0, 100.0, 300.0}) {
    intervals.push_back({0, first + begin, 50.0});
    intervals.push_back({1, second + begin, 50.0});
  }
  return intervals;
}

TEST(SlowNoise, OfFlickerDoesNotDependOnWhereAClockBegins) {
  NoiseModel noise;
  noise.bias_instability = 2.0;
  const auto kernel = [&](double first, double second) {
    return known_slow_noise(looks(first, second), noise, 0.0, 0.1).front().kernel.values;
  };
  const auto stated = [](double first, double second) {
    return unknown_slow_noise(looks(first, second), 1, 0.1, 2.0).at(1).kernel.values;
  };
  // the shifts are whole seconds: differences of such times are exact
  for (const auto& [first, second] : {std::pair{1000.0, 1000.0}, {0.0, 1e6}, {1.7e9, 1.7e9}}) {
    EXPECT_EQ(kernel(first, second), kernel(0.0, 0.0)) << first;
    EXPECT_EQ(stated(first, second), stated(0.0, 0.0)) << first;
  }
}

}  // namespace
}  // namespace tumble::linear
