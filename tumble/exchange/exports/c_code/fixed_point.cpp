#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "tumble/exchange/exports/c_code/fixed_format.hpp"
#include "tumble/exchange/exports/c_code/model.hpp"

namespace tumble::c_code {
namespace {

constexpr double celsius_zero = 273.15;

std::int64_t integer_of(double value, int bits) { return std::llround(std::ldexp(value, bits)); }

std::string wide(std::int64_t value) { return fmt::format("INT64_C({})", value); }

std::string list(const std::vector<double>& values, int bits) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(wide(integer_of(value, bits)));
  return fmt::format("{{{}}}", fmt::join(texts, ", "));
}

std::string array(const std::string& name, Vector3 v, int bits) {
  return fmt::format("static const int64_t {}[3] = {};\n", name, list({v.x, v.y, v.z}, bits));
}

std::string rows(const std::string& name, const std::vector<std::vector<double>>& values, int bits) {
  std::string text = fmt::format("static const int64_t {}[{}][{}] = {{\n", name, values.size(), values[0].size());
  for (std::size_t i = 0; i < values.size(); ++i)
    text += "  " + list(values[i], bits) + (i + 1 < values.size() ? ",\n" : "\n};\n");
  return text;
}

std::string square_matrix(const std::string& name, const Matrix3& m, int bits) {
  return rows(name, {{m.x.x, m.x.y, m.x.z}, {m.y.x, m.y.y, m.y.z}, {m.z.x, m.z.y, m.z.z}}, bits);
}

bool any(const TriadCalibration& t, std::vector<double> AxisThermal::*which) {
  return std::ranges::any_of(t.thermal, [&](const AxisThermal& axis) { return !(axis.*which).empty(); });
}

/// Coefficients times the powers of the reach, so that the argument is between -1 and 1.
std::string thermal_rows(const std::string& name, const TriadCalibration& t, std::vector<double> AxisThermal::*which,
                         int bits, int temperature_bits) {
  std::size_t powers = 0;
  for (const auto& axis : t.thermal) powers = std::max(powers, (axis.*which).size());
  if (powers == 0) return "";
  std::vector<std::vector<double>> values;
  for (const auto& axis : t.thermal) {
    values.push_back(axis.*which);
    values.back().resize(powers, 0.0);
    for (std::size_t k = 0; k < powers; ++k)
      values.back()[k] = std::ldexp(values.back()[k], temperature_bits * static_cast<int>(k + 1));
  }
  return fmt::format("#define {}_POWERS ({}U)\n", name, powers) + rows(name, values, bits);
}

constexpr const char* share_lookup = R"(
/* Departure of one output by its table, of a share of the range: straight between the inputs, constant beyond them. */
static int64_t KIND_by_table(uint32_t axis, int64_t x)
{
  int64_t value = KIND_departure[axis][0];
  uint32_t k;
  for (k = 1U; k < KIND_points[axis]; k++)
  {
    const int64_t into = x - KIND_at[axis][k - 1U];
    if (x >= KIND_at[axis][k])
    {
      value = KIND_departure[axis][k];
    }
    else if (into > 0)
    {
      value = KIND_departure[axis][k - 1U] + share(KIND_slope[axis][k], into);
    }
    else
    {
      /* an earlier pair of inputs holds it */
    }
  }
  return value;
}
)";

/// The table of one axis between -reach and reach [u].
DepartureTable within(const DepartureTable& table, double reach) {
  DepartureTable inner;
  const auto add = [&](double at) { inner.at.push_back(at), inner.departure.push_back(table(at)); };
  if (table.at.empty()) return inner;
  if (table.at.front() <= -reach) add(-reach);
  for (const double at : table.at)
    if (std::abs(at) < reach) add(at);
  if (table.at.back() >= reach) add(reach);
  return inner;
}

