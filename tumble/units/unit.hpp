#pragma once

#include <array>
#include <string>
#include <string_view>

namespace tumble {

/// Exponents of the base units, in halves (so that 1/sqrt(h) is exact). Angle and count are dimensions of their own:
/// `deg/h` is not `1/s`, and a pulse is not a radian.
struct Dimension {
  enum Base { metre, kilogram, second, ampere, kelvin, radian, count, bases };
  std::array<signed char, bases> halves{};
  bool operator==(const Dimension&) const = default;
};

/// A unit known at run time: how users write it, its dimension, and its size in SI (value_si = value * factor +
/// offset).
///
/// Accepts products, quotients, integer and half powers, parentheses, sqrt(), SI prefixes, and the field's own units:
///   deg/h  deg/sqrt(h)  ug/g^2  pulse/(m/s)  ppm  arcsec  (m/s^2)/sqrt(Hz)  degC  mA/g  deg/h/g  deg/h^1.5
///   °/√h  m/s²  m·s  µrad  h^(1/2)  m/s2
/// The words stand in words.cpp, the grammar in parse.cpp. A text that could be read in two ways is read so:
///   deg/h/g   from left to right: (deg/h)/g
///   h min     hour and minute; `m` is metre, and milli only before a unit that takes it
///   g mg ug   standard gravity, 9.80665 m/s^2, and parts of it; `kg` is kilogram, grams are not known
///   degC degF alone an absolute temperature (degC: offset 273.15 K), inside a product or power an interval
///   pulse count LSB bit   one dimension, the count
///   G C dB    refused with what to write instead
/// `factor` is the double nearest to the exact definition (deg = pi/180, g = 9.80665 m/s^2), rounded once.
class Unit {
 public:
  Unit() = default;  ///< "1", dimensionless

  /// Throws Error::bad_input that names the word not understood, its position and what would be accepted.
  static Unit parse(std::string_view text);

  const std::string& text() const { return text_; }  ///< as written; parse(text()) gives this unit again
  const Dimension& dimension() const { return dimension_; }
  double factor() const { return factor_; }  ///< [SI] units per this unit
  double offset() const { return offset_; }  ///< [SI] value of zero in this unit (degC: 273.15)

  /// A value [this unit] in [SI], and back.
  double to_si(double value) const { return value * factor_ + offset_; }
  double from_si(double value) const { return (value - offset_) / factor_; }
  /// Differences, standard deviations and intervals [this unit] in [SI], and back: the factor alone.
  double difference_to_si(double value) const { return value * factor_; }
  double difference_from_si(double value) const { return value / factor_; }

  /// Two units are equal if their texts are.
  bool operator==(const Unit& other) const { return text_ == other.text_; }

 private:
  std::string text_ = "1";
  Dimension dimension_{};
  double factor_ = 1.0;
  double offset_ = 0.0;
};

/// The dimension in SI base units, for messages: "rad/s", "m/s^2", "1".
std::string name(const Dimension& dimension);

/// A number with its unit as users write it: "254 deg/s", "-20 degC", "400 m", "0.5".
struct Quantity {
  double value = 0.0;  ///< in `unit`
  Unit unit;
  bool bare = false;  ///< no unit was written
};

/// Throws Error::bad_input: not a number, or a unit that cannot be read.
Quantity parse_quantity(std::string_view text);

/// Value [SI] of `text`, which must have the dimension of `expected`. An `expected` of degC asks for an absolute
/// temperature; one of K (or any unit without offset) for a difference, so that "0.1 degC" is then 0.1 K.
/// A bare number is accepted only where `expected` is 1 (a bare 300 where ppm are shown could mean either).
/// Throws Error::bad_input.
double parse_si(std::string_view text, const Unit& expected);

/// `value_si` [SI] in `unit` for people and files, without the unit: the shortest decimal that converts back to the
/// same value, bit for bit. A value that no double times the factor gives is written to 17 digits. "nan", "inf",
/// "-inf".
std::string format_in(double value_si, const Unit& unit);

/// A value [unit] in [SI], a shorthand for code: si(0.02, "deg/h").
double si(double value, std::string_view unit);

}  // namespace tumble
