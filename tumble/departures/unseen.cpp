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
      {"unit_wrong", "allan_noise", "noise in another unit is that of another gyro: nothing known acts on it"},
      {"unit_wrong", "static_bias", "a bias in another unit is that of another gyro: nothing known acts on it"},
      {"unit_wrong", "fog_thermal_bias", "a bias in another unit is that of another gyro: nothing known acts on it"},
      {"unit_wrong", "gyro_scale_factor",
       "volts in another unit are another scale factor: the record is that of another gyro"},
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
