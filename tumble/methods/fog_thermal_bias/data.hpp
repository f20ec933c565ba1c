#pragma once

#include <string>
#include <vector>

#include "tumble/core/evidence.hpp"
#include "tumble/math/matrix.hpp"
#include "tumble/models/model.hpp"

namespace tumble::fog_thermal_bias {

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
Thermal thermal_of(const Sensors& sensors, double begin, double end, const Settings& settings, double lag);

/// One power-up, averaged over intervals: what is regressed.
struct RunData {
  int number = 0;
  std::string label;
  std::size_t recording = 0;
  std::string file;                ///< of the recording; empty: not from a file
  double start_temperature = 0.0;  ///< [K]
  double start_output = 0.0;       ///< L_0, mean over the start window [rad/s]
  std::vector<double> time;        ///< middle of each interval, since power-on [s]
  std::vector<double> share;       ///< measured part of each interval, 0 to 1
  std::vector<double> output;      ///< mean output [rad/s], 0 where share is 0
  std::vector<Felt> felt;          ///< means over each interval
  Matrix regressors;               ///< intervals x (terms, then departures), averaged over each interval
  bool held_out = false;
};

/// Calls visit(run, k) for each average with data of the runs that are fitted.
template <class Visit>
void each_average(const std::vector<RunData>& runs, Visit visit) {
  for (const auto& run : runs)
    for (std::size_t k = 0; k < run.time.size() && !run.held_out; ++k)
      if (run.share[k] > 0.0) visit(run, k);
}

/// The power-ups of the evidence with the regressors of `terms`, averaged over `interval` [s]. `lag` [s] of the
/// sensors. Throws Error::bad_data for a run shorter than an interval or a clock that runs backwards.
std::vector<RunData> run_data(const Evidence& evidence, const std::vector<Term>& terms, double lag, double interval);

/// Error::bad_data where the stamps of a channel do not increase.
void refuse_backward(const Channel& channel);

/// One value per sample time [s], linear between the thermal samples and constant beyond them.
Felt felt_at(const Thermal& thermal, double time);

/// The constants of the gyro's table of terms that go with these settings.
Settings constants_of(const Settings& settings);

}  // namespace tumble::fog_thermal_bias
