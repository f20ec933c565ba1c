#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "tumble/core/finding.hpp"
#include "tumble/math/matrix.hpp"
#include "tumble/reduce/imu/sensors.hpp"

/// Are the three outputs of a triad those of the axes that they are named after, of the right sign and in their unit?
namespace tumble::imu {

/// The exchange and reversal of axes that is nearest to what was seen.
struct AxesSeen {
  std::array<std::size_t, 3> along{0, 1, 2};   ///< output i shows axis along[i]
  std::array<double, 3> ratio{1.0, 1.0, 1.0};  ///< what it shows of a unit of it, with its sign; NaN: not seen
  double misfit = 0.0;  ///< 0: nothing else is shown; 1: the outputs have nothing to do with the axes
};

/// From the response of the outputs [3 x 3]: output i = sum_j response(i, j) felt_j + bias.
AxesSeen axes_seen(const Matrix& response);

/// From means over segments, one after the other: what was felt by the plan, and what the three outputs showed. Robust:
/// up to a third of the segments may be wrong. An axis that nothing was felt along keeps its name.
/// Given: felt [SI], shown [SI of the outputs], one a segment.
AxesSeen axes_seen(std::span<const Vector3> felt, std::span<const Vector3> shown);

/// What is wrong with them, each an error with what would mend it: exchanged outputs, reversed ones, a left-handed
/// triad, the sign of gravity, units taken for others. Empty: sound. `channels` are the names of the three outputs
/// for the reader; empty: those of the roles.
Findings about_axes(Kind kind, const AxesSeen& seen, const std::array<std::string, 3>& channels = {});

/// The whole check of means over segments: about_axes where an exchange of axes explains them, and the segments that
/// read as others of the plan do: the order, the angles or the labels are then not those of the plan.
/// Given: felt [SI], shown [SI of the outputs], one a segment.
Findings about_triad(Kind kind, std::span<const Vector3> felt, std::span<const Vector3> shown,
                     const std::vector<std::string>& labels, const std::array<std::string, 3>& channels = {});

}  // namespace tumble::imu
