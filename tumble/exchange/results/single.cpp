#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/exchange/results/reader.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::results {
namespace {

constexpr double zero_celsius = 273.15;

/// One axis of a unit that a result of a single sensor is of.
struct Axis {
  TriadCalibration* triad = nullptr;
  std::size_t index = 0;
  std::string name;
};

Axis begin_axis(Reader& reader, bool gyro, std::initializer_list<const char*> parts, std::set<std::string>& claimed) {
  Axis axis{&triad(reader.calibration(), gyro), 0, reader.input().axis.empty() ? role(gyro, 0) : reader.input().axis};
  for (std::size_t i = 0; i < 3; ++i)
    if (axis.name == role(gyro, i)) axis.index = i;
  if (axis.name != role(gyro, axis.index))
    reader.problem(say("it is of one {}, so that it cannot be {}; write {}_x=FILE, {}_y=FILE or {}_z=FILE",
                       gyro ? "gyro" : "accelerometer", axis.name, gyro ? "gyro" : "accelerometer",
                       gyro ? "gyro" : "accelerometer", gyro ? "gyro" : "accelerometer"));
  for (const char* part : parts) reader.claim(axis.name + part, claimed);
  axis.triad->calibrated = true;
  axis.triad->axes[axis.index] = true;
  if (axis.triad->output.dimension() == Dimension{}) axis.triad->output = input_unit(gyro);
  return axis;
}

/// All sensors of a triad must show outputs of one unit, since it has one matrix.
void set_output(Reader& reader, const Axis& axis, const Unit& unit, bool gyro) {
  TriadCalibration& t = *axis.triad;
  const bool only = std::ranges::count(t.axes, true) == 1;
  if (!only && !(t.output.dimension() == unit.dimension()))
    reader.problem(say("its output is in {}, that of another {} in {}", unit.text(), gyro ? "gyro" : "accelerometer",
                       t.output.text()));
  t.output = unit;
}

/// Terms that need what is felt across the input axis: these stay in, as in the compensation of one channel.
void note_across(Reader& reader, const Axis& axis, std::initializer_list<const char*> names) {
  std::vector<std::string> present;
  for (const char* name : names)
    if (reader.has(name)) present.emplace_back(name);
  if (!present.empty())
    reader.note(
        fmt::format("{}: {} are not used, since the result does not say along which axes of the unit its own "
                    "axes p and o lie",
                    axis.name, fmt::join(present, ", ")));
}

/// The coldest and the hottest of all results together: what every one of them covers.
void cover(ImuCalibration& c, double coldest, double hottest) {
  c.coldest = std::isnan(c.coldest) ? coldest : std::max(c.coldest, coldest);
  c.hottest = std::isnan(c.hottest) ? hottest : std::min(c.hottest, hottest);
}

std::vector<double> without_constant(const std::vector<double>& coefficients) {
  std::vector<double> rest(coefficients.size() > 1 ? coefficients.begin() + 1 : coefficients.end(), coefficients.end());
  while (!rest.empty() && rest.back() == 0.0) rest.pop_back();
  return rest;
}

/// The reference temperature of all; the first result that has one sets it.
double reference_of(Reader& reader, const std::string& text) {
  double& reference = reader.calibration().reference_temperature;
  if (std::isnan(reference)) reference = text.empty() ? zero_celsius + 20.0 : parse_si(text, Unit::parse("degC"));
  return reference;
}

}  // namespace

