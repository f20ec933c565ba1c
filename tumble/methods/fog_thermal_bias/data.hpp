#pragma once

#include <string>
#include <vector>

#include "tumble/core/evidence.hpp"
#include "tumble/math/matrix.hpp"
#include "tumble/models/model.hpp"
#include "tumble/reduce/thermal/thermal.hpp"

namespace tumble::fog_thermal_bias {

using thermal::reading_spacing;
using thermal::refuse_backward;
using thermal::Sensors;
using thermal::Slice;
using thermal::slice;
using thermal::Thermal;
using thermal::thermal_of;

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
  double begin = 0.0;    ///< of power-on [s of the recording]
  double of_next = 0.0;  ///< [s] at its end that is not used: readings of the next power-up
  double of_last = 0.0;  ///< [s] at its begin whose temperatures are not used: readings of the power-up before
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

/// How the temperatures are read, by these settings and the `lag` [s] of the sensors.
ThermalReading reading_of(const Settings& settings, double lag);

/// The constants of the gyro's table of terms that go with these settings.
Settings constants_of(const Settings& settings);

}  // namespace tumble::fog_thermal_bias
