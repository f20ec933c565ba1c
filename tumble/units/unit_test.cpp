#include "tumble/units/unit.hpp"

#include <gtest/gtest.h>

#include <charconv>
#include <cmath>
#include <random>
#include <vector>

#include "tumble/units/nearest.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

double factor(std::string_view text) { return Unit::parse(text).factor(); }
std::string dimension(std::string_view text) { return name(Unit::parse(text).dimension()); }

/// Whether the text is refused as a unit, for a reason with these values or, where it has none, this pattern.
::testing::AssertionResult refuses_unit(std::string_view text, const Asked& asked = {}) {
  return refuses(Error::Kind::bad_input, asked, [&] { Unit::parse(text); });
}

const std::vector<std::string> samples{"1",
                                       "deg/h",
                                       "deg/sqrt(h)",
                                       "ug/g^2",
                                       "pulse/(m/s)",
                                       "ppm",
                                       "arcsec",
                                       "(m/s^2)/sqrt(Hz)",
                                       "degC",
                                       "mA/g",
                                       "deg/h/g",
                                       "deg/h^1.5",
                                       "ppm/degC",
                                       "°/√h",
                                       "µg/√Hz",
                                       "m/s²",
                                       "kg·m²",
                                       "rpm",
                                       "%",
                                       "LSB",
                                       "mrad",
                                       "hPa",
                                       "deg/h/g^2",
                                       "count",
                                       "pulse/arcsec",
                                       "1/s",
                                       "degF",
                                       "us",
                                       "min",
                                       "T",
                                       "mgauss",
                                       "V/(rad/s)",
                                       "rev/min",
                                       "K/min",
                                       "deg/h^2",
                                       "kHz"};

TEST(Unit, FactorsAreTheNearestDoubles) {
  // Decimal expansions to 25 digits, from pi = 3.14159265358979323846264338.
  EXPECT_EQ(factor("deg"), 0.01745329251994329576923691);
  EXPECT_EQ(factor("deg/h"), 4.848136811095359935899141e-6);
  EXPECT_EQ(factor("arcsec"), 4.848136811095359935899141e-6);
  EXPECT_EQ(factor("arcsec/s"), factor("deg/h"));
  EXPECT_EQ(factor("deg/sqrt(h)"), 2.908882086657215961539485e-4);
  EXPECT_EQ(factor("deg/h^1.5"), 8.080228018492266559831902e-8);
  EXPECT_EQ(factor("g"), 9.80665);
  EXPECT_EQ(factor("ug"), 9.80665e-6);
  EXPECT_EQ(factor("mg"), 9.80665e-3);
  EXPECT_EQ(factor("h"), 3600.0);
  EXPECT_EQ(factor("day"), 86400.0);
  EXPECT_EQ(factor("ppm"), 1e-6);
  EXPECT_EQ(factor("ppb"), 1e-9);
  EXPECT_EQ(factor("%"), 0.01);
  EXPECT_EQ(factor("km/h"), 1.0 / 3.6);
  EXPECT_EQ(factor("mm"), 1e-3);
  EXPECT_EQ(factor("ns"), 1e-9);
  EXPECT_EQ(factor("sqrt(Hz)"), 1.0);
  EXPECT_EQ(factor("1/sqrt(min)"), 0.1290994448735805628393088);
}

TEST(Unit, DimensionsOfTheField) {
  EXPECT_EQ(dimension("deg/h"), "rad/s");
  EXPECT_EQ(dimension("deg/sqrt(h)"), "rad/s^0.5");
  EXPECT_EQ(dimension("deg/h^1.5"), "rad/s^1.5");
  EXPECT_EQ(dimension("(m/s^2)/sqrt(Hz)"), "m/s^1.5");
  EXPECT_EQ(dimension("ug/sqrt(Hz)"), "m/s^1.5");
  EXPECT_EQ(dimension("deg/h/g"), "s*rad/m");
  EXPECT_EQ(dimension("ug/g^2"), "s^2/m");
  EXPECT_EQ(dimension("pulse/(m/s)"), "s*count/m");
  EXPECT_EQ(dimension("ppm"), "1");
  EXPECT_EQ(dimension("Hz"), "1/s");
  EXPECT_EQ(dimension("V"), "m^2*kg/(s^3*A)");
  EXPECT_EQ(dimension("ohm"), "m^2*kg/(s^3*A^2)");
  EXPECT_EQ(dimension("J"), dimension("N*m"));
  EXPECT_EQ(dimension("W"), dimension("V*A"));
  EXPECT_EQ(dimension("Pa"), dimension("N/m^2"));
  EXPECT_EQ(dimension("T"), dimension("V*s/m^2"));
  for (const char* word : {"pulse", "count", "LSB", "bit"}) EXPECT_EQ(dimension(word), "count");
  EXPECT_NE(dimension("rad/s"), dimension("Hz"));
}

