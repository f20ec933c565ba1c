#pragma once

#include <array>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/math/matrix3.hpp"
#include "tumble/units/unit.hpp"

/// A calibration of three gyros and three accelerometers that does not depend on the method that found it or on the
/// software that will use it.
namespace tumble {

/// Noise of one axis. NaN: the result does not state it.
struct AxisNoise {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  double rate = none;         ///< [Hz] of the record that gave the noise
  double white = none;        ///< N [u sqrt(s)]: N^2 is the two-sided power spectral density
  double walk = none;         ///< K [u/sqrt(s)]: the variance grows by K^2 in each second
  double instability = none;  ///< B [u], which is not K
  double markov_sd = none;    ///< [u] standard deviation of a first-order Gauss-Markov bias
  double markov_time = none;  ///< [s] its correlation time
  double walk_limit = none;   ///< [u/sqrt(s)] 95 % limit of K where the data do not show it
};

/// Departures at some inputs: straight between them, constant beyond the first and the last.
struct DepartureTable {
  std::vector<double> at;         ///< [u] inputs, rising
  std::vector<double> departure;  ///< [output]

  double operator()(double u) const;  ///< [output] for u [SI]; 0 without points
  double steepest() const;            ///< [output/u] greatest |slope|
};

/// How one output departs from a straight line, as a function of its own input u: p_2 u^2 + ... + p_5 u^5 + m |u| +
/// s u |u| + table(u), in units of the output.
struct OwnCurve {
  std::array<double, 4> power{};  ///< p_2 to p_5
  double magnitude = 0.0;         ///< m
  double signed_square = 0.0;     ///< s
  DepartureTable table = {};

  bool is_zero() const;
  double operator()(double u) const;  ///< [output] for u [SI]
};

/// Change of one axis with d = T - T_r [K]. All three polynomials begin with the power 1 of d.
struct AxisThermal {
  std::vector<double> output;  ///< t(d) [output]: subtracted from the output before everything else
  std::vector<double> scale;   ///< c(d) [1], and
  std::vector<double> bias;    ///< e(d) [u]: u = (1 + c) u_r - e, with u_r from the terms at T_r
};

/// A straight line and the departures from it as they were measured: in place of a response, a bias and a curve.
struct MeasuredLine {
  double slope = 0.0;  ///< [output/u]
  double bias = 0.0;   ///< [output]
  DepartureTable departures;
};

/// sum_k a_k d^k, k = 1, 2, ...: [u] for coefficients [u/K^k] and d [K].
double polynomial_without_constant(const std::vector<double>& coefficients, double d);
/// The polynomial sum_k a_k x^k [u] in powers of x - at: b_k [u/x^k] with sum_k b_k (x - at)^k.
std::vector<double> shifted_polynomial(std::vector<double> coefficients, double at);

/// Three axes of one kind:
///
///   y - t(d) = b + K u_r + G f + q(u_r) + [lever effect],   u = (1 + c(d)) u_r - e(d)
///
/// with y the outputs, u the inputs in instrument axes and f the specific force, which the gyros feel too.
struct TriadCalibration {
  bool calibrated = false;     ///< the results hold a deterministic model of it
  std::array<bool, 3> axes{};  ///< the axes that they hold
  Unit output;                 ///< of y as the model takes it; where it is the unit of u, K is near the identity
  std::string reading;  ///< how y comes from the recorded channel where it is not the channel itself; empty: as it is
  Matrix3 response = identity3();             ///< K [output/u]
  Vector3 bias;                               ///< b [output]
  Matrix3 by_force;                           ///< G [output/(m/s^2)], gyros only
  std::array<OwnCurve, 3> curve;              ///< q
  std::array<MeasuredLine, 3> measured = {};  ///< see take_measured(); without points: the results have none
  Matrix3 lever;                              ///< [m] row i: position of accelerometer i from the reference point
  std::array<AxisThermal, 3> thermal;
  std::array<AxisNoise, 3> noise;
  Vector3 transient;  ///< [u] size of what gradients, changing temperature and switching on add: at 1 K and 1 K/min
  Vector3 range;      ///< [u] greatest input that the calibration covers; 0: the results do not state it

  bool has_noise() const;
};

/// A file that a calibration was made from.
struct CalibrationSource {
  std::string file, sha256, method, title;
};

/// Parameters and their covariance, as one of the results has them.
struct ParameterBlock {
  std::vector<std::string> names;
  std::vector<Unit> units;     ///< as shown
  std::vector<double> values;  ///< [SI]
  Matrix covariance;           ///< [SI]
};

struct ImuCalibration {
  TriadCalibration accelerometers, gyros;
  double reference_temperature = AxisNoise::none;               ///< T_r [K]
  double coldest = AxisNoise::none, hottest = AxisNoise::none;  ///< [K] that the calibration covers
  std::string title, model, serial, date;                       ///< date of the test: empty where no result has it
  std::vector<CalibrationSource> sources;
  std::vector<ParameterBlock> parameters;  ///< one for each source
  std::vector<std::string> notes;          ///< what a reader must know: terms that could not be placed, for example
};

/// One result among those that make a calibration.
struct CalibrationInput {
  Estimate estimate;
  std::string file, sha256;
  std::string axis = {};  ///< "gyro_y": of a result of a single sensor, the axis that it is; empty: x
};

/// The calibration that these results hold together: their error models, and the noise that they state by channel.
/// Terms for which a calibration has no place are named in its notes.
///
/// Throws    Error::bad_input where a result holds nothing of the kind or two results state one thing
ImuCalibration calibration_of(const std::vector<CalibrationInput>& results);

/// Outputs or inputs at one instant.
struct ImuSample {
  Vector3 force;                 ///< accelerometers [output] or specific force [m/s^2]
  Vector3 rate;                  ///< gyros [output] or angular rate [rad/s]
  double temperature = 293.15;   ///< [K]
  Vector3 angular_acceleration;  ///< [rad/s^2]
};

/// Outputs [output] of a unit with this calibration that feels `truth` [SI].
ImuSample outputs_of(const ImuCalibration& calibration, const ImuSample& truth);
/// Inputs [SI] from outputs [output]: the inverse of outputs_of, to 1e-15 of the input. The angular acceleration is
/// taken from `outputs`.
ImuSample compensated(const ImuCalibration& calibration, const ImuSample& outputs);

/// Replaces K, b and q of every axis that has measured departures by these. False: no axis has any.
bool take_measured(TriadCalibration& triad);

/// A part of a calibration that consumers carry or do not, and that can be dropped.
struct CalibrationTerm {
  const char* name;         ///< "gyro_misalignment"
  const char* description;  ///< for people
  bool gyro;                ///< it belongs to the gyros, else to the accelerometers
  bool (*is_in)(const ImuCalibration& calibration);
  void (*remove)(ImuCalibration& calibration);
};
const std::vector<CalibrationTerm>& calibration_terms();
/// Throws Error::bad_input with the nearest known name.
const CalibrationTerm& find_calibration_term(std::string_view name);

/// The greatest error [SI of the input] that remains on any axis if a term is omitted: over the corners, edges and
/// middles of the range of inputs and temperatures of the calibration, at constant rates.
double error_without(const ImuCalibration& calibration, const CalibrationTerm& term);

/// Where a calibration has no range: 1 g and 100 deg/s, which these set in place.
void set_missing_ranges(ImuCalibration& calibration);

}  // namespace tumble