void read_tumble(Reader& reader, std::set<std::string>& claimed) {
  const Axis axis = begin_axis(reader, false, {" bias", " scale factor"}, claimed);
  const auto estimated = reader.find("scale_factor");
  const double k = estimated.value_or(1.0);
  TriadCalibration& t = *axis.triad;
  const std::size_t i = axis.index;
  Unit unit = input_unit(false);
  if (estimated)
    unit = si_unit(Unit::parse("(" + find_parameter(reader.estimate(), "scale_factor")->unit.text() + ")*(m/s^2)"));
  set_output(reader, axis, unit, false);
  if (!estimated && !reader.setting("scale_factor").empty())
    t.reading = "the output over its scale factor " + reader.setting("scale_factor");
  t.response(i, i) = k * (1.0 + reader.value_or("scale_factor_error", 0.0));
  t.bias[i] = k * reader.value_or("bias", 0.0);
  t.curve[i].power[0] = k * reader.value_or("second_order_coefficient", 0.0);
  t.curve[i].power[1] = k * reader.value_or("third_order_coefficient", 0.0);
  t.curve[i].signed_square = k * reader.value_or("odd_quadratic_coefficient", 0.0);
  note_across(reader, axis,
              {"misalignment_o", "misalignment_p", "cross_coupling_ip", "cross_coupling_io", "cross_coupling_po",
               "second_order_pp", "second_order_oo"});
}

void read_four_position(Reader& reader, std::set<std::string>& claimed) {
  const Axis axis = begin_axis(reader, false, {" bias", " scale factor", " temperature"}, claimed);
  TriadCalibration& t = *axis.triad;
  set_output(reader, axis, input_unit(false), false);
  if (!reader.setting("scale_factor").empty())
    t.reading = "the output over its nominal scale factor " + reader.setting("scale_factor");
  std::vector<double> bias, scale;
  for (const char* power : {"0", "1", "2"}) {
    if (const auto b = reader.find(std::string("b_") + power)) bias.push_back(*b);
    if (const auto c = reader.find(std::string("c_") + power)) scale.push_back(*c);
  }
  if (bias.empty()) bias.push_back(reader.value_or("bias", 0.0));
  if (scale.empty()) scale.push_back(reader.value_or("scale_factor_error", 0.0));
  if (bias.size() > 1 || scale.size() > 1) {
    const double celsius = reference_of(reader, reader.setting("report_temperature")) - zero_celsius;
    bias = shifted_polynomial(bias, celsius), scale = shifted_polynomial(scale, celsius);
  }
  // u = (1 + s) y - b = (1 + s_0)(1 + c)(y - b_0/(1 + s_0)) - e with c = (s - s_0)/(1 + s_0), e = b - b_0 - c b_0
  const double s0 = scale[0], b0 = bias[0];
  t.response(axis.index, axis.index) = 1.0 / (1.0 + s0);
  t.bias[axis.index] = b0 / (1.0 + s0);
  AxisThermal& thermal = t.thermal[axis.index];
  thermal.scale = without_constant(scale);
  for (double& c : thermal.scale) c /= 1.0 + s0;
  thermal.bias = without_constant(bias);
  thermal.bias.resize(std::max(thermal.bias.size(), thermal.scale.size()), 0.0);
  for (std::size_t k = 0; k < thermal.scale.size(); ++k) thermal.bias[k] -= thermal.scale[k] * b0;
  if (const Table* range = find_table(reader.estimate(), "calibrated_range");
      range && range->rows.size() == 1 && range->columns.size() == 2)
    cover(reader.calibration(), reader.cell(*range, 0, 0), reader.cell(*range, 0, 1));
  note_across(reader, axis, {"second_order_coefficient", "misalignment"});
}

namespace {

/// The line through the means at each rate, and how far these lie from it.
void read_departures(Reader& reader, TriadCalibration& t, std::size_t i) {
  constexpr std::size_t fewest = 3;
  const Table* line = find_table(reader.estimate(), "line");
  const Table* residuals = find_table(reader.estimate(), "residuals");
  if (!line || !residuals || line->rows.size() != 1 || line->columns.size() != 3 || residuals->columns.size() < 2 ||
      residuals->rows.size() < fewest)
    return;
  const double slope = reader.cell(*line, 0, 0), full = slope * reader.cell(*line, 0, 2);
  MeasuredLine measured{slope, slope * reader.cell(*line, 0, 1), {}};
  for (std::size_t r = 0; r < residuals->rows.size(); ++r) {
    const double at = reader.cell(*residuals, r, 0);
    if (r > 0 && !(at > measured.departures.at.back())) return reader.problem("the rates of its residuals do not rise");
    measured.departures.at.push_back(at);
    measured.departures.departure.push_back(full * reader.cell(*residuals, r, 1));
  }
  t.measured[i] = std::move(measured);
}

}  // namespace

