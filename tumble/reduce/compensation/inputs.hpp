#pragma once

#include <array>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/plan.hpp"
#include "tumble/core/recording.hpp"
#include "tumble/models/model.hpp"

/// Where the inputs of error terms come from: channels of the recording, else the schedule of a plan.
namespace tumble::compensation {

/// One number of what an instrument feels.
struct Input {
  const char* name;  ///< "specific_force_x": the role of the channel that measures it
  double& (*of)(Felt& felt);
};

inline constexpr std::size_t input_count = 14;
const std::array<Input, input_count>& inputs();

/// Which inputs the regressor of a term depends on, found by changing them one by one about several points.
std::array<bool, input_count> needs(const Term& term);

/// The known inputs at the samples of a channel.
struct Inputs {
  /// Where each comes from, for people: "channel accelerometer_x", "schedule of the plan". Empty: it is not known.
  std::array<std::string, input_count> from;
  /// Fills in what is known [SI] at the samples of the output from number `first` on; what is missing has the value of
  /// a Felt at rest. NaN where a channel has no value.
  std::function<void(std::size_t first, std::span<Felt> felt)> fill;
};

/// An input is a channel: the one that the result's [channels] name for its role, else one called like the role, else
/// (rate_x, specific_force_x) one called gyro_x or accelerometer_x, alone or after the name of an instrument and a dot.
/// Angular acceleration is the difference quotient of a rate. What no channel says comes from the plan's schedule and
/// rig, and the time since power-on from the recording's marks.
///
/// Given     output  a channel of `recording`; `plan` may be null. Both outlive what is returned
/// Throws    Error::bad_input where the plan has no rig or schedule
Inputs inputs_of(const Estimate& estimate, const Recording& recording, const Channel& output, const Plan* plan);

}  // namespace tumble::compensation