TEST(Unit, AmbiguousWordsAreReadAsDocumented) {
  EXPECT_EQ(factor("min"), 60.0);
  EXPECT_EQ(dimension("min"), "s");
  EXPECT_EQ(dimension("m"), "m");
  EXPECT_EQ(dimension("mg"), "m/s^2");
  EXPECT_EQ(dimension("kg"), "kg");
  EXPECT_EQ(factor("deg/h/g"), factor("(deg/h)/g"));
  EXPECT_EQ(factor("deg/h/g"), factor("deg/(h*g)"));
  EXPECT_NE(factor("deg/h/g"), factor("deg/(h/g)"));
  EXPECT_EQ(dimension("Pa"), dimension("hPa"));  // hecto before a unit, hour alone
  EXPECT_EQ(factor("hPa"), 100.0);
  EXPECT_EQ(dimension("mT"), dimension("T"));
  EXPECT_EQ(factor("mm*min"), 0.06);
}

TEST(Unit, SpellingsOfTheSame) {
  const auto same = [](std::string_view a, std::string_view b) {
    const Unit x = Unit::parse(a), y = Unit::parse(b);
    EXPECT_EQ(x.factor(), y.factor()) << a << " " << b;
    EXPECT_EQ(x.dimension(), y.dimension()) << a << " " << b;
    EXPECT_EQ(x.offset(), y.offset()) << a << " " << b;
  };
  same("°/√h", "deg/sqrt(h)");
  same("deg/h^(1/2)", "deg/sqrt(h)");
  same("deg/h^0.5", "deg/sqrt(h)");
  same("deg*h^-0.5", "deg/sqrt(h)");
  same("deg/h^(3/2)", "deg/h^1.5");
  same("µg", "ug");  // micro sign
  same("μg", "ug");  // Greek letter
  same("m/s²", "m/s^2");
  same("m/s2", "m/s^2");
  same("m/s**2", "m/s^2");
  same("kg·m²", "kg*m^2");
  same(" deg / h ", "deg/h");
  same("°C", "degC");
  same("(m^4)^0.5", "m^2");
  same("sqrt(m^2/s)", "m/sqrt(s)");
  same("1/s", "Hz");
  same("kΩ", "kohm");
  same("m^2.0", "m^2");
}

TEST(Unit, UnitsAsPeopleWriteThem) {
  const auto same_unit = [](std::string_view written, std::string_view ours) {
    const Unit a = Unit::parse(written), b = Unit::parse(ours);
    EXPECT_EQ(a.dimension(), b.dimension()) << written;
    EXPECT_EQ(a.factor(), b.factor()) << written;
    EXPECT_EQ(a.offset(), b.offset()) << written;
  };
  same_unit("℃", "degC");
  same_unit("ºC", "degC");
  same_unit("celsius", "degC");
  same_unit("℉", "degF");
  same_unit("kelvin", "K");
  same_unit("degrees/hour", "deg/h");
  same_unit("º/second", "deg/s");
  same_unit("°/s/√Hz", "deg/s/sqrt(Hz)");
  same_unit("radians/sec", "rad/s");
  same_unit("milliseconds", "ms");
  same_unit("毫秒", "ms");
  same_unit("usec", "us");
  same_unit("nanosecond", "ns");
  same_unit("counts/seconds", "LSB/s");
  same_unit("pulses", "pulse");
  same_unit("m·s⁻²", "m/s^2");
  same_unit("rad·s⁻¹", "rad/s");
}

TEST(Unit, TemperatureAloneIsAbsoluteAndInsideAnInterval) {
  EXPECT_EQ(Unit::parse("degC").offset(), 273.15);
  EXPECT_EQ(Unit::parse("degC").to_si(20.0), 293.15);
  EXPECT_EQ(Unit::parse("degC").difference_to_si(0.5), 0.5);
  EXPECT_EQ(Unit::parse("ppm/degC").offset(), 0.0);
  EXPECT_EQ(Unit::parse("degC/min").offset(), 0.0);
  EXPECT_EQ(Unit::parse("degC^2").offset(), 0.0);
  EXPECT_NEAR(Unit::parse("degF").to_si(212.0), 373.15, 1e-12);  // a few ulp of 373
}