void read_scale_factor(Reader& reader, std::set<std::string>& claimed) {
  const Axis axis = begin_axis(reader, true, {" bias", " scale factor"}, claimed);
  const std::size_t i = axis.index;
  TriadCalibration& t = *axis.triad;
  const Parameter* parameter = find_parameter(reader.estimate(), "scale_factor");
  const double k = reader.value_or("scale_factor", 1.0);
  if (parameter) set_output(reader, axis, si_unit(Unit::parse("(" + parameter->unit.text() + ")*(rad/s)")), true);
  t.bias[i] = k * reader.value_or("bias", 0.0);
  t.response(i, i) = k;
  t.curve[i].magnitude = 0.5 * k * reader.value_or("scale_factor_asymmetry", 0.0);
  const Table* powers = find_table(reader.estimate(), "odd_powers");
  for (std::size_t r = 0; powers && powers->columns.size() == 3 && r < powers->rows.size(); ++r) {
    const int n = static_cast<int>(reader.cell(*powers, r, 0));
    const double range = reader.cell(*powers, r, 1), slope = reader.cell(*powers, r, 2);
    if (n != 3 && n != 5) continue;
    const double c = k * reader.value_or(n == 3 ? "third_order_coefficient" : "fifth_order_coefficient", 0.0);
    t.curve[i].power[static_cast<std::size_t>(n) - 2] = c / std::pow(range, n - 1);
    t.response(i, i) -= c * slope;
    t.range[i] = range;
  }
  read_departures(reader, t, i);
}

void read_static_bias(Reader& reader, std::set<std::string>& claimed) {
  const Parameter* bias = find_parameter(reader.estimate(), "bias");
  if (!bias) return reader.problem("the result has no parameter bias");
  const bool gyro = bias->unit.dimension() == input_unit(true).dimension();
  const Axis axis = begin_axis(reader, gyro, {" bias"}, claimed);
  set_output(reader, axis, input_unit(gyro), gyro);
  axis.triad->bias[axis.index] = reader.value_or("bias", 0.0);
}

void read_fog(Reader& reader, std::set<std::string>& claimed) {
  const Axis axis = begin_axis(reader, true, {" temperature"}, claimed);
  TriadCalibration& t = *axis.triad;
  set_output(reader, axis, input_unit(true), true);
  const std::string start = reader.setting("start_temperature_reference");
  const bool raw = reader.setting("form") == "raw";
  const double from = raw ? zero_celsius : start.empty() ? zero_celsius + 20.0 : parse_si(start, Unit::parse("degC"));
  std::vector<double> drift{0.0};
  for (int k = 1; k <= 4; ++k) drift.push_back(reader.value_or(fmt::format("A{}_0", k), 0.0));
  drift = shifted_polynomial(drift, reference_of(reader, start) - from);
  t.bias[axis.index] += drift[0];
  t.thermal[axis.index].output = without_constant(drift);
  double transient = std::abs(reader.value_or("startup_transient", 0.0));
  for (int k = 1; k <= 2; ++k) {
    transient += std::abs(reader.value_or(fmt::format("B{}_0", k), 0.0));
    transient += std::abs(reader.value_or(fmt::format("C{}_0", k), 0.0)) / std::pow(minute, k);
  }
  t.transient[axis.index] = transient;
  reader.note(
      fmt::format("{}: drift with temperature as after switching on at {:g} degC; the level at power-on is not "
                  "part of it",
                  axis.name, from - zero_celsius + (raw ? 20.0 : 0.0)));
  const Table* range = find_table(reader.estimate(), "calibrated_range");
  for (std::size_t r = 0; range && range->columns.size() == 6 && r < range->rows.size(); ++r) {
    const double weight = reader.cell(*range, r, 0);
    if (weight > 0.0 && reader.cell(*range, r, 1) == 0.0 && reader.cell(*range, r, 2) == 0.0)
      cover(reader.calibration(), reader.cell(*range, r, 4) / weight, reader.cell(*range, r, 5) / weight);
  }
}

}  // namespace tumble::results
