#pragma once

#include <array>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/plan.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/north_finding/model.hpp"

namespace tumble::north_finding {

/// Quantities that are known beforehand with this covariance.
struct Prior {
  std::string source;  ///< as the budget names it
  std::vector<Quantity> of;
  Matrix covariance;  ///< [SI]
};

/// Prior knowledge of the instrument.
struct Instrument {
  State state{};                             ///< tilt and azimuth 0
  std::array<bool, channels> scale_known{};  ///< else it is estimated with the azimuth
  std::array<bool, channels> bias_known{};   ///< of accelerometers: used where the positions cannot show it
  std::vector<Prior> priors;
};

/// How a channel is recorded.
struct Recorded {
  bool present = false;
  Unit unit;          ///< of the output per second: "pulse/s", "deg/h", "V"
  bool plain = true;  ///< a rate or a specific force: the scale factor is 1
  double per_second = 1.0;
  bool pulses = false;
};
using Records = std::array<Recorded, channels>;

/// From the channel's unit. Given: rate [Hz]. Throws Error::bad_data where it is no output of such a sensor.
Recorded recorded_as(Channel channel, const Unit& unit, double rate);

/// Settings that say what is known of the instrument.
std::vector<Option> instrument_options();

/// Remove the quantity from the priors.
void forget(Instrument& instrument, Quantity quantity);

/// The instrument by the settings: nominal scale factors, no misalignment, with the uncertainties stated.
Instrument nominal_instrument(const Plan& plan, const Records& records);

/// Values of the calibration in place of the nominal ones, with their covariance. Throws Error::bad_input where it has
/// none of them, or one in another unit.
Instrument identified_instrument(const Plan& plan, const Records& records);

}  // namespace tumble::north_finding