TEST(Unit, TextRoundTripsExactly) {
  for (const auto& text : samples) {
    const Unit unit = Unit::parse(text), again = Unit::parse(unit.text());
    EXPECT_EQ(unit.text(), text);
    EXPECT_TRUE(unit == again);
    EXPECT_EQ(unit.factor(), again.factor());
    EXPECT_EQ(Unit::parse(name(unit.dimension())).dimension(), unit.dimension()) << text;
  }
}

TEST(Unit, RefusalsNameTheWordItsPositionAndTheNearest) {
  EXPECT_TRUE(refuses_unit("dge/h", {.values = {"dge/h", "1", "dge", "deg"}}));
  EXPECT_TRUE(refuses_unit("°/huor", {.values = {"°/huor", "3", "huor", "hour"}}));
  EXPECT_TRUE(refuses_unit("Deg/h", {.values = {"Deg/h", "1", "Deg", "deg"}}));
  EXPECT_TRUE(refuses_unit("dB", {.values = {"dB", "1", "dB"}, .pattern = "logarithm"}));
  EXPECT_TRUE(refuses_unit("mg/C", {.values = {"mg/C", "4", "C"}, .pattern = "degC"}));
  EXPECT_TRUE(refuses_unit("", {.values = {"", "1"}, .pattern = "write 1"}));
  EXPECT_TRUE(refuses_unit("(deg/h", {.values = {"(deg/h", "1"}, .pattern = "'('"}));
  EXPECT_TRUE(refuses_unit("deg)/h", {.values = {"deg)/h", "4"}, .pattern = "')'"}));
  EXPECT_TRUE(refuses_unit("N m", {.values = {"N m", "3", "m"}}));
  for (const char* part : {"m^(1/3)", "m^0.25", "sqrt(sqrt(m))"})
    EXPECT_TRUE(refuses_unit(part, {.values = {part}, .pattern = "whole halves"})) << part;
  for (const char* zero : {"g0", "m^0", "m^(0/2)"})
    EXPECT_TRUE(refuses_unit(zero, {.values = {zero}, .pattern = "power of 0"})) << zero;
  EXPECT_TRUE(refuses_unit("3*m", {.values = {"3*m", "1"}, .pattern = "only number"}));
  for (const char* bad :
       {"deg/", "/h",       "deg//h", "m^",  "m^x",     "*",    "^2",     "m^99", "((m^60)^60)", "mkg", "kmin", "m^2^2",
        "kkg",  "\xff\xfe", "m/s22",  "m^-", "m^(1/0)", "sqrt", "sqrt()", "()",   "deg\n/h",     "1.",  "11"})
    EXPECT_TRUE(refuses_unit(bad, {.values = {bad}})) << bad;
  EXPECT_TRUE(refuses_unit(std::string(150, '('), {.pattern = "parentheses"}));
  EXPECT_TRUE(refuses_unit(std::string(100000, 'm'), {.pattern = "200 characters"}));
  EXPECT_TRUE(refuses_unit("Tm^30*Tm^30", {.values = {"Tm^30*Tm^30"}, .pattern = "too great"}));
}

TEST(Quantity, NumberAndUnit) {
  EXPECT_EQ(parse_quantity("254 deg/s").value, 254.0);
  EXPECT_EQ(parse_quantity("254deg/s").unit.text(), "deg/s");
  EXPECT_EQ(parse_quantity(" -20 degC ").value, -20.0);
  EXPECT_EQ(parse_quantity("+1e-3 m").value, 1e-3);
  EXPECT_TRUE(parse_quantity("0.5").bare);
  EXPECT_FALSE(parse_quantity("5 ppm").bare);
  for (const char* bad : {"", "deg", "nan deg", "inf m", "1,5 m", "1e999 m", "--1 m"})
    EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {bad}}, [&] { parse_quantity(bad); })) << bad;
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "comma"}, [] { parse_quantity("1,5 m"); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "out of range"}, [] { parse_quantity("1e999 m"); }));
  // The number is read; the unit is wrong.
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"m m"}}, [] { parse_quantity("1 m m"); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"x10 m"}}, [] { parse_quantity("0x10 m"); }));
}

