#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tumble/methods/frequency_response/describe.hpp"
#include "tumble/methods/testing/real_data.hpp"

namespace tumble {
namespace {

/// Primary sine calibration of an MPU-9250 at PTB: ten loops over 17 frequencies. The delay of its published
/// response and its -3 dB crossing must come back.
TEST(FrequencyResponseRealData, ResponseOfARealAccelerometer) {
  const std::string name = "ptb_cem_mpu9250_sine_cal/MPU9250_PTB.csv";
  if (const auto sentence = absent({name}); !sentence.empty()) GTEST_SKIP() << sentence;
  std::ifstream file(real_data(name));
  std::map<double, std::vector<double>> sums;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    double index, f, gain, gain_expanded, amplitude, phase, phase_expanded;
    words >> index >> f >> gain >> gain_expanded >> amplitude >> phase >> phase_expanded;
    auto& s = sums[f];
    s.resize(5, 0.0);
    const double all[]{gain, gain_expanded, phase, phase_expanded, amplitude};
    for (std::size_t k = 0; k < 5; ++k) s[k] += all[k] / 10.0;
  }
  ASSERT_EQ(sums.size(), 17u);
  frequency_response::Measured m;
  for (const auto& [f, s] : sums) {
    m.frequency.push_back(f);
    m.log_gain.push_back(std::log(s[0]));
    m.phase.push_back(s[2]);
    m.log_gain_variance.push_back(std::pow(s[1] / 2.0 / s[0], 2));
    m.phase_variance.push_back(std::pow(s[3] / 2.0, 2));
  }
  // The phase is that of a delay; its published value is 1.511 ms to four digits.
  EXPECT_NEAR(frequency_response::fit_loop(m, frequency_response::LoopKind::delay).theta[1], 1.511e-3, 0.0005e-3);
  const auto crossing = frequency_response::crossing_of(m.frequency, m.log_gain);
  ASSERT_TRUE(crossing.found);  // between 200 Hz (0.7532 of the first) and 250 Hz (0.6319)
  EXPECT_GT(crossing.frequency, 200.0);
  EXPECT_LT(crossing.frequency, 250.0);
}

}  // namespace
}  // namespace tumble
