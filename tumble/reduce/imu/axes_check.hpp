#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "tumble/core/finding.hpp"
#include "tumble/math/matrix.hpp"
#include "tumble/reduce/imu/sensors.hpp"

/// Check of a triad: each output shows the axis of its name, with its sign and in its unit.
namespace tumble::imu {

/// The exchange and reversal of axes that is nearest to the outputs.
struct AxesSeen {
  std::array<std::size_t, 3> along{0, 1, 2};   ///< output i shows axis along[i]
  std::array<double, 3> ratio{1.0, 1.0, 1.0};  ///< output for a unit of input, with its sign; NaN: no input
  double misfit = 0.0;  ///< 0: the axes explain the outputs; 1: the outputs have nothing to do with the axes
};

/// From the response of the outputs [3 x 3]: output i = sum_j response(i, j) felt_j + bias.
AxesSeen axes_seen(const Matrix& response);

/// From means over segments: the input by the plan and the three outputs. Robust: up to a third of the segments may be
/// wrong. An axis without input keeps its name.
/// Given: felt [SI], shown [SI of the outputs], one for each segment.
AxesSeen axes_seen(std::span<const Vector3> felt, std::span<const Vector3> shown);

/// Outputs less their biases, however large these are: what is half way between the least and the greatest of an
/// output, where what was felt goes as far to both sides of each axis. Else the outputs as they are.
///
/// Given: felt [SI], shown [SI of the outputs], one for each segment. Returned: shown [SI of the outputs].
std::vector<Vector3> without_offsets(std::span<const Vector3> felt, std::span<const Vector3> shown);

/// Faults of the axes, each an error with its remedy: axes_exchanged, axis_reversed, axes_mirrored (left-handed),
/// axes_turned, gravity_inverted, rates_inverted, unit_mistaken, scale_mistaken. Empty: sound. `channels` are the names
/// of the three outputs for the reader; empty: those of the roles.
Findings about_axes(Kind kind, const AxesSeen& axes, const std::array<std::string, 3>& channels = {});

/// Check of means over segments: about_axes where an exchange of axes explains them, and segment_reads_as_another,
/// segment_reads_as_none where the order, the angles or the labels are not those of the plan.
/// Given: felt [SI], shown [SI of the outputs], one for each segment.
Findings about_triad(Kind kind, std::span<const Vector3> felt, std::span<const Vector3> shown,
                     const std::vector<std::string>& labels, const std::array<std::string, 3>& channels = {});

}  // namespace tumble::imu
