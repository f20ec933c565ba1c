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