/// Inputs as shares of the reach of each axis, U = 2^exponent.
std::string lookup_rows(TriadCalibration t, const TriadFormat& format) {
  const int bits = format.output_bits + guard_bits;
  for (std::size_t i = 0; i < 3; ++i) {
    DepartureTable& table = t.curve[i].table;
    table = within(table, std::ldexp(1.0, format.curve_exponent[i]));
    for (double& at : table.at) at = std::ldexp(at, -format.curve_exponent[i]);
  }
  const TableRows of = table_rows(t);
  return fmt::format("static const uint32_t KIND_points[3] = {{{}U}};\n", fmt::join(of.points, "U, ")) +
         rows("KIND_at", of.at, share_bits) + rows("KIND_departure", of.departure, bits) +
         rows("KIND_slope", of.slope, bits) + share_lookup;
}

/// p_2 U^2 to p_5 U^5, m U and s U^2 with the U = 2^exponent of each axis.
std::string term_rows(const TriadCalibration& t, const TriadFormat& format) {
  const int bits = format.output_bits + guard_bits;
  std::vector<std::vector<double>> powers;
  Vector3 magnitude, signed_square;
  for (std::size_t i = 0; i < 3; ++i) {
    const int exponent = format.curve_exponent[i];
    powers.emplace_back();
    for (std::size_t k = 0; k < t.curve[i].power.size(); ++k)
      powers.back().push_back(std::ldexp(t.curve[i].power[k], exponent * static_cast<int>(k + 2)));
    magnitude[i] = std::ldexp(t.curve[i].magnitude, exponent);
    signed_square[i] = std::ldexp(t.curve[i].signed_square, 2 * exponent);
  }
  return rows("KIND_power", powers, bits) + array("KIND_magnitude", magnitude, bits) +
         array("KIND_signed_square", signed_square, bits) + R"(
/* Departure of one output from a straight line, of a share of the range. */
static int64_t KIND_by_terms(uint32_t axis, int64_t x)
{
  const int64_t size = (x < 0) ? (-x) : x;
  int64_t sum = KIND_power[axis][3];
  sum = share(sum, x) + KIND_power[axis][2];
  sum = share(sum, x) + KIND_power[axis][1];
  sum = share(sum, x) + KIND_power[axis][0];
  sum = share(share(sum, x), x);
  sum = sum + share(KIND_magnitude[axis], size);
  return sum + share(share(KIND_signed_square[axis], x), size);
}
)";
}

/// What an output departs from a straight line by. The input becomes a share of the reach of its axis.
std::string curve_rows(const TriadCalibration& t, const TriadFormat& format) {
  const bool terms = has_terms(t), tabled = table_points(t) > 0;
  const int all = format.input_bits + guard_bits;
  std::vector<std::string> reach, zoom;
  for (const int exponent : format.curve_exponent) {
    reach.push_back(wide(std::int64_t{1} << (all + exponent)));
    zoom.push_back(wide(std::int64_t{1} << (29 - format.input_bits - exponent)));
  }
  return (tabled ? lookup_rows(t, format) : "") + (terms ? term_rows(t, format) : "") +
         fmt::format(
             "static const int64_t KIND_reach[3] = {{{}}};\nstatic const int64_t KIND_zoom[3] = {{{}}};\n"
             "\nstatic int64_t KIND_curve(uint32_t axis, int64_t u)\n{{\n"
             "  const int64_t x = rounded(limited(u, KIND_reach[axis]) * KIND_zoom[axis], INT64_C(8));\n"
             "  return {}{}{};\n}}\n",
             fmt::join(reach, ", "), fmt::join(zoom, ", "), terms ? "KIND_by_terms(axis, x)" : "",
             terms && tabled ? " + " : "", tabled ? "KIND_by_table(axis, x)" : "");
}

std::string for_axes(const std::string& body) { return "  for (i = 0U; i < 3U; i++)\n  {\n" + body + "  }\n"; }

