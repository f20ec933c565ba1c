#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/exchange/exports/c_code/model.hpp"
#include "tumble/exchange/exports/writing/text.hpp"

namespace tumble::c_code {
namespace {

constexpr double zero_celsius = 273.15;

std::string literal(double value, Number number) {
  return number == Number::double_precision ? writing::real(value) : writing::real_of_float(value) + "F";
}

std::string braces(const std::vector<double>& values, Number number) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(literal(value, number));
  return fmt::format("{{{}}}", fmt::join(texts, ", "));
}

/// "static const double gyro_bias[3] = {...};"
std::string vector(const std::string& name, Vector3 v, Number number) {
  return fmt::format("static const REAL {}[3] = {};\n", name, braces({v.x, v.y, v.z}, number));
}

std::string table(const std::string& name, const std::vector<std::vector<double>>& rows, Number number) {
  std::string text = fmt::format("static const REAL {}[{}][{}] = {{\n", name, rows.size(), rows[0].size());
  for (std::size_t i = 0; i < rows.size(); ++i)
    text += fmt::format("  {}{}\n", braces(rows[i], number), i + 1 < rows.size() ? "," : "");
  return text + "};\n";
}

std::string matrix(const std::string& name, const Matrix3& m, Number number) {
  return table(name, {{m.x.x, m.x.y, m.x.z}, {m.y.x, m.y.y, m.y.z}, {m.z.x, m.z.y, m.z.z}}, number);
}

/// Coefficients of one polynomial of the three axes, all with as many powers.
std::string polynomials(const std::string& name, const TriadCalibration& t, std::vector<double> AxisThermal::*which,
                        Number number) {
  std::size_t most = 0;
  for (const auto& axis : t.thermal) most = std::max(most, (axis.*which).size());
  if (most == 0) return "";
  std::vector<std::vector<double>> rows;
  for (const auto& axis : t.thermal) {
    rows.push_back(axis.*which);
    rows.back().resize(most, 0.0);
  }
  return fmt::format("#define {}_POWERS ({}U)\n", name, most) + table(name, rows, number);
}

constexpr const char* table_lookup = R"(
/* Departure of one output by its table: straight between the inputs, constant beyond them. */
static REAL KIND_by_table(uint32_t axis, REAL u)
{
  REAL value = KIND_departure[axis][0];
  uint32_t k;
  for (k = 1U; k < KIND_points[axis]; k++)
  {
    const REAL into = u - KIND_at[axis][k - 1U];
    if (u >= KIND_at[axis][k])
    {
      value = KIND_departure[axis][k];
    }
    else if (into > ZERO)
    {
      value = KIND_departure[axis][k - 1U] + (KIND_slope[axis][k] * into);
    }
    else
    {
      /* an earlier pair of inputs holds it */
    }
  }
  return value;
}
)";

std::string table_code(const TriadCalibration& t, Number number) {
  const TableRows rows = table_rows(t);
  return fmt::format("static const uint32_t KIND_points[3] = {{{}U}};\n", fmt::join(rows.points, "U, ")) +
         table("KIND_at", rows.at, number) + table("KIND_departure", rows.departure, number) +
         table("KIND_slope", rows.slope, number) + table_lookup;
}

std::string terms_code(const TriadCalibration& t, Number number) {
  std::vector<std::vector<double>> powers;
  Vector3 magnitude, signed_square;
  for (std::size_t i = 0; i < 3; ++i) {
    powers.emplace_back(t.curve[i].power.begin(), t.curve[i].power.end());
    magnitude[i] = t.curve[i].magnitude;
    signed_square[i] = t.curve[i].signed_square;
  }
  return table("KIND_power", powers, number) + vector("KIND_magnitude", magnitude, number) +
         vector("KIND_signed_square", signed_square, number) + R"(
/* Departure of one output from a straight line: p2 u^2 + ... + p5 u^5 + m |u| + s u |u|. */
static REAL KIND_by_terms(uint32_t axis, REAL u)
{
  const REAL size = (u < ZERO) ? (-u) : u;
  REAL sum = KIND_power[axis][3];
  sum = (sum * u) + KIND_power[axis][2];
  sum = (sum * u) + KIND_power[axis][1];
  sum = (sum * u) + KIND_power[axis][0];
  sum = (sum * u) * u;
  sum = sum + (KIND_magnitude[axis] * size);
  return sum + ((KIND_signed_square[axis] * u) * size);
}
)";
}

/// What an output departs from a straight line by; far beyond the range as at its end.
std::string curve_code(const TriadCalibration& t, Number number) {
  const bool terms = has_terms(t), tabled = table_points(t) > 0;
  Vector3 reach;
  for (std::size_t i = 0; i < 3; ++i) reach[i] = std::ldexp(1.0, curve_exponent(t, i));
  return (tabled ? table_code(t, number) : "") + (terms ? terms_code(t, number) : "") +
         vector("KIND_reach", reach, number) +
         fmt::format(
             "\nstatic REAL KIND_curve(uint32_t axis, REAL u)\n{{\n"
             "  const REAL below = (u > KIND_reach[axis]) ? KIND_reach[axis] : u;\n"
             "  const REAL inside = (below < (-KIND_reach[axis])) ? (-KIND_reach[axis]) : below;\n"
             "  return {}{}{};\n}}\n",
             terms ? "KIND_by_terms(axis, inside)" : "", terms && tabled ? " + " : "",
             tabled ? "KIND_by_table(axis, inside)" : "");
}

