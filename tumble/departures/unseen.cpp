#include <algorithm>

#include "tumble/departures/judgement.hpp"

namespace tumble {

// Every entry is a statement of physics: the record is that of another sound test. Where a method has another sensor that
// contradicts, the judgement does not accept the entry.
// NOLINTNEXTLINE(readability-function-size): a table, one entry after another
const std::vector<Unseen>& unseen_departures() {
  static const std::vector<Unseen> all{
      {"output_gain", "",
       "a gain of the acquisition is a scale factor of the instrument: the record is that of another instrument"},
      {"counting_clock", "",
       "a longer window holds more pulses of the same unit: the record is that of another scale factor"},
      {"asymmetry", "gyro_scale_factor",
       "the method measures the asymmetry of the output, whatever causes it: the record is that of another gyro"},
      {"motor_heat", "gyro_scale_factor",
       "heat that grows with the square of the rate is nearly an asymmetry: what distinguishes the two is below the "
       "noise"},
      {"asymmetry", "accelerometer_centrifuge",
       "each side of the output is turned outward at its own radius: two polarities that differ are a centre of "
       "acceleration beside the axis of the case"},
      {"asymmetry", "accelerometer_tumble",
       "at positions in a field of 1 g, two polarities that differ are nearly a second-order term, and what remains is "
       "below the errors of the positions"},
      {"channel_sign", "polar_axis_tumble",
       "the input axis turns across the axis of the Earth, so that no known rate shows the sign: every drift term has "
       "the other one"},
      {"unit_wrong", "polar_axis_tumble",
       "the input axis turns across the axis of the Earth, so that no known rate shows the scale: every drift term is "
       "multiplied"},
      {"asymmetry", "imu_turntable",
       "the mean of two polarities is a scale factor, and at faces and edges in 1 g their difference is a second-order "
       "term"},
      {"asymmetry", "static_bias", "at rest there is one sign of the input only"},
      {"magnetic", "imu_turntable",
       "a field that turns with an axis goes round as gravity does: at the faces it is a misalignment and a "
       "second-order term"},
      {"magnetic", "polar_axis_tumble",
       "a field that turns with the head gives one wave a turn, alike with O north and south, as D_IO and D_OS do: the "
       "record is that of a gyro with other products"},
      {"latitude_wrong", "",
       "another latitude is another rate of the Earth, of which a single attitude has one component only"},
      {"gravity_wrong", "", "gravity is the only specific force: another value is another scale factor"},
      {"asymmetry", "sine_vibration",
       "at one level the mean of a rectified sine is that of a second-order term: levels of different size separate "
       "them"},
      {"asymmetry", "random_vibration",
       "at one level the mean of a rectified vibration is that of a second-order term: levels of different size "
       "separate them"},
      {"cross_motion", "sine_vibration", "motion across leaves nothing but a rectification, which K_2 gives too"},
      {"cross_motion", "random_vibration", "motion across leaves nothing but a rectification, which K_2 gives too"},
      {"loop_unstated", "frequency_response", "a loop behind the output is a part of the response that is measured"},
      {"filter_unstated", "frequency_response",
       "a filter behind the output is a part of the response that is measured"},
      {"stamps_late", "frequency_response",
       "a delay of the output against the reference is a part of the response that is measured", true},
      {"stamps_at_end", "frequency_response",
       "a delay of the output against the reference is a part of the response that is measured", true},
      {"reference_late", "frequency_response",
       "a delay of the output against the reference is a part of the response that is measured", true},
      {"magnetic", "dtg_centrifuge",
       "a part of the line at the heading that is magnetic is another gain and azimuth of the reference gyro"},
      {"reference_gain", "frequency_response",
       "the gain is that of the output over the reference: the two cannot be separated", true},
      {"level_off", "north_finding", "roll and pitch are what the test finds: the record is that of another base"},
      {"asymmetry", "imu_ferraris",
       "an accelerometer that is asymmetric at +1 g and -1 g has another bias; level poses show it by less than their "
       "tilts"},
      {"asymmetry", "imu_multi_position",
       "the mean of two polarities is a scale factor and a bias, and by what they differ from these in 1 g is below "
       "what "
       "a rest is off by"},
      {"warm_up", "imu_ferraris",
       "a bias that settles by less than what the halves of the first pose are uncertain by is part of the mean of "
       "that "
       "pose"},
      {"bias_step", "polar_axis_tumble",
       "a bias that jumps while O is turned over is a drift along O, and the nearer to this the jump is, the more of "
       "it"},
      {"bias_step", "imu_multi_position",
       "each rest shows a combination of the three axes of an accelerometer and none alone: a bias that changes by "
       "less "
       "than what a rest is off by is one of between"},
      {"asymmetry", "accelerometer_four_position",
       "at +1 g, 0 and -1 g an output that is larger for positive forces is one with another second order"},
      {"unit_wrong", "allan_noise", "noise in another unit is that of another gyro: nothing known acts on it"},
      {"unit_wrong", "static_bias", "a bias in another unit is that of another gyro: nothing known acts on it"},
      {"unit_wrong", "fog_thermal_bias", "a bias in another unit is that of another gyro: nothing known acts on it"},
      {"unit_wrong", "gyro_scale_factor",
       "volts in another unit are another scale factor: the record is that of another gyro"},
      {"channel_sign", "static_bias", "without a known input along the axis a bias of either sign is possible"},
      {"channel_sign", "fog_thermal_bias",
       "no reference turns: the coefficients are those of a gyro that is mounted the other way round"},
      {"reference_gain", "fog_thermal_bias",
       "what the thermometers show is the temperature: with another gain of one, the coefficients are those of another "
       "gyro",
       true},
      {"references_exchanged", "fog_thermal_bias",
       "nothing in the readings says which thermometer is on top: the gradient has the other sign", true},
      {"run_drift", "fog_thermal_bias",
       "a change that is no larger than the scatter between power-ups cannot be distinguished from it"},
      {"temperature_unrecorded", "allan_noise", "a slow change of the bias is what rate random walk is"}};
  return all;
}

const Unseen* find_unseen(std::string_view departure, std::string_view method) {
  const std::string_view any;
  const auto& all = unseen_departures();
  const auto found = std::ranges::find_if(all, [&](const Unseen& one) {
    return departure == one.departure && (one.method == any || method == one.method);
  });
  return found == all.end() ? nullptr : &*found;
}

std::vector<std::string> unseen_in(const Plan& plan, const Recordings& recordings) {
  std::vector<std::string> names;
  for (const Departure& departure : departure_catalogue())
    if (find_unseen(departure.name, plan.method) != nullptr && !departure.targets(plan, recordings).empty())
      names.emplace_back(departure.name);
  return names;
}

}  // namespace tumble