TEST(Quantity, InSiWithTheExpectedDimension) {
  const Unit rate = Unit::parse("deg/h"), absolute = Unit::parse("degC"), difference = Unit::parse("K"), ratio;
  EXPECT_EQ(parse_si("1 deg/h", rate), 4.848136811095359935899141e-6);
  EXPECT_EQ(parse_si("20 degC", absolute), 293.15);
  EXPECT_EQ(parse_si("293.15 K", absolute), 293.15);
  EXPECT_EQ(parse_si("0.1 degC", difference), 0.1);
  EXPECT_EQ(parse_si("0.1 K", difference), 0.1);
  EXPECT_EQ(parse_si("0.5", ratio), 0.5);
  EXPECT_EQ(parse_si("50 %", ratio), 0.5);
  EXPECT_EQ(parse_si("5 ppm", Unit::parse("ppm")), 5 * 1e-6);
  const auto asks = [](const char* given, const Unit& expected, std::vector<std::string> values) {
    return refuses(Error::Kind::bad_input, Asked{.values = std::move(values)}, [&] { parse_si(given, expected); });
  };
  EXPECT_TRUE(asks("5", Unit::parse("ppm"), {"5", "5", "ppm"}));
  EXPECT_TRUE(asks("100", rate, {"100", "100", "deg/h"}));
  EXPECT_TRUE(asks("1 m", rate, {"1 m", "m", "deg/h", "rad/s"}));
  EXPECT_EQ(si(0.02, "deg/h"), 0.02 * factor("deg/h"));
}

TEST(Format, SayingsForPeople) {
  EXPECT_EQ(format_in(si(0.02, "deg/h"), Unit::parse("deg/h")), "0.02");
  EXPECT_EQ(format_in(293.15, Unit::parse("degC")), "20");
  EXPECT_EQ(format_in(Unit::parse("degC").to_si(20.1), Unit::parse("degC")), "20.1");
  EXPECT_EQ(format_in(Unit::parse("degC").to_si(-0.0625), Unit::parse("degC")), "-0.0625");
  EXPECT_EQ(format_in(si(100000, "ug"), Unit::parse("ug")), "100000");
  EXPECT_EQ(format_in(0.0, Unit::parse("deg/h")), "0");
  EXPECT_EQ(format_in(NAN, Unit{}), "nan");
}

// A decimal of at most 15 digits, in any unit: what format_in() writes converts back to the same double.
TEST(Format, DecimalsReturnBitForBit) {
  std::mt19937_64 random(20240601);
  std::uniform_int_distribution<long> mantissa(-999'999'999'999'999, 999'999'999'999'999);
  std::uniform_int_distribution<int> digits(1, 15), exponent(-20, 20);
  for (const auto& text : samples) {
    const Unit unit = Unit::parse(text);
    for (int i = 0; i < 4000; ++i) {
      const long shortened = mantissa(random) / static_cast<long>(std::pow(10.0, 15 - digits(random)));
      const std::string decimal = std::to_string(shortened) + "e" + std::to_string(exponent(random));
      double value = 0.0;
      std::from_chars(decimal.data(), decimal.data() + decimal.size(), value);
      const std::string written = format_in(unit.to_si(value), unit);
      double read = 0.0;
      std::from_chars(written.data(), written.data() + written.size(), read);
      ASSERT_EQ(unit.to_si(read), unit.to_si(value)) << decimal << " " << text << " written " << written;
      if (unit.offset() == 0.0) {
        ASSERT_EQ(read, value) << decimal << " " << text << " written " << written;
      }
    }
  }
}

TEST(Nearest, SlipsOfTheFingers) {
  const std::vector<std::string> known{"temperature", "rate", "gravity"};
  EXPECT_EQ(nearest("temprature", known), "temperature");
  EXPECT_EQ(nearest("rtae", known), "rate");
  EXPECT_EQ(nearest("Gravity", known), "gravity");
  EXPECT_EQ(nearest("voltage", known), "");
  EXPECT_EQ(nearest("bias", {"accelerometer_x_bias", "gyro_z_bias"}), "gyro_z_bias");
  EXPECT_EQ(nearest("insp", {"init", "inspect"}), "inspect");
  EXPECT_EQ(nearest("axis", {"axes", "axis_of_rotation"}), "axes");
  EXPECT_EQ(nearest("as", {"gyro_z_bias"}), "");
  EXPECT_EQ(nearest("", known), "");
  EXPECT_EQ(nearest("x", {"y"}), "");
}

}  // namespace
}  // namespace tumble
