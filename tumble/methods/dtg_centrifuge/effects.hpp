#pragma once

#include <string>
#include <vector>

#include "tumble/methods/dtg_centrifuge/reduce.hpp"

/// Changes of the sensitive term of every observation by errors of the rig and of the instruments' stated constants.
namespace tumble::dtg_centrifuge {

struct Effect {
  std::string source;
  std::vector<Complex> value;          ///< of each observation: shift of p + i q by one standard deviation
  std::vector<Complex> second, third;  ///< shifts of Z_2/a^2 and Z_3/a^3
  std::string key = {};                ///< see Contribution
  double sd = 0.0;                     ///< [SI] of an error of the rig
};

/// Causes that the levels hint at, and do not show: what they explain is an uncertainty.
struct Doubt {
  double relation = 0.0;  ///< [1] gain and azimuth of the reference gyro
  double beside = 0.0;    ///< [rad/s] a line of the same size at every level
  bool any() const { return relation > 0.0 || beside > 0.0; }
};

/// Data that the estimator gets in addition to the lines.
struct Circumstances {
  const Test& test;
  const std::vector<Measured>& measured;
  const Reduction& reduction;
  const Settings& settings;
  const Relation& relation;
  const Sensitivity& sensitivity;
  Signal output;
  bool phase_known;
  bool plain_difference;  ///< the source's estimator: the reference as it is
  const Lag& lag;
  double reference_late_sd = 0.0;  ///< [s] of what the lines of the reference are corrected for
  Doubt doubt = {};
};

/// Errors of the rig: the estimator on what the rig with the error would make an instrument of these terms show, less
/// the estimator without the error.
std::vector<Effect> rig_effects(const Circumstances& around, const std::vector<Observation>& observations,
                                const std::vector<RigLinesShift>& shifts, const std::vector<std::size_t>& cell_of,
                                const std::vector<RigLines>& nominal, const std::vector<const Spin*>& cells);

/// A lag of the capture loop of so many seconds [s] beyond what is known of it, docs/equations (1.17).
Effect lag_effect(const Circumstances& around, const std::vector<Observation>& observations, double seconds);

/// Azimuth of the reference gyro that a second of lag feigns [rad/s]: the line of the Earth's rate lags too.
double azimuth_of_lag(const Circumstances& around, const std::vector<Observation>& observations);

/// Reference gyro (gain, azimuth, clock, its own sensitivity), scale factor, lag and droop of the loop.
std::vector<Effect> instrument_effects(const Circumstances& around, const std::vector<Observation>& observations);

inline constexpr const char* relation_source = "gain and azimuth of the reference gyro";
inline constexpr const char* lag_source = "lag of the loop";

}  // namespace tumble::dtg_centrifuge
