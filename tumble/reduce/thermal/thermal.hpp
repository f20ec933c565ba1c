#pragma once

#include <vector>

#include "tumble/core/channel.hpp"
#include "tumble/core/error_model.hpp"
#include "tumble/models/model.hpp"

/// Temperatures as a thermal model feels them, from the readings of one or two temperature sensors.
namespace tumble::thermal {

/// The samples of a channel between two times, with their stamps.
struct Slice {
  std::vector<double> time, value;
};

/// The samples between `begin` and `end` [s].
Slice slice(const Channel& channel, double begin, double end);

/// Mean time between readings [s]; infinite: one reading.
double reading_spacing(const std::vector<double>& times);

/// Temperatures of one power-up as the gyro felt them: smoothed, freed of the sensors' lag.
struct Thermal {
  std::vector<double> time;  ///< [s]
  std::vector<Felt> felt;
  double start_temperature = 0.0;  ///< [K], mean over the start window
};

/// The temperature channels of a recording. `side` is null where there is one sensor.
struct Sensors {
  const Channel* top = nullptr;
  const Channel* side = nullptr;
};

/// Smooths the readings between `begin` and `end` [s] and fills T, gradient, rate and start temperature.
///   T = mean of the sensors + lag dT/dt,  gradient = top - side + lag d(top - side)/dt,  rate = dT/dt + lag d2T/dt2
/// Throws Error::bad_data where the start window holds no temperature.
Thermal thermal_of(const Sensors& sensors, double begin, double end, const ThermalReading& reading);

/// One value per sample time [s], linear between the thermal samples and constant beyond them.
Felt felt_at(const Thermal& thermal, double time);

/// Error::bad_data where the stamps of a channel do not increase.
void refuse_backward(const Channel& channel);

}  // namespace tumble::thermal
