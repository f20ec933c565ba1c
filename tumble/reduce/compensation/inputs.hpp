#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/plan.hpp"
#include "tumble/core/recording.hpp"

/// Where the inputs of error terms come from: channels of the recording, else the schedule of a plan.
namespace tumble::compensation {

/// One input as terms need it: the quantity, or the channel of a role, as it is or felt with a lag.
struct Slot {
  Input input = Input::rate_x;
  std::string role = {};
  double lag = 0.0;             ///< [s] time constant; 0: as it is
  std::size_t base = SIZE_MAX;  ///< of a lagged input: the slot without the lag
};

/// The slots of every compensation: each input but `channel`, in the order of Input.
std::vector<Slot> common_slots();
inline constexpr std::size_t common_slot_count = static_cast<std::size_t>(Input::channel);

/// The known inputs at the samples of a channel.
struct Inputs {
  /// Where each comes from, for people: "channel accelerometer_x", "schedule of the plan". Empty: it is not known.
  std::vector<std::string> from;
  std::vector<bool> planned;  ///< of each slot: the plan alone says it
  /// Fills in what is known [SI] at sample number `i` of the output, slot by slot; what is missing has the value of a
  /// Felt at rest. NaN where a channel has no value. Lagged slots stay as they are.
  std::function<void(std::size_t i, std::span<double> values)> fill;
  /// Puts in the place of temperatures the means that are compared with what the test covered. Empty: the samples are.
  std::function<void(std::size_t i, std::span<double> values)> average;
};

/// An input is a channel: the one that the result's [channels] name for its role, else one called like the role, else
/// (rate_x, specific_force_x) one called gyro_x or accelerometer_x, alone or after the name of an instrument and a dot.
/// Angular acceleration is the difference quotient of a rate. What no channel says comes from the plan's schedule and
/// rig, and the time since power-on from the recording's marks. With `thermal` the temperatures are those of
/// reduce/thermal.
///
/// Given     output  a channel of `recording`; `plan` may be null. All outlive what is returned
/// Throws    Error::bad_input where the plan has no rig or schedule
Inputs inputs_of(const Estimate& estimate, const Recording& recording, const Channel& output, const Plan* plan,
                 const std::vector<Slot>& slots, const std::optional<ThermalReading>& thermal);

/// Whether a term depends on an input.
bool needs(const OutputModel& model, Input input);

/// Throws    Error::bad_data where the recording lacks a sensor that the temperatures of a model are read from
void require_sensors(const Estimate& estimate, const Recording& recording, const OutputModel& model);

/// Between the samples on both sides [SI of the channel]; the first and last value beyond the ends.
double value_at(const Channel& channel, double time);
/// Difference quotient [SI of the channel/s] over one sample to each side.
double slope_at(const Channel& channel, double time);

}  // namespace tumble::compensation
