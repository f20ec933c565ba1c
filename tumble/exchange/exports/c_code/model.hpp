#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tumble/exchange/calibration.hpp"

/// A calibration as C99 without libm and malloc.
namespace tumble::c_code {

enum class Number { double_precision, single_precision, fixed };

/// Settings that both kinds of code need.
struct Plan {
  std::string name;  ///< of the function, "tumble_compensate"
  Number number = Number::double_precision;
  int force_passes = 0, rate_passes = 0;  ///< of the iteration that inverts the curves; 0: no curves
};

/// Passes after which u = inv(K)(y - q(u)) has converged to `rounding` [1] over the range of a triad.
/// Throws    Error::bad_input where the curves are so steep that it does not converge
int passes_of(const TriadCalibration& triad, const char* what, double rounding);

/// Least e [1] with 2^e >= value [1]; of what is not above 1e-30 that of 1e-30.
int exponent_above(double value);

/// d = T - T_r is limited to 2^e [K] on both sides, which holds the temperatures of the calibration. Returned e [1].
int temperature_exponent(const ImuCalibration& calibration);

/// The curve of an axis is that of the calibration to 2^e [u], at least a tenth beyond its range, and a constant
/// beyond: a power of an output that nobody calibrated would outgrow the output itself. Returned e [1].
int curve_exponent(const TriadCalibration& triad, std::size_t axis);

/// Whether a part is in the calibration.
bool has_curve(const TriadCalibration& triad);
bool has_terms(const TriadCalibration& triad);  ///< of the curve: powers, magnitude, signed square
/// Points of the longest table of departures of its axes; 0: no table.
std::size_t table_points(const TriadCalibration& triad);

/// Tables of three axes, all as long as the longest.
struct TableRows {
  std::vector<std::size_t> points;                 ///< that count
  std::vector<std::vector<double>> at, departure;  ///< [u], [output]
  std::vector<std::vector<double>> slope;          ///< [output/u] up to each point; the first is not used
};
TableRows table_rows(const TriadCalibration& triad);
bool has_temperature(const TriadCalibration& triad);
bool has_temperature(const ImuCalibration& calibration);

/// `text` with every key replaced by its value.
std::string filled(std::string text, const std::vector<std::pair<std::string, std::string>>& values);

/// 32 outputs over the range and the temperatures of a calibration, and the inputs that belong to them.
struct TestVector {
  ImuSample outputs, inputs;
};
std::vector<TestVector> test_vectors(const ImuCalibration& calibration);

/// The file for floating point: declarations, function and, under TUMBLE_CAL_TEST, a main that compares test vectors.
std::string floating_point(const ImuCalibration& calibration, const Plan& plan);
/// The file for 32-bit integers, whose formats follow from the ranges; it states its greatest rounding error.
std::string fixed_point(const ImuCalibration& calibration, const Plan& plan);

}  // namespace tumble::c_code
