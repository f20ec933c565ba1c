#pragma once

#include <string>
#include <vector>

#include "tumble/core/finding.hpp"
#include "tumble/core/settings.hpp"
#include "tumble/methods/dtg_centrifuge/lines.hpp"
#include "tumble/methods/dtg_centrifuge/rig_lines.hpp"

/// From lines to the sensitive term: gain and azimuth of the reference gyro, true rate subtracted, specific force.
namespace tumble::dtg_centrifuge {

/// One rate of the arm with one orientation of the spin axis.
struct Level {
  double arm_rate = 0.0, table_rate = 0.0;  ///< [rad/s] means as measured, arm positive
  double spin_up = 1.0;                     ///< +1 or -1
  double force = 0.0;                       ///< a [m/s^2], mean
  double force_along = 0.0;                 ///< f_Z [m/s^2]
  std::string label;                        ///< of the first segment at this level
  std::size_t number = 1;  ///< among the levels of the plans, also those that are missing or cannot be used
};

/// gyro line = gain e^{-i sigma azimuth} x reference line for what is fixed in the Earth, sigma = +1 spin axis up.
struct Relation {
  double log_gain = 0.0, azimuth = 0.0;  ///< ln(S_g/S_f) [1], [rad]
  double log_gain_sd = 0.0, azimuth_sd = 0.0;
  bool from_earth = true;                            ///< the Earth's rate has a part in it
  double earth_sd = 0.0;                             ///< [1] of both by the Earth's rate alone
  double earth_log_gain = 0.0, earth_azimuth = 0.0;  ///< by the Earth's rate alone
  /// E_g/E_f [1], docs/equations (1.12); spin_up [1] is sigma.
  Complex c(double spin_up) const { return std::polar(std::exp(log_gain), -spin_up * azimuth); }
};

/// A low pass behind an output, of as many equal stages: of electronics, or of a program that averages samples.
struct Filter {
  double lag = 0.0;        ///< [s] at low frequencies, of all stages
  std::size_t stages = 0;  ///< 0: none
  double step = 0.0;       ///< [s] between the samples of the program; 0: electronics
  /// Factor by which a line at the rate [rad/s] is shown.
  Complex response(double rate) const;
};

/// Lag of the capture loop of one output, beyond what the settings state and the lines are corrected for.
struct Lag {
  bool stated = true;     ///< the settings state the loop
  bool quantity = false;  ///< of the fit; otherwise it is an error of it
  bool contradicted =
      false;  ///< the levels contradict what the settings state: the lag is estimated as where they state none
  bool doubtful = false;   ///< the levels hint at it: it is not corrected for, and its size is an uncertainty
  bool of_stamps = false;  ///< both gyros have it: it is one of the stamps, and takes nothing from the amplitudes
  Filter filter = {};  ///< that has it, where it also takes from the amplitudes by much; the lines are corrected for it
  double value = 0.0;  ///< [s] that the lines are corrected for
  double sd = 0.0;     ///< [s] of it
};

/// The reference gyro's own sensitivity to specific force: Z_f = u w_t + k w_s + v a with u the tilt of the table's
/// axis, k its wobble twice a turn.
struct Sensitivity {
  Complex v;           ///< [rad/s / (m/s^2)] for the spin axis up; the conjugate with it down
  double sd = 0.0;     ///< of each part
  bool known = false;  ///< there are enough levels
};

/// The sensitive term of one level in one power-up, for one output.
struct Observation {
  std::size_t measured = 0, level = 0;
  std::size_t power_up = 0;
  Complex value;  ///< p + i q [rad/s / (m/s^2)]
  std::vector<Complex> part;
  std::vector<double> weight;  ///< of each part [s (m/s^2)^2]: over the density of the noise its inverse variance
  Complex second, third;       ///< Z_2/a^2, Z_3/a^3, turned as `value`: cosine + i sine x sigma
  std::vector<Complex> second_part, third_part;
  Complex force;      ///< F_X [m/s^2]
  Complex true_rate;  ///< V [rad/s]: what was subtracted at the table's angle
  Complex raw;        ///< Z_g [rad/s]
};

/// Levels of the test, and the lines that its rig gives without errors.
struct Reduction {
  std::vector<Level> levels;
  std::vector<std::size_t> level_of;  ///< of each measured
  std::vector<RigLines> nominal;      ///< of each measured: what the plan's rig gives
};

/// The level of the plan whose rates a segment was carried out with where that is another than its label says: labels that are
/// exchanged, or a level that was carried out twice. Sets the planned rates of its spin, with a finding.
void assign_levels(Test& test, std::vector<Measured>& measured, Findings& findings);

/// Numbers the levels: spin axis up first, then by specific force. A level of the plan that is missing keeps its number.
Reduction reduction_of(const Test& test, const std::vector<Measured>& measured);

/// From the lines at the heading, with what the settings know beforehand.
Relation relation_of(const std::vector<Measured>& measured, Signal output, const Settings& settings, bool encoders,
                     Findings& findings);

/// Errors where the lines at the heading say that a polarity is reversed, that an axis is another one than stated, or
/// that a scale factor is wrong by a fifth or more.
void check_relation(const Relation& relation, Signal output, const Settings& settings, Findings& findings);

/// Specific force along X at the table's angle [m/s^2]: centripetal and the gravity that a tilt of the table's axis
/// lets in.
Complex force_of(const RigLines& nominal, double arm_rate, Complex true_rate, double gravity);

Observation observe(const Measured& measured, const Reduction& reduction, std::size_t index, Signal output,
                    const Relation& relation, Complex sensitivity, bool phase_known);

}  // namespace tumble::dtg_centrifuge
