#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/exchange/assembly/reader.hpp"
#include "tumble/math/matrix3.hpp"
#include "tumble/models/model.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::assembly {
namespace {

constexpr double zero_celsius = 273.15, usual_temperature = zero_celsius + 20.0;  ///< [K]
constexpr std::size_t most_powers = 5;                                            ///< of a curve

using Form = TermFactor::Form;

bool is_rate(Input input) { return static_cast<std::size_t>(input) < 3; }
bool is_force(Input input) { return input >= Input::specific_force_x && input <= Input::specific_force_z; }
std::size_t axis_of(Input input) { return static_cast<std::size_t>(input) % 3; }

/// Coefficients by power; room is made.
void add_to(std::vector<double>& polynomial, std::size_t power, double coefficient) {
  polynomial.resize(std::max(polynomial.size(), power + 1), 0.0);
  polynomial[power] += coefficient;
}

std::vector<double> without_constant(const std::vector<double>& coefficients) {
  std::vector<double> rest(coefficients.size() > 1 ? coefficients.begin() + 1 : coefficients.end(), coefficients.end());
  while (!rest.empty() && rest.back() == 0.0) rest.pop_back();
  return rest;
}

/// One output of a unit while its terms are placed.
struct Placed {
  const OutputModel& model;
  bool gyro, alone;   ///< the only output of its result
  std::size_t index;  ///< axis of the unit
  std::string name;   ///< "gyro_y"
  bool own_axes;      ///< the axes of the sensor are those of the unit
  TriadCalibration& triad;
  double scale = 1.0;                         ///< K
  std::vector<double> bias{0.0}, slope{0.0};  ///< over T - origin: o or nabla, and what multiplies u or y
  double origin = zero_celsius;               ///< [K]
  bool warm = false;                          ///< they have powers
  std::array<double, 3> row{};             ///< of the matrix: what multiplies u_j or y_j, without the 1 of the diagonal
  std::vector<std::string> across, other;  ///< terms that have no place
};

/// The temperature that a factor means at the reference [K]: a power-up begins there.
double origin_of(const Placed& placed, const TermFactor& factor) {
  return factor.from_start ? placed.model.reference_temperature.value_or(usual_temperature) : factor.origin;
}

/// A product of a power of the temperature and at most the own input. False: it is another product.
bool place_warm(Placed& placed, const Product& product, double coefficient) {
  std::size_t power = 0;
  bool by_input = false;
  std::optional<double> origin;
  for (const TermFactor& factor : product.factors) {
    if (factor.form != Form::power || factor.lag) return false;
    if (factor.input == Input::temperature) {
      const double from = origin_of(placed, factor);
      if (origin && *origin != from) return false;
      origin = from;
      power += static_cast<std::size_t>(factor.order);
    } else if (factor.input == placed.model.shows && factor.order == 1 && !by_input) {
      by_input = true;
    } else {
      return false;
    }
  }
  if (power == 0) return false;
  if (by_input && !placed.model.by_output) return false;
  if (!placed.warm) placed.origin = *origin;
  placed.warm = true;
  std::vector<double> polynomial(power + 1, 0.0);
  polynomial[power] = coefficient;
  polynomial = shifted_polynomial(polynomial, placed.origin - *origin);
  for (std::size_t n = 0; n < polynomial.size(); ++n) add_to(by_input ? placed.slope : placed.bias, n, polynomial[n]);
  return true;
}

/// Of the gradient, the rate of change and the time since power-on: its size at 1 K, 1 K/min and switching on.
bool place_transient(Placed& placed, const Product& product, double coefficient) {
  double size = std::abs(coefficient);
  bool transient = false;
  for (const TermFactor& factor : product.factors) {
    if (factor.input == Input::start_temperature) {
      if (factor.origin != placed.model.reference_temperature.value_or(usual_temperature)) return false;
      size = factor.order > 0 ? 0.0 : size;  // a power-up that begins at the reference
    } else if (factor.input == Input::temperature_gradient || factor.form == Form::decay) {
      transient = true;
    } else if (factor.input == Input::temperature_rate) {
      size /= std::pow(minute, factor.order);
      transient = true;
    } else if (factor.input != Input::temperature) {
      return false;
    }
  }
  if (!transient && size != 0.0) return false;
  placed.triad.transient[placed.index] += size;
  return placed.gyro;
}

/// A product of the own input alone.
bool place_curve(Placed& placed, const Product& product, double coefficient) {
  int order = 0, magnitudes = 0;
  for (const TermFactor& factor : product.factors) {
    if (factor.input != placed.model.shows || factor.origin != 0.0 || factor.lag) return false;
    if (factor.form == Form::power)
      order += factor.order;
    else if (factor.form == Form::magnitude)
      ++magnitudes;
    else
      return false;
  }
  OwnCurve& curve = placed.triad.curve[placed.index];
  if (magnitudes == 1 && order < 2 && !placed.model.by_output)
    (order == 0 ? curve.magnitude : curve.signed_square) += coefficient;
  else if (magnitudes == 0 && order == 0)
    placed.bias[0] += coefficient;
  else if (magnitudes == 0 && order == 1)
    placed.row[placed.index] += coefficient;
  else if (magnitudes == 0 && order <= static_cast<int>(most_powers) && !placed.model.by_output)
    curve.power[static_cast<std::size_t>(order) - 2] += coefficient;
  else
    return false;
  return true;
}

/// Another axis, or the specific force on a gyro.
bool place_linear(Placed& placed, const std::string& term, const Product& product, double coefficient) {
  if (product.factors.size() != 1) return false;
  const TermFactor& factor = product.factors.front();
  if (factor.form != Form::power || factor.order != 1 || factor.origin != 0.0 || factor.lag) return false;
  const std::size_t from = axis_of(factor.input);
  const bool own = from == axis_of(placed.model.shows);
  if (placed.gyro && is_force(factor.input) && (placed.own_axes || own)) {
    placed.triad.by_force(placed.index, placed.own_axes ? from : placed.index) += coefficient;
    return true;
  }
  if (!(placed.gyro ? is_rate(factor.input) : is_force(factor.input)) && !is_force(factor.input)) return false;
  if (placed.alone)
    placed.across.push_back(term);
  else
    placed.row[from] += coefficient;
  return true;
}

/// The effect of the position of an accelerometer, as the model imu has it.
bool place_lever(Placed& placed, const ModelTerm& term, double coefficient) {
  if (placed.gyro || placed.alone) return false;
  static const auto outputs = find_model("imu").outputs(defaults(find_model("imu").constants()));
  const auto& own = std::ranges::find(outputs, role(false, placed.index), &Output::channel)->terms;
  for (std::size_t j = 0; j < 3; ++j) {
    const auto lever =
        std::ranges::find(own, fmt::format("{}_lever_{}", role(false, placed.index), "xyz"[j]), &Term::name);
    if (lever->regressor.products() != term.regressor) continue;
    placed.triad.lever(placed.index, j) += coefficient;
    return true;
  }
  return false;
}

void add_once(std::vector<std::string>& names, const std::string& name) {
  if (std::ranges::find(names, name) == names.end()) names.push_back(name);
}

bool is_across(const Placed& placed, const ModelTerm& term) {
  return placed.alone && !placed.gyro && std::ranges::all_of(term.regressor, [](const Product& product) {
           return std::ranges::all_of(product.factors, [](const TermFactor& factor) { return is_force(factor.input); });
         });
}

void place(Reader& reader, Placed& placed, const ModelTerm& term) {
  const auto& parameters = reader.estimate().parameters;
  const double value = term.parameter ? reader.value_or(parameters[*term.parameter].name, 0.0) : 1.0;
  const double coefficient = term.per_output ? value : value * placed.scale;
  if (term.remains) return placed.across.push_back(term.term);
  if (place_lever(placed, term, coefficient)) return;
  for (const Product& product : term.regressor) {
    const double c = coefficient * product.weight;
    if (place_curve(placed, product, c) || place_warm(placed, product, c) ||
        place_linear(placed, term.term, product, c) || place_transient(placed, product, c))
      continue;
    add_once(is_across(placed, term) ? placed.across : placed.other, term.term);
  }
}

/// The coldest and the hottest of all results together: what every one of them covers.
void cover(ImuCalibration& c, double coldest, double hottest) {
  c.coldest = std::isnan(c.coldest) ? coldest : std::max(c.coldest, coldest);
  c.hottest = std::isnan(c.hottest) ? hottest : std::min(c.hottest, hottest);
}

void set_ranges(Reader& reader, Placed& placed) {
  double& range = placed.triad.range[placed.index];
  for (const ModelTerm& term : placed.model.terms)
    if (term.regressor == Regressor(placed.model.shows).products() && std::isfinite(term.least))
      range = std::max(std::abs(term.least), std::abs(term.greatest));
  for (const Covered& covered : placed.model.covered) {
    if (covered.weights.size() != 1) continue;
    const auto& [input, weight] = covered.weights.front();
    if (input == placed.model.shows && !placed.model.by_output)
      range = std::max(std::abs(covered.least), std::abs(covered.greatest)) / std::abs(weight);
    if (input == Input::temperature && placed.warm)
      cover(reader.calibration(), covered.least / weight, covered.greatest / weight);
  }
}

/// The reference temperature of all; the first result that has one sets it.
double reference_of(Reader& reader, const OutputModel& model) {
  double& reference = reader.calibration().reference_temperature;
  if (std::isnan(reference)) reference = model.reference_temperature.value_or(usual_temperature);
  return reference;
}

/// y = b + K u + ... with the bias over temperature.
void finish(Reader& reader, Placed& placed) {
  TriadCalibration& t = placed.triad;
  const std::size_t i = placed.index;
  if (placed.warm) placed.bias = shifted_polynomial(placed.bias, reference_of(reader, placed.model) - placed.origin);
  t.bias[i] += placed.bias[0];
  if (placed.warm) t.thermal[i].output = without_constant(placed.bias);
  t.response(i, i) = placed.scale;
  for (std::size_t j = 0; j < 3; ++j) t.response(i, j) += placed.row[j];
}

/// u = (1 + s) y - b = (1 + s_0)(1 + c)(y - b_0/(1 + s_0)) - e with c = (s - s_0)/(1 + s_0), e = b - b_0 - c b_0.
void finish_by_output(Reader& reader, Placed& placed, Matrix3& m, Vector3& nabla) {
  const std::size_t i = placed.index;
  placed.slope[0] += placed.row[i];
  if (placed.warm) {
    const double from = reference_of(reader, placed.model) - placed.origin;
    placed.bias = shifted_polynomial(placed.bias, from), placed.slope = shifted_polynomial(placed.slope, from);
  }
  const double s0 = -placed.slope[0], b0 = placed.bias[0];
  for (std::size_t j = 0; j < 3; ++j) m(i, j) = i == j ? 1.0 + s0 : -placed.row[j];
  nabla[i] = b0;
  if (!placed.warm) return;
  AxisThermal& thermal = placed.triad.thermal[i];
  thermal.scale = without_constant(placed.slope);
  for (double& c : thermal.scale) c /= -(1.0 + s0);
  thermal.bias = without_constant(placed.bias);
  thermal.bias.resize(std::max(thermal.bias.size(), thermal.scale.size()), 0.0);
  for (std::size_t k = 0; k < thermal.scale.size(); ++k) thermal.bias[k] -= thermal.scale[k] * b0;
}

void add_notes(Reader& reader, const Placed& placed) {
  if (!placed.across.empty())
    reader.note(
        fmt::format("{}: {} are not used, since the result does not say along which axes of the unit its own "
                    "axes lie",
                    placed.name, fmt::join(placed.across, ", ")));
  if (!placed.other.empty())
    reader.note(
        fmt::format("{}: {} are not part of this calibration, which has no place for them; compensate subtracts "
                    "them",
                    placed.name, fmt::join(placed.other, ", ")));
  if (placed.model.delay)
    reader.note(fmt::format("{}: its delay is not part of this calibration; compensate takes it out", placed.name));
  const bool from_start = placed.warm && placed.model.thermal;
  if (from_start)
    reader.note(
        fmt::format("{}: drift with temperature as after switching on at {:g} degC; the level at power-on is not "
                    "part of it",
                    placed.name, placed.model.reference_temperature.value_or(usual_temperature) - zero_celsius));
}

/// "2000 pulse/s/g": what one SI unit of the quantity gives, where the output is not the quantity.
std::string reading_of(const OutputModel& model) {
  if (model.nominal == 1.0 || model.scale) return "";
  const std::string unit = fmt::format("{}/({})", model.recorded.text(), model.unit.text());
  return fmt::format("the output over its nominal scale factor {:.10g} {}",
                     Unit::parse(unit).from_si(1.0 / model.nominal), unit);
}

/// All sensors of a triad must show outputs of one unit, since it has one matrix.
void set_output(Reader& reader, const Placed& placed) {
  TriadCalibration& t = placed.triad;
  const Unit unit = placed.model.scale ? si_unit(placed.model.recorded) : input_unit(placed.gyro);
  const bool only = std::ranges::count(t.axes, true) == 1;
  if (!only && !(t.output.dimension() == unit.dimension()))
    reader.problem(placed.gyro
                       ? say("its output is in {}, that of another gyro in {}", unit.text(), t.output.text())
                       : say("its output is in {}, that of another accelerometer in {}", unit.text(), t.output.text()));
  t.output = unit;
  const std::string text = reading_of(placed.model);
  if (text.empty() || text == t.reading) return;
  t.reading = t.reading.empty() ? text : fmt::format("{}; {}: {}", t.reading, placed.name, text);
}

/// The axis that the user named for a single sensor, else its own.
std::string name_of(Reader& reader, const OutputModel& model, bool gyro, bool alone) {
  const std::string own = role(gyro, axis_of(model.shows));
  const std::string& named = reader.input().axis;
  if (!alone || named.empty()) return own;
  for (std::size_t i = 0; i < 3; ++i)
    if (named == role(gyro, i)) return named;
  reader.problem(
      gyro ? say("it is of one gyro, so that it cannot be {}; write gyro_x=FILE, gyro_y=FILE or gyro_z=FILE", named)
           : say("it is of one accelerometer, so that it cannot be {}; write accelerometer_x=FILE, "
                 "accelerometer_y=FILE or accelerometer_z=FILE",
                 named));
  return own;
}

void claim(Reader& reader, const Placed& placed, std::set<std::string>& claimed) {
  const OutputModel& model = placed.model;
  const bool constant =
      model.offset || std::ranges::any_of(model.terms, [](const ModelTerm& term) {
        return std::ranges::any_of(term.regressor, [](const Product& product) { return product.factors.empty(); });
      });
  const bool linear = model.scale || placed.row[placed.index] != 0.0;
  if (constant || !placed.alone) reader.claim(placed.name + " bias", claimed);
  if (linear || !placed.alone) reader.claim(placed.name + " scale factor", claimed);
  if (placed.warm) reader.claim(placed.name + " temperature", claimed);
}

/// u = M y - nabla of the outputs of a kind that were calibrated so.
struct ByOutput {
  Matrix3 m = identity3();
  Vector3 nabla = {};
  std::vector<std::size_t> axes = {};
};

void set_response(const ByOutput& by, TriadCalibration& t) {
  if (by.axes.empty()) return;
  const Matrix3 response = inverse(by.m);
  const Vector3 bias = response * by.nabla;
  for (const std::size_t i : by.axes) {
    t.response[i] = response[i];
    t.bias[i] = bias[i];
  }
}

/// Scale factor, offset and terms in their places.
void place_all(Reader& reader, Placed& placed, std::set<std::string>& claimed) {
  const OutputModel& model = placed.model;
  const auto& parameters = reader.estimate().parameters;
  if (model.scale) placed.scale = reader.value_or(parameters[*model.scale].name, 1.0);
  if (model.offset) placed.bias[0] = reader.value_or(parameters[*model.offset].name, 0.0);
  placed.triad.calibrated = placed.triad.axes[placed.index] = true;
  set_output(reader, placed);
  for (const ModelTerm& term : model.terms) place(reader, placed, term);
  claim(reader, placed, claimed);
  set_ranges(reader, placed);
  if (model.measured && placed.alone)
    placed.triad.measured[placed.index] = {
        model.measured->slope, model.measured->offset, {model.measured->input, model.measured->departure}};
}

}  // namespace

void read_models(Reader& reader, std::set<std::string>& claimed) {
  const auto& models = reader.estimate().models;
  std::array<ByOutput, 2> by_output;
  for (const OutputModel& model : models) {
    if (!is_rate(model.shows) && !is_force(model.shows)) {
      reader.note(fmt::format("the model of {} is not part of a calibration of gyros and accelerometers", model.role));
      continue;
    }
    const bool gyro = is_rate(model.shows), alone = models.size() == 1;
    const std::string name = name_of(reader, model, gyro, alone);
    Placed placed{model,
                  gyro,
                  alone,
                  static_cast<std::size_t>(name.back() - 'x'),
                  name,
                  reader.input().axis.empty(),
                  triad(reader.calibration(), gyro)};
    place_all(reader, placed, claimed);
    if (model.by_output) {
      by_output[gyro].axes.push_back(placed.index);
      finish_by_output(reader, placed, by_output[gyro].m, by_output[gyro].nabla);
    } else {
      finish(reader, placed);
    }
    add_notes(reader, placed);
  }
  for (const bool gyro : {false, true}) set_response(by_output[gyro], triad(reader.calibration(), gyro));
}

}  // namespace tumble::assembly
