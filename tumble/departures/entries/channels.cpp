#include <algorithm>
#include <cmath>

#include "tumble/departures/entries/edits.hpp"
#include "tumble/departures/entries/entries.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::entries {
namespace {

/// Names of which the channel has a partner of its kind among them.
std::vector<std::string> exchangeable(const Recordings& recordings, const std::vector<std::string>& names) {
  std::vector<std::string> all;
  std::vector<QuantityKind> kinds;
  for (const Recording& recording : recordings)
    for (const std::string& name : names) {
      const Channel* one = find_channel(recording, name);
      if (one == nullptr || std::ranges::find(kinds, one->kind) != kinds.end()) continue;
      const auto partner = [&](const std::string& other) {
        const Channel* second = find_channel(recording, other);
        return other != name && second != nullptr && second->kind == one->kind &&
               second->values.size() == one->values.size();
      };
      if (std::ranges::none_of(names, partner)) continue;
      kinds.push_back(one->kind);
      all.push_back(name);
    }
  return all;
}

/// The samples of the channel and of the next one of its kind among `names`, in each recording.
void exchange(Recordings& recordings, const std::string& name, const std::vector<std::string>& names) {
  for (Recording& recording : recordings) {
    const auto one = std::ranges::find(recording.channels, name, &Channel::name);
    if (one == recording.channels.end()) continue;
    const auto other = std::ranges::find_if(recording.channels, [&](const Channel& channel) {
      return channel.name != name && channel.kind == one->kind && channel.values.size() == one->values.size() &&
             std::ranges::find(names, channel.name) != names.end();
    });
    if (other != recording.channels.end()) std::swap(one->values, other->values);
  }
}

/// The samples were written in another unit than the column says: m/s^2 for g, rad/s for deg/s, counts in thousands.
void mistake_unit(Recordings& recordings, const std::string& name) {
  edit_channel(recordings, name, [](Channel& channel) {
    double factor = 1e-3;
    if (channel.kind == QuantityKind::specific_force || channel.kind == QuantityKind::velocity)
      factor = standard_gravity;
    if (channel.kind == QuantityKind::angular_rate || channel.kind == QuantityKind::angle) factor = degree;
    for (double& value : channel.values) value *= factor;
  });
}

std::vector<std::string> signals(const Plan& plan, const Recordings& recordings) {
  std::vector<std::string> names = outputs(plan, recordings);
  for (auto& name : reference_sensors(plan, recordings)) names.push_back(std::move(name));
  return names;
}

std::vector<std::string> with_a_reading(const Plan& plan, const Recordings& recordings) {
  std::vector<std::string> names = first_of(reference_sensors(plan, recordings));
  for (auto& name : first_of(thermometers(plan, recordings))) names.push_back(std::move(name));
  return names;
}

/// An acquisition system of good quality, where the plan does not say what its scale factor is known to.
double covered_output_gain(const Plan& plan, const Recordings&, const std::string&) {
  constexpr double acquisition = 100e-6;
  return plan.settings.has("scale_factor_sd") ? std::max(plan.settings.number("scale_factor_sd"), 1e-6) : acquisition;
}

double covered_reference_gain(const Plan& plan, const Recordings&, const std::string&) {
  return std::max({rig_number(plan, "reference_gain_sd", 0.0), rig_number(plan, "thermometer_scale_sd", 0.0), 1e-3});
}

void reverse(const Plan&, Recordings& recordings, const Happening& what) {
  edit_values(recordings, what.target, [](double value) { return -value; });
}

void amplify(const Plan&, Recordings& recordings, const Happening& what) {
  edit_measured(recordings, what.target, [&](double value) { return value * (1.0 + what.size); });
}

/// A thermometer's scale is in kelvin from 0 degC.
void amplify_reference(const Plan& plan, Recordings& recordings, const Happening& what) {
  const auto cold = thermometers(plan, recordings);
  const double zero = std::ranges::find(cold, what.target) == cold.end() ? 0.0 : 273.15;
  edit_values(recordings, what.target, [&](double value) { return zero + (value - zero) * (1.0 + what.size); });
}

}  // namespace

