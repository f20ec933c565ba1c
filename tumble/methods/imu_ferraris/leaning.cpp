#include "tumble/methods/imu_ferraris/leaning.hpp"

#include <cmath>

#include "tumble/math/square.hpp"
#include "tumble/reduce/imu/sensors.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/unit.hpp"

namespace tumble::imu_ferraris {
namespace {

/// [1] square over the mean square of the five others: F of 1 and 5 degrees of freedom, p = 2e-4 for one, 1e-3 for six.
constexpr double far_beyond_others = 100.0;
constexpr double least_lean = 2.0;  ///< [deg] of a pose: less is in the budget of any session by hand

}  // namespace

Findings leaning_poses(const Means& means, const Calibration& calibration) {
  double squares = 0.0, most = 0.0;
  std::size_t pair = 0, toward = 0;
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (axis == k) continue;
      const double sum = means.force[2 * axis][k] + means.force[2 * axis + 1][k];
      const double lean = (sum - 2.0 * calibration.b_a[k]) / (calibration.k_a[k] * means.gravity);
      squares += square(lean);
      if (std::abs(lean) > std::abs(most)) most = lean, pair = axis, toward = k;
    }
  const double others = (squares - square(most)) / 5.0;
  if (std::abs(most) < si(least_lean, "deg") || square(most) < far_beyond_others * others) return {};
  return {{Finding::Severity::warning,
           "pose_leans",
           {{"lean", std::abs(most), "deg"},
            {"axis", std::string(1, imu::letters[toward])},
            {"others", std::sqrt(others), "deg"}},
           labels()[2 * pair] + ", " + labels()[2 * pair + 1]}};
}

}  // namespace tumble::imu_ferraris
