#include <algorithm>

#include "tumble/departures/judgement.hpp"

namespace tumble {

// Every entry is a statement of physics: the record is that of another sound test. Where a method has another sensor that
// contradicts, the judgement does not accept the entry.
const std::vector<Unseen>& unseen_departures() {
  static const std::vector<Unseen> all{
      {"output_gain", "",
       "a gain of the acquisition is a scale factor of the instrument: the record is that of another instrument"},
      {"counting_clock", "",
       "a longer window holds more pulses of the same unit: the record is that of another scale factor"},
      {"asymmetry", "static_bias", "at rest there is one sign of the input only"},
      {"latitude_wrong", "",
       "another latitude is another rate of the Earth, of which a single attitude has one component only"},
      {"gravity_wrong", "", "gravity is the only specific force: another value is another scale factor"},
      {"reference_gain", "frequency_response",
       "the gain is that of the output over the reference: the two cannot be separated"},
      {"channel_sign", "static_bias", "without a known input along the axis a bias of either sign is possible"},
      {"channel_sign", "fog_thermal_bias",
       "no reference turns: the coefficients are those of a gyro that is mounted the other way round"},
      {"reference_gain", "fog_thermal_bias",
       "what the thermometers show is the temperature: with another gain of one, the coefficients are those of another "
       "gyro"},
      {"references_exchanged", "fog_thermal_bias",
       "nothing in the readings says which thermometer is on top: the gradient has the other sign"},
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

}  // namespace tumble
