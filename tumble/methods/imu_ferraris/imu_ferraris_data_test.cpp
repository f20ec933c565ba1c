#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "tumble/methods/imu_ferraris/closed_form.hpp"
#include "tumble/methods/imu_ferraris/sections.hpp"
#include "tumble/methods/testing/real_data.hpp"

namespace tumble {
namespace {

/// Unweighted least squares of the same six poses has the same matrix; its bias is the mean over all six poses, in
/// which the tilts across the vertical do not cancel.
TEST(ImuFerrarisRealData, MatrixOfThePublishedSixPositionsAgrees) {
  const std::string name = "ward_mpu9250_six_position/six_position_data_1.csv";
  if (const auto sentence = absent({name}); !sentence.empty()) GTEST_SKIP() << sentence;
  std::ifstream file(real_data(name));
  constexpr std::size_t section[]{4, 5, 2, 3, 0, 1};  // of the rows: z, y, x, each up and down
  imu_ferraris::Means means;
  means.gravity = 1.0;
  std::string line;
  std::getline(file, line);
  for (const std::size_t p : section) {
    ASSERT_TRUE(std::getline(file, line));
    std::vector<double> cells;
    for (std::size_t begin = 0; begin < line.size(); begin = std::min(line.find(',', begin), line.size()) + 1)
      cells.push_back(std::stod(line.substr(begin)));
    means.force[p] = {cells[1], cells[4], cells[7]};
  }
  const auto calibration = imu_ferraris::closed_form(means);
  const auto matrix = imu_ferraris::response(calibration.k_a, calibration.r_a);
  const double expected[3][3]{{1.0000556467213397, 0.007979301129915212, 0.009036229937292894},
                              {-0.006398611733574581, 1.000368743052482, 0.010617732056420755},
                              {-0.010180850425662455, -0.004426368434608248, 1.0219536083623109}};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) EXPECT_NEAR(matrix(i, j), expected[i][j], 1e-9);  // as their search ended
  EXPECT_NEAR(calibration.b_a.x, 0.09156383511421798, 0.01);                              // tilts of half a degree
}

}  // namespace
}  // namespace tumble