std::string function(const TriadCalibration& t, const TriadFormat& format, const TriadFormat* force, int passes) {
  const std::string inverse_divisor =
      wide(std::int64_t{1} << (format.output_bits + format.inverse_bits - format.input_bits));
  std::string text = fmt::format("\nstatic void KIND_compensate(const int32_t output[3]{}{}, int32_t input[3])\n{{\n",
                                 force ? ", const int32_t force[3]" : "", has_temperature(t) ? ", int64_t x" : "");
  text += "  int64_t straight[3];\n  int64_t u[3];\n" +
          std::string(passes > 0 ? "  int64_t rest[3];\n  uint32_t pass;\n" : "") + "  uint32_t i;\n\n";
  std::string first =
      fmt::format("    straight[i] = ((int64_t)output[i] * INT64_C({})) - KIND_bias[i];\n", 1 << guard_bits);
  if (any(t, &AxisThermal::output))
    first += "    straight[i] = straight[i] - polynomial(KIND_thermal_output[i], KIND_thermal_output_POWERS, x);\n";
  if (force)
    first += fmt::format(
        "    straight[i] = straight[i] - rounded(((gyro_by_force[i][0] * force[0]) + (gyro_by_force[i][1] "
        "* force[1])) +\n                                        (gyro_by_force[i][2] * force[2]), {});\n",
        wide(std::int64_t{1} << (format.force_bits + force->input_bits - format.output_bits - guard_bits)));
  text += for_axes(first) + fmt::format("  multiply(KIND_inverse, straight, {}, u);\n", inverse_divisor);
  if (passes > 0)
    text += fmt::format(
        "  for (pass = 0U; pass < {}U; pass++)\n  {{\n    for (i = 0U; i < 3U; i++)\n    {{\n"
        "      rest[i] = straight[i] - KIND_curve(i, u[i]);\n    }}\n"
        "    multiply(KIND_inverse, rest, {}, u);\n  }}\n",
        passes, inverse_divisor);
  std::string last;
  if (any(t, &AxisThermal::scale))
    last +=
        "    u[i] = u[i] + share(polynomial(KIND_thermal_scale[i], KIND_thermal_scale_POWERS, x), limited(u[i], "
        "MOST));\n";
  if (any(t, &AxisThermal::bias))
    last += "    u[i] = u[i] - polynomial(KIND_thermal_bias[i], KIND_thermal_bias_POWERS, x);\n";
  last += fmt::format("    input[i] = (int32_t)limited(rounded(u[i], INT64_C({})), INT64_C(2147483647));\n",
                      1 << guard_bits);
  return text + for_axes(last) + "}\n";
}

std::string triad(const TriadCalibration& t, const TriadFormat& format, const TriadFormat* force, int passes,
                  int temperature_bits) {
  const int bits = format.output_bits + guard_bits;
  std::string text =
      square_matrix("KIND_inverse", inverse(t.response), format.inverse_bits) + array("KIND_bias", t.bias, bits);
  if (force) text += square_matrix("gyro_by_force", t.by_force, format.force_bits);
  text += thermal_rows("KIND_thermal_output", t, &AxisThermal::output, bits, temperature_bits) +
          thermal_rows("KIND_thermal_scale", t, &AxisThermal::scale, share_bits, temperature_bits) +
          thermal_rows("KIND_thermal_bias", t, &AxisThermal::bias, format.input_bits + guard_bits, temperature_bits);
  if (passes > 0) text += curve_rows(t, format);
  return filled(text + function(t, format, force, passes), {{"KIND", force ? "gyro" : "accelerometer"}});
}

constexpr const char* always = R"(
static int64_t rounded(int64_t value, int64_t divisor)
{
  const int64_t half = divisor / 2;
  return (value < 0) ? (-((half - value) / divisor)) : ((value + half) / divisor);
}

static int64_t limited(int64_t value, int64_t limit)
{
  int64_t result = value;
  if (value > limit)
  {
    result = limit;
  }
  if (value < (-limit))
  {
    result = -limit;
  }
  return result;
}