bool has(const TriadCalibration& t, std::vector<double> AxisThermal::*which) {
  return std::ranges::any_of(t.thermal, [&](const AxisThermal& axis) { return !(axis.*which).empty(); });
}

std::string loop(const std::string& body) { return "  for (i = 0U; i < 3U; i++)\n  {\n" + body + "  }\n"; }

/// One triad: what the other one gives is subtracted first.
std::string triad_function(const TriadCalibration& t, bool gyro, int passes) {
  const bool temperature = has_temperature(t);
  std::string text = fmt::format("\nstatic void KIND_compensate(const REAL output[3]{}{}, REAL input[3])\n{{\n",
                                 gyro ? ", const REAL force[3]" : "", temperature ? ", REAL d" : "");
  text += "  REAL straight[3];\n" + std::string(passes > 0 ? "  REAL rest[3];\n  uint32_t pass;\n" : "") +
          "  uint32_t i;\n\n";
  std::string first = "    straight[i] = limited(output[i], KIND_most[i]) - KIND_bias[i];\n";
  if (has(t, &AxisThermal::output))
    first += "    straight[i] = straight[i] - polynomial(KIND_thermal_output[i], KIND_thermal_output_POWERS, d);\n";
  if (gyro)
    first +=
        "    straight[i] = straight[i] - (((gyro_by_force[i][0] * force[0]) + (gyro_by_force[i][1] * force[1])) +\n"
        "                                 (gyro_by_force[i][2] * force[2]));\n";
  text += loop(first) + "  multiply(KIND_inverse, straight, input);\n";
  if (passes > 0)
    text += fmt::format(
        "  for (pass = 0U; pass < {}U; pass++)\n  {{\n    for (i = 0U; i < 3U; i++)\n    {{\n"
        "      rest[i] = straight[i] - KIND_curve(i, input[i]);\n    }}\n"
        "    multiply(KIND_inverse, rest, input);\n  }}\n",
        passes);
  std::string last;
  if (has(t, &AxisThermal::scale))
    last += "    input[i] = input[i] + (input[i] * polynomial(KIND_thermal_scale[i], KIND_thermal_scale_POWERS, d));\n";
  if (has(t, &AxisThermal::bias))
    last += "    input[i] = input[i] - polynomial(KIND_thermal_bias[i], KIND_thermal_bias_POWERS, d);\n";
  return text + (last.empty() ? "" : loop(last)) + "}\n";
}

/// Outputs beyond a million times those of the range [output] are taken as that, so that no product overflows.
Vector3 most_output(const TriadCalibration& t) {
  constexpr double times = 1e6;
  Vector3 most;
  for (std::size_t i = 0; i < 3; ++i) {
    double size = std::abs(t.bias[i]);
    for (std::size_t j = 0; j < 3; ++j) size += std::abs(t.response(i, j)) * t.range[j];
    most[i] = times * size;
  }
  return most;
}

std::string triad_code(const TriadCalibration& t, bool gyro, const Plan& plan) {
  const Number n = plan.number;
  const int passes = gyro ? plan.rate_passes : plan.force_passes;
  std::string text = matrix("KIND_inverse", inverse(t.response), n) + vector("KIND_bias", t.bias, n) +
                     vector("KIND_most", most_output(t), n);
  if (gyro) text += matrix("gyro_by_force", t.by_force, n);
  text += polynomials("KIND_thermal_output", t, &AxisThermal::output, n) +
          polynomials("KIND_thermal_scale", t, &AxisThermal::scale, n) +
          polynomials("KIND_thermal_bias", t, &AxisThermal::bias, n);
  if (passes > 0) text += curve_code(t, n);
  return filled(text + triad_function(t, gyro, passes), {{"KIND", gyro ? "gyro" : "accelerometer"}});
}

constexpr const char* helpers = R"(
static REAL limited(REAL value, REAL most)
{
  const REAL below = (value > most) ? most : value;
  return (below < (-most)) ? (-most) : below;
}

static void multiply(const REAL matrix[3][3], const REAL vector[3], REAL product[3])
{
  uint32_t i;
  for (i = 0U; i < 3U; i++)
  {
    product[i] = ((matrix[i][0] * vector[0]) + (matrix[i][1] * vector[1])) + (matrix[i][2] * vector[2]);
  }
}
)";

constexpr const char* polynomial_helper = R"(
/* c[0] d + c[1] d^2 + ... */
static REAL polynomial(const REAL coefficient[], uint32_t powers, REAL d)
{
  REAL sum = ZERO;
  uint32_t k;
  for (k = powers; k > 0U; k--)
  {
    sum = (sum + coefficient[k - 1U]) * d;
  }
  return sum;
}
)";

