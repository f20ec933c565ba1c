#include "tumble/exchange/exports/c_code/fixed_format.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/exchange/exports/c_code/model.hpp"
#include "tumble/units/error.hpp"

namespace tumble::c_code {
namespace {

double row_sum(Vector3 row, Vector3 sizes) { return dot(absolute(row), sizes); }

/// Greatest |value| of a polynomial without a constant for |d| <= reach.
double most(const std::vector<double>& coefficients, double reach) {
  double sum = 0.0, power = reach;
  for (const double c : coefficients) sum += std::abs(c) * power, power *= reach;
  return sum;
}

/// Greatest |slope|.
double most_slope(const std::vector<double>& coefficients, double reach) {
  double sum = 0.0, power = 1.0;
  for (std::size_t k = 0; k < coefficients.size(); ++k, power *= reach)
    sum += static_cast<double>(k + 1) * std::abs(coefficients[k]) * power;
  return sum;
}

/// Greatest output of an axis over the range.
double output_limit(const TriadCalibration& t, std::size_t i, Vector3 force_range, double reach) {
  constexpr double margin = 1.1, curve = 1.3;  // curves change the output by less than their slope limit
  const double straight = row_sum(t.response[i], t.range) * curve + row_sum(t.by_force[i], force_range);
  const double thermal = 1.0 + most(t.thermal[i].scale, reach);
  return margin * (std::abs(t.bias[i]) + straight * thermal + most(t.thermal[i].output, reach) +
                   std::abs(t.response(i, i)) * most(t.thermal[i].bias, reach));
}

double largest_element(const Matrix3& m) {
  double largest = 0.0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) largest = std::max(largest, std::abs(m(i, j)));
  return largest;
}

/// Rounding error of the difference output - bias - t(d) - G f, in units of the output.
double straight_error(const TriadCalibration& t, std::size_t i, const TriadFormat& format, const ImuCalibration& c,
                      const TriadFormat* force, double reach) {
  const double step = std::ldexp(1.0, -format.output_bits - guard_bits);
  double error = 0.5 * step;
  const auto& powers = t.thermal[i].output;
  error += static_cast<double>(powers.size()) * step + most_slope(powers, reach) * std::ldexp(1.0, -kelvin_bits);
  if (force)
    error += 0.5 * step + 1.5 * std::ldexp(1.0, -format.force_bits) * 1.1 * norm(c.accelerometers.range) +
             row_sum(t.by_force[i], {force->error, force->error, force->error});
  return error;
}

/// Rounding error of the input of one axis.
double input_error(const TriadCalibration& t, std::size_t i, const TriadFormat& format, Vector3 straight, int passes,
                   double reach) {
  const double step = std::ldexp(1.0, -format.input_bits - guard_bits),
               output_step = std::ldexp(1.0, -format.output_bits - guard_bits);
  const Matrix3 inverted = inverse(t.response);
  double error =
      row_sum(inverted[i], straight) + 1.5 * std::ldexp(1.0, -format.inverse_bits) * format.output_limit + 0.5 * step;
  if (passes > 0) {  // six rounded products of a curve, the rounding of its argument; the passes shrink errors by 0.3
    const Vector3 six = (6.0 * output_step) * Vector3{1.0, 1.0, 1.0};
    error = (error + row_sum(inverted[i], six) + 4.0 * step + 1e-9 * norm(t.range)) / 0.7;
  }
  const auto &scale = t.thermal[i].scale, &bias = t.thermal[i].bias;
  const double input = 1.2 * t.range[i], kelvin = std::ldexp(1.0, -kelvin_bits);
  if (!scale.empty())
    error = error * (1.0 + most(scale, reach)) + 0.5 * step +
            input * (static_cast<double>(scale.size() + 1) * std::ldexp(1.0, -share_bits) +
                     most_slope(scale, reach) * kelvin);
  if (!bias.empty()) error += static_cast<double>(bias.size() + 1) * step + most_slope(bias, reach) * kelvin;
  return error + 0.5 * std::ldexp(1.0, -format.input_bits);
}

/// [output] Greatest of the numbers that a curve is summed from, for |u| <= reach.
double most(const OwnCurve& curve, double reach) {
  double powers = 0.0, power = reach * reach;
  for (const double p : curve.power) powers += std::abs(p) * power, power *= reach;
  return std::max({powers, std::abs(curve.magnitude) * reach, std::abs(curve.signed_square) * reach * reach});
}

/// Whether all that the code multiplies stays below 2^63: coefficients of polynomials and curves by shares up to 2^30,
/// slopes of tables by twice that, a change of the scale factor by an input up to 2^34.
bool products_fit(const TriadCalibration& t, const TriadFormat& format, double reach) {
  const int output = format.output_bits + guard_bits, input = format.input_bits + guard_bits;
  bool fit = true;
  for (const auto& axis : t.thermal)
    fit = fit && std::ldexp(most(axis.output, reach), output) < 0x1p32 &&
          std::ldexp(most(axis.bias, reach), input) < 0x1p32 && most(axis.scale, reach) < 0.25;
  for (std::size_t i = 0; i < 3; ++i) {
    const double own = std::ldexp(1.0, format.curve_exponent[i]);
    fit = fit && std::ldexp(most(t.curve[i], own), output) < 0x1.fp32 &&
          std::ldexp(t.curve[i].table.steepest() * own, output) < 0x1p31;
  }
  return fit;
}

/// Of each axis by its own range: a curve of a narrow one would grow beyond all bits over the range of a wide one.
std::array<int, 3> curve_exponents(const TriadCalibration& t, int input_bits) {
  constexpr int narrowest = 30;
  std::array<int, 3> exponents;
  const int widest = 29 - input_bits;
  for (std::size_t i = 0; i < 3; ++i) exponents[i] = std::clamp(curve_exponent(t, i), widest - narrowest, widest);
  return exponents;
}

TriadFormat format_of(const TriadCalibration& t, const ImuCalibration& c, const TriadFormat* force, int passes,
                      double reach) {
  constexpr int word = 29;
  constexpr double sum = 28.4;  // of what is limited to 2^34, below 2^62.4
  TriadFormat format;
  for (std::size_t i = 0; i < 3; ++i)
    format.output_limit = std::max(format.output_limit, output_limit(t, i, c.accelerometers.range, reach));
  const double input_limit = 1.1 * std::max({t.range.x, t.range.y, t.range.z});
  format.output_bits = word - exponent_above(format.output_limit);
  format.input_bits = word - exponent_above(input_limit);
  const Matrix3 inverted = inverse(t.response);
  double rows = 0.0;
  for (std::size_t i = 0; i < 3; ++i) rows = std::max(rows, row_sum(inverted[i], {1.0, 1.0, 1.0}));
  format.inverse_bits = static_cast<int>(std::floor(sum - std::log2(rows)));
  if (force) {
    const double by_force = largest_element(t.by_force);
    const int force_word = by_force > 0.0 ? word - exponent_above(by_force) : format.output_bits + guard_bits;
    format.force_bits = std::min(force_word, 60 + format.output_bits + guard_bits - force->input_bits);
    format.force_bits = std::max(format.force_bits, format.output_bits + guard_bits - force->input_bits + 1);
  }
  format.curve_exponent = curve_exponents(t, format.input_bits);
  const int shift = format.output_bits + format.inverse_bits - format.input_bits;
  if (!products_fit(t, format, reach) || shift < 1 || shift > 61 || format.force_bits > 61)
    throw Error(Error::Kind::bad_input,
                "the scale factors and ranges of the calibration need more bits than fixed point "
                "has: --set type=float");
  Vector3 straight;
  for (std::size_t i = 0; i < 3; ++i) straight[i] = straight_error(t, i, format, c, force, reach);
  for (std::size_t i = 0; i < 3; ++i)
    format.error = std::max(format.error, input_error(t, i, format, straight, passes, reach));
  return format;
}

}  // namespace

FixedFormat fixed_format(const ImuCalibration& c, int force_passes, int rate_passes) {
  FixedFormat format;
  double reach = 1.0;
  if (has_temperature(c)) {
    if (std::isnan(c.coldest))
      throw Error(Error::Kind::bad_input,
                  "the result does not say which temperatures it covers, which fixed point needs");
    format.temperature_bits = temperature_exponent(c);
    reach = std::ldexp(1.0, format.temperature_bits);
  }
  format.force = format_of(c.accelerometers, c, nullptr, force_passes, reach);
  format.rate = format_of(c.gyros, c, &format.force, rate_passes, reach);
  return format;
}

}  // namespace tumble::c_code