static void multiply(const int64_t matrix[3][3], const int64_t vector[3], int64_t divisor, int64_t product[3])
{
  uint32_t i;
  for (i = 0U; i < 3U; i++)
  {
    product[i] = rounded(((matrix[i][0] * limited(vector[0], MOST)) + (matrix[i][1] * limited(vector[1], MOST))) +
                           (matrix[i][2] * limited(vector[2], MOST)), divisor);
  }
}
)";

constexpr const char* of_shares = R"(
/* A number times one between -1 and 1. */
static int64_t share(int64_t value, int64_t x)
{
  return rounded(value * x, ONE);
}
)";

constexpr const char* of_temperature = R"(
/* c[0] x + c[1] x^2 + ... */
static int64_t polynomial(const int64_t coefficient[], uint32_t powers, int64_t x)
{
  int64_t sum = 0;
  uint32_t k;
  for (k = powers; k > 0U; k--)
  {
    sum = share(sum + coefficient[k - 1U], x);
  }
  return sum;
}
)";

std::string whole(const ImuCalibration& c, const FixedFormat& format) {
  const bool force = has_temperature(c.accelerometers), rate = has_temperature(c.gyros);
  std::string text = "\nvoid NAME(const int32_t raw[6], int32_t temperature, int32_t compensated[6])\n{\n";
  if (force || rate)
    text += fmt::format("  const int64_t x = limited(((int64_t)temperature - INT64_C({})) * INT64_C({}), ONE);\n\n",
                        integer_of(c.reference_temperature - celsius_zero, kelvin_bits),
                        std::int64_t{1} << (share_bits - kelvin_bits - format.temperature_bits));
  else
    text += "  (void)temperature;\n";
  return text + fmt::format(
                    "  accelerometer_compensate(&raw[0]{0}, &compensated[0]);\n"
                    "  gyro_compensate(&raw[3], &compensated[0]{1}, &compensated[3]);\n}}\n",
                    force ? ", x" : "", rate ? ", x" : "");
}

/// Integers of six numbers.
std::string six(const ImuSample& s, int force_bits, int rate_bits) {
  return fmt::format("  {{{}, {}, {}, {}, {}, {}}}", integer_of(s.force.x, force_bits),
                     integer_of(s.force.y, force_bits), integer_of(s.force.z, force_bits),
                     integer_of(s.rate.x, rate_bits), integer_of(s.rate.y, rate_bits), integer_of(s.rate.z, rate_bits));
}

constexpr const char* main_of_test = R"(
int main(void)
{
  int64_t worst[2] = {0, 0};
  int32_t found[6];
  uint32_t k;
  uint32_t i;
  for (k = 0U; k < 32U; k++)
  {
    NAME(test_raw[k], test_temperature[k], found);
    for (i = 0U; i < 6U; i++)
    {
      const int64_t difference = (int64_t)found[i] - (int64_t)test_input[k][i];
      const int64_t size = (difference < 0) ? (-difference) : difference;
      if (size > worst[i / 3U])
      {
        worst[i / 3U] = size;
      }
    }
  }
  (void)printf("worst error of 32 test vectors, in last places: %ld, %ld\n", (long)worst[0], (long)worst[1]);
  return ((worst[0] <= test_tolerance[0]) && (worst[1] <= test_tolerance[1])) ? 0 : 1;
}
#endif
)";