std::string body(const ImuCalibration& c) {
  const bool force = has_temperature(c.accelerometers), rate = has_temperature(c.gyros);
  std::string text = "\nvoid NAME(const REAL raw[6], REAL temperature, REAL compensated[6])\n{\n";
  if (force || rate) text += "  const REAL d = limited(temperature - reference_temperature, temperature_reach);\n\n";
  if (!force && !rate) text += "  (void)temperature;\n";
  text += fmt::format(
      "  accelerometer_compensate(&raw[0]{0}, &compensated[0]);\n"
      "  gyro_compensate(&raw[3], &compensated[0]{1}, &compensated[3]);\n}}\n",
      force ? ", d" : "", rate ? ", d" : "");
  return text;
}

/// Rounding errors of about 40 operations on numbers of the size of outputs and inputs.
double tolerance_of(const TriadCalibration& t, const std::vector<TestVector>& vectors, bool gyro, Number number) {
  double size = 0.0;
  for (const auto& v : vectors) {
    const Vector3 output = gyro ? v.outputs.rate : v.outputs.force, input = gyro ? v.inputs.rate : v.inputs.force;
    const Vector3 by_output = inverse(t.response) * output;
    size = std::max({size, norm(by_output), norm(input)});
  }
  return 40.0 * size * (number == Number::double_precision ? 0x1p-52 : 0x1p-23);
}

constexpr const char* test_main = R"(
int main(void)
{
  REAL worst[2] = {ZERO, ZERO};
  REAL found[6];
  uint32_t k;
  uint32_t i;
  for (k = 0U; k < 32U; k++)
  {
    NAME(test_raw[k], test_temperature[k], found);
    for (i = 0U; i < 6U; i++)
    {
      const REAL difference = found[i] - test_input[k][i];
      const REAL size = (difference < ZERO) ? (-difference) : difference;
      if (!(size <= worst[i / 3U]))
      {
        worst[i / 3U] = size;
      }
    }
  }
  (void)printf("worst error of 32 test vectors: %.3g m/s^2, %.3g rad/s\n", (double)worst[0], (double)worst[1]);
  return ((worst[0] <= test_tolerance[0]) && (worst[1] <= test_tolerance[1])) ? 0 : 1;
}
#endif
)";

std::string test_code(const ImuCalibration& c, Number number) {
  const auto vectors = test_vectors(c);
  std::vector<std::vector<double>> raw, input;
  std::vector<double> temperatures;
  for (const auto& v : vectors) {
    raw.push_back({v.outputs.force.x, v.outputs.force.y, v.outputs.force.z, v.outputs.rate.x, v.outputs.rate.y,
                   v.outputs.rate.z});
    input.push_back(
        {v.inputs.force.x, v.inputs.force.y, v.inputs.force.z, v.inputs.rate.x, v.inputs.rate.y, v.inputs.rate.z});
    temperatures.push_back(v.outputs.temperature - zero_celsius);
  }
  return "\n#ifdef TUMBLE_CAL_TEST\n#include <stdio.h>\n\n" + table("test_raw", raw, number) +
         fmt::format("static const REAL test_temperature[32] = {};\n", braces(temperatures, number)) +
         table("test_input", input, number) +
         fmt::format("static const REAL test_tolerance[2] = {};\n",
                     braces({tolerance_of(c.accelerometers, vectors, false, number),
                             tolerance_of(c.gyros, vectors, true, number)},
                            number)) +
         test_main;
}

}  // namespace

std::string floating_point(const ImuCalibration& c, const Plan& plan) {
  const bool temperature = has_temperature(c);
  std::string text = "#include <stdint.h>\n\n";
  text += fmt::format(
      "/* raw: accelerometers x y z [{}], gyros x y z [{}]; temperature [degC];\n"
      "   compensated: specific force [m/s^2] and angular rate [rad/s], x y z each. */\n"
      "void NAME(const REAL raw[6], REAL temperature, REAL compensated[6]);\n\n",
      c.accelerometers.output.text() == "1" ? "m/s^2" : c.accelerometers.output.text(),
      c.gyros.output.text() == "1" ? "rad/s" : c.gyros.output.text());
  if (temperature)
    text += fmt::format("static const REAL reference_temperature = {};\n",
                        literal(c.reference_temperature - zero_celsius, plan.number)) +
            "/* polynomials end there: one that nobody calibrated would outgrow the output itself */\n" +
            fmt::format("static const REAL temperature_reach = {};\n",
                        literal(std::ldexp(1.0, temperature_exponent(c)), plan.number));
  text += std::string(helpers) + (temperature ? polynomial_helper : "") + "\n" +
          triad_code(c.accelerometers, false, plan) + "\n" + triad_code(c.gyros, true, plan) + body(c) +
          test_code(c, plan.number);
  const bool wide = plan.number == Number::double_precision;
  return filled(text, {{"REAL", wide ? "double" : "float"}, {"ZERO", wide ? "0.0" : "0.0F"}, {"NAME", plan.name}});
}

}  // namespace tumble::c_code