// NOLINTNEXTLINE(readability-function-size): a table, one entry after another
std::vector<Departure> of_channels() {
  return {{.name = "channel_sign",
           .summary = "a channel has the other sign than the plan says",
           .targets = signals,
           .told_by = {"wrong_sign", "rest_inverted", "response_inverted", "sign_or_delay", "gyro_reversed",
                       "gyro_counts_down", "scale_factor_negative", "scale_factor_of_other_sign", "axis_reversed",
                       "axes_mirrored", "gravity_inverted", "rates_inverted", "rotation_reversed_by_scale_factor",
                       "scale_factor_negative_in_set", "vibration_differs_from_reference", "wrong_horizontal_rate",
                       "accelerometer_reversed", "accelerometers_do_not_fit_plan", "known_input_differs"},
           .record = reverse},
          {.name = "outputs_exchanged",
           .summary = "two outputs of one kind are exchanged",
           .targets = [](const Plan& plan, const Recordings& r) { return exchangeable(r, all_outputs(plan, r)); },
           .told_by = {"axes_exchanged", "outputs_exchanged", "axes_turned", "axes_mirrored", "gyro_axis_is_another",
                       "accelerometers_exchanged", "another_gyro_shows_rate", "gyro_and_reference_exchanged",
                       "units_exchanged"},
           .record = [](const Plan& plan, Recordings& r,
                        const Happening& what) { exchange(r, what.target, all_outputs(plan, r)); }},
          {.name = "references_exchanged",
           .summary = "two encoders, thermometers or reference sensors are exchanged",
           .targets = [](const Plan& plan, const Recordings& r) { return exchangeable(r, references(plan, r)); },
           .told_by = {"angle_off_plan", "turn_rate_recorded", "gradient_follows_rate", "arm_turns_the_other_way"},
           .record = [](const Plan& plan, Recordings& r,
                        const Happening& what) { exchange(r, what.target, references(plan, r)); }},
          {.name = "unit_wrong",
           .summary = "a channel is in another unit than its column says",
           .targets = signals,
           .told_by = {"unit_mistaken", "channel_unit_mistaken", "scale_mistaken", "scale_factor_far_from_given",
                       "scale_factor_far_from_reference", "improbable_gain", "force_probably_in_g", "unexpected_unit",
                       "force_differs_from_gravity", "gyro_gain_far_from_stated", "scale_factor_differs_at_rest",
                       "level_differs_from_reference", "vibration_differs_from_reference", "rest_differs_from_plan",
                       "earth_rate_differs", "counts_not_whole", "gain_of_another_unit", "known_input_differs"},
           .record = [](const Plan&, Recordings& r, const Happening& what) { mistake_unit(r, what.target); }},
          {.name = "kelvin",
           .summary = "a thermometer's column says degC and holds kelvin",
           .targets = thermometers,
           .told_by = {"probably_kelvin", "implausibly_cold", "unexpected_unit", "temperature_of_no_chamber"},
           .record =
               [](const Plan&, Recordings& recordings, const Happening& what) {
                 edit_values(recordings, what.target, [](double value) { return value + 273.15; });
               }},
          {.name = "output_gain",
           .summary = "the acquisition multiplies an output",
           .targets = outputs,
           .told_by = {"scale_factor_far_from_given", "scale_factor_differs_at_rest", "force_differs_from_gravity",
                       "different_tilts", "known_input_differs"},
           .unit = "ppm",
           .covered = covered_output_gain,
           .record = amplify},
          {.name = "reference_gain",
           .summary = "a reference sensor or a thermometer shows larger values than there are",
           .targets = with_a_reading,
           .told_by = {"level_differs_from_reference", "vibration_differs_from_reference", "level_differs_from_plan",
                       "gyro_gain_far_from_stated", "force_differs_from_rig", "term_differs"},
           .unit = "%",
           .covered = covered_reference_gain,
           .record = amplify_reference}};
}

}  // namespace tumble::entries