/// The inputs belong to the outputs as they are rounded.
std::string tests(const ImuCalibration& c, const FixedFormat& format) {
  std::vector<std::string> raw, input, temperature;
  for (TestVector v : test_vectors(c)) {
    for (std::size_t i = 0; i < 3; ++i) {
      v.outputs.force[i] =
          std::ldexp(std::round(std::ldexp(v.outputs.force[i], format.force.output_bits)), -format.force.output_bits);
      v.outputs.rate[i] =
          std::ldexp(std::round(std::ldexp(v.outputs.rate[i], format.rate.output_bits)), -format.rate.output_bits);
    }
    const std::int64_t celsius = integer_of(v.outputs.temperature - celsius_zero, kelvin_bits);
    v.outputs.temperature = std::ldexp(static_cast<double>(celsius), -kelvin_bits) + celsius_zero;
    raw.push_back(six(v.outputs, format.force.output_bits, format.rate.output_bits));
    input.push_back(six(compensated(c, v.outputs), format.force.input_bits, format.rate.input_bits));
    temperature.push_back(std::to_string(celsius));
  }
  return fmt::format(
             "\n#ifdef TUMBLE_CAL_TEST\n#include <stdio.h>\n\nstatic const int32_t test_raw[32][6] = {{\n{}\n}};\n"
             "static const int32_t test_temperature[32] = {{{}}};\nstatic const int32_t test_input[32][6] = "
             "{{\n{}\n}};\n"
             "static const int64_t test_tolerance[2] = {{{}, {}}};\n",
             fmt::join(raw, ",\n"), fmt::join(temperature, ", "), fmt::join(input, ",\n"),
             static_cast<std::int64_t>(std::ceil(std::ldexp(format.force.error, format.force.input_bits) + 0.5)),
             static_cast<std::int64_t>(std::ceil(std::ldexp(format.rate.error, format.rate.input_bits) + 0.5))) +
         main_of_test;
}

std::string describe(const TriadCalibration& t, const TriadFormat& format, const char* kind, const char* unit) {
  return fmt::format(
      " * {0} raw: 1 {1} = 2^{2}, made for {3:.4g} {1}, limited at {7:.4g} {1}; compensated: 1 {4} = 2^{5}; rounding "
      "error below {6:.3g} "
      "{4}\n",
      kind, t.output.text() == "1" ? unit : t.output.text(), format.output_bits, format.output_limit, unit,
      format.input_bits, format.error, std::ldexp(1.0, 30 - format.output_bits));
}

std::string defines(const FixedFormat& format) {
  return fmt::format(
      "#define ACCELEROMETER_RAW_BITS ({})\n#define ACCELEROMETER_COMPENSATED_BITS ({})\n"
      "#define GYRO_RAW_BITS ({})\n#define GYRO_COMPENSATED_BITS ({})\n#define TEMPERATURE_BITS ({})\n",
      format.force.output_bits, format.force.input_bits, format.rate.output_bits, format.rate.input_bits, kelvin_bits);
}

}  // namespace

std::string fixed_point(const ImuCalibration& c, const Plan& plan) {
  const FixedFormat format = fixed_format(c, plan.force_passes, plan.rate_passes);
  const bool temperature = has_temperature(c), shares = temperature || plan.force_passes > 0 || plan.rate_passes > 0;
  std::string text = "#include <stdint.h>\n\n/*\n" +
                     describe(c.accelerometers, format.force, "accelerometers", "m/s^2") +
                     describe(c.gyros, format.rate, "gyros", "rad/s") +
                     " * temperature: 1 degC = 2^16, limited to the range of the calibration\n */\n" + defines(format) +
                     "void NAME(const int32_t raw[6], int32_t temperature, int32_t compensated[6]);\n\n";
  if (shares) text += "#define ONE (INT64_C(1073741824))\n";
  text += "#define MOST (INT64_C(17179869184))\n" + std::string(always) + (shares ? of_shares : "") +
          (temperature ? of_temperature : "") + "\n" +
          triad(c.accelerometers, format.force, nullptr, plan.force_passes, format.temperature_bits) + "\n" +
          triad(c.gyros, format.rate, &format.force, plan.rate_passes, format.temperature_bits) + whole(c, format) +
          tests(c, format);
  return filled(text, {{"NAME", plan.name}});
}

}  // namespace tumble::c_code
