#include "tumble/formats/csv/number.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <string>

namespace tumble::csv {
namespace {

/// The text with room around it, as the block reader gives it.
struct Padded {
  std::string bytes;
  explicit Padded(const std::string& text, char filler = ',')
      : bytes(std::string(number_padding, filler) + text + std::string(number_padding, filler)) {}
  const char* begin() const { return bytes.data() + number_padding; }
};

void expect_exact(const std::string& text) {
  for (const char filler : {',', '7', '.', '-', '\n'}) {  // what stands before a number must not matter
    Padded padded(text, filler);
    padded.bytes[number_padding + text.size()] = ',';
    double value = 0.0;
    int exponent = 0;
    const char* end = parse_number(padded.begin(), '.', value, exponent);
    if (end == nullptr) continue;  // left to slower code, which is right as well
    EXPECT_EQ(end, padded.begin() + text.size()) << text;
    EXPECT_EQ(std::bit_cast<std::uint64_t>(value), std::bit_cast<std::uint64_t>(std::strtod(text.c_str(), nullptr)))
        << text;
  }
}

bool taken(const std::string& text) {
  const Padded padded(text);
  double value = 0.0;
  int exponent = 0;
  return parse_number(padded.begin(), '.', value, exponent) != nullptr;
}

TEST(CsvNumber, HandPickedAreExact) {
  for (const char* text : {"0",
                           "-0",
                           "1",
                           "-1",
                           "0.1",
                           ".5",
                           "-.5",
                           "5.",
                           "9007199254740993",
                           "9007199254740992",
                           "18446744073709551615",
                           "1844674407370955161",
                           "123456789012345678",
                           "0.00000000000000012345678901234567",
                           "1e22",
                           "1e23",
                           "1e-22",
                           "4.9e-324",
                           "2.2250738585072011e-308",
                           "1.7976931348623157e308",
                           "0.30000000000000004",
                           "9.81E0",
                           "9.81e+00",
                           "12345678.87654321",
                           "1234567812345678",
                           "12345678123456.78",
                           "0.500000000000000166533453693773481063544750213",
                           "179769313486231580793e289",
                           "00000000000000000000001.5",
                           "1000000000000000128",
                           "8.5e15"})
    expect_exact(text);
}

TEST(CsvNumber, WhatInstrumentsWriteIsTakenAtOnce) {
  for (const char* text : {"0.0025", "-13.358877581", "9.812161820167221", "0.021040903733210017", "-32768", "1e-05",
                           "0.00021040903733210017", "1611234567.123456"})
    EXPECT_TRUE(taken(text)) << text;
}

TEST(CsvNumber, WhatIsNoNumberIsNot) {
  for (const char* text : {"", "-", ".", "-.", "e5", "abc", "--1", "+1", "1e", "1e+", "nan", "inf", "1e999", " 1"})
    EXPECT_FALSE(taken(text)) << text;
}

TEST(CsvNumber, ExponentOfTheLastDigit) {
  double value = 0.0;
  int exponent = 0;
  parse_number(Padded("12.345").begin(), '.', value, exponent);
  EXPECT_EQ(exponent, -3);
  parse_number(Padded("12").begin(), '.', value, exponent);
  EXPECT_EQ(exponent, 0);
  parse_number(Padded("1.5e-3").begin(), '.', value, exponent);
  EXPECT_EQ(exponent, -4);
  parse_number(Padded("1,5").begin(), ',', value, exponent);
  EXPECT_EQ(exponent, -1);
  EXPECT_EQ(value, 1.5);
}

TEST(CsvNumber, RandomDoublesInEveryPrecision) {
  std::mt19937_64 random(20240611);
  for (int i = 0; i < 200000; ++i) {
    double value = std::bit_cast<double>(random());
    if (!std::isfinite(value)) continue;
    if (i % 2 == 0) value = std::ldexp(value, -std::ilogb(value) % 60);
    const int digits = 1 + static_cast<int>(random() % 20);
    expect_exact(i % 3 == 0 ? fmt::format("{:.{}g}", value, digits)
                            : fmt::format("{:.{}f}", std::fmod(value, 1e9), digits - 1));
  }
}

TEST(CsvNumber, BothWaysOfTakingDigitsAgree) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 200000; ++i) {
    std::string text;
    for (std::size_t length = random() % 40; text.size() < length;) text += "0123456789012345678900.,-e"[random() % 26];
    const Padded padded(text);
    const auto fast = detail::take_decimal(padded.begin(), false, '.');
    const auto portable = detail::take_decimal_portably(padded.begin(), '.');
    if (fast.end == nullptr || portable.end == nullptr) continue;
    EXPECT_EQ(fast.end, portable.end) << text;
    EXPECT_EQ(fast.mantissa, portable.mantissa) << text;
    EXPECT_EQ(fast.fraction, portable.fraction) << text;
  }
}

}  // namespace
}  // namespace tumble::csv
