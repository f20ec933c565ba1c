#pragma once

#include <cstddef>
#include <string>

#include "tumble/units/sentence.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {

/// A length of time [s] for a sentence: "310 ms", "12.5 s", "86400 s".
std::string say_seconds(double seconds);
/// An instant [s] on the recording's clock for a sentence: "812.4 s", to a millisecond.
std::string say_instant(double seconds);
/// A value [SI] with its unit for a sentence: "20 degC", "0.5" where the unit is 1.
std::string say_value(double value_si, const Unit& unit);
/// A difference [SI] to three digits: "0.125 deg/h", "1.5 degC".
std::string say_difference(double difference_si, const Unit& unit);
/// "1 sample", "3 samples": the noun must take a plain s.
std::string say_count(std::size_t count, const std::string& noun);
/// As say_count(), for a sentence in two languages: in Chinese the number alone, since the counting word stands in the
/// sentence around it.
Sentence said_count(std::size_t count, const std::string& noun);
/// A size in bytes for a sentence: "1.5 GB".
std::string say_bytes(std::size_t bytes);
/// A frequency [Hz] as part of a parameter's name: "12_5Hz", "100Hz".
std::string frequency_label(double frequency);

}  // namespace tumble
