#include "tumble/models/sagnac.hpp"

#include <gtest/gtest.h>

#include "tumble/units/unit.hpp"

namespace tumble {
namespace {

// Worked numbers of the lecture (Yan Gongmin, NWPU, 2015, slides 49-58), recomputed to half of the last digit shown.
TEST(Sagnac, RingOfTenCentimetres) {
  const double K = ring_laser_scale_factor(3, 0.1, 632.8e-9);
  EXPECT_NEAR(K, 91237.4003, 5e-5);
  EXPECT_NEAR(Unit::parse("pulse/arcsec").from_si(K), 0.44233140, 5e-9);
  EXPECT_NEAR(K * si(15.0, "deg/h"), 6.635, 5e-4);  // beat of the Earth rate [Hz]
  EXPECT_NEAR(ring_laser_scale_factor(0.25 * 1.7320508075688772 * 0.01, 0.3, 632.8e-9), K, 1e-9 * K);  // 4 A/(lambda L)
  EXPECT_DOUBLE_EQ(ring_laser_scale_factor(4, 0.1, 632.8e-9), ring_laser_scale_factor(0.01, 0.4, 632.8e-9));
}

TEST(Sagnac, RectangleOfMichelson) {
  const double rate = si(15.0, "deg/h");
  EXPECT_NEAR(sagnac_path_difference(600.0 * 300.0, rate), 1.7465375e-7, 5e-15);
  EXPECT_NEAR(ring_laser_scale_factor(600.0 * 300.0, 1800.0, 632.8e-9) * rate, 45968.43, 5e-3);  // [Hz]
}

TEST(Sagnac, CoilOfOneKilometre) {
  const double rate = si(0.01, "deg/h");
  EXPECT_NEAR(coil_phase_difference(1000.0, 0.1, 1.3e-6, rate), 7.8161103e-8, 5e-16);
  EXPECT_NEAR(coil_path_difference(1000.0, 0.1, rate), 1.6171644e-14, 5e-22);
}

}  // namespace
}  // namespace tumble
