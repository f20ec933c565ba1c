#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "tumble/reduce/accelerometer/over_temperature.hpp"
#include "tumble/reduce/imu/error_models.hpp"
#include "tumble/reduce/output_model.hpp"
#include "tumble/report/error_model/json.hpp"
#include "tumble/units/error.hpp"

// Results of before the member `models`: which terms a parameter multiplies was known to its method alone, and the
// ranges stood in tables for programs (regressors, calibrated_range, covered, odd_powers, line).

namespace tumble::error_model {
namespace {

using Input::w_x, Input::w_y, Input::f_x, Input::f_y, Input::f_z;

constexpr double infinity = std::numeric_limits<double>::infinity();

double cell(const Table& table, std::size_t row, std::size_t column) {
  const auto& cells = table.rows.at(row);
  const double* number = column < cells.size() ? std::get_if<double>(&cells[column]) : nullptr;
  return number ? *number : std::nan("");
}

std::string setting(const Estimate& estimate, const std::string& name) {
  const auto match = estimate.provenance.settings.find(name);
  return match == estimate.provenance.settings.end() ? "" : match->second;
}

double number_of(const Estimate& estimate, const std::string& name, const char* unit, double otherwise) {
  const std::string text = setting(estimate, name);
  return text.empty() ? otherwise : parse_si(text, Unit::parse(unit));
}

/// The ranges of the table `regressors` for these terms; unknown ones are without end.
TermRanges ranges_of(const Estimate& estimate, std::vector<Term> terms) {
  std::map<std::string, std::pair<double, double>> known;
  if (const Table* table = find_table(estimate, "regressors"))
    for (std::size_t r = 0; r < table->rows.size(); ++r)
      if (const auto* name = std::get_if<std::string>(&table->rows[r].at(0)))
        known[*name] = {cell(*table, r, 1), cell(*table, r, 2)};
  TermRanges ranges{std::move(terms), {}, {}};
  for (const Term& term : ranges.terms) {
    const auto match = known.find(term.name);
    ranges.least.push_back(match == known.end() ? -infinity : match->second.first);
    ranges.greatest.push_back(match == known.end() ? infinity : match->second.second);
  }
  return ranges;
}

std::vector<Term> terms_of(const char* model, const Settings& constants, std::size_t output = 0) {
  return find_model(model).outputs(constants).at(output).terms;
}

std::vector<Term> terms_of(const char* model) { return terms_of(model, defaults(find_model(model).constants())); }

/// A nominal scale factor as a setting states it, in the first of these units that fits: what was recorded over it is
/// the quantity.
void set_nominal(const Estimate& estimate, const std::string& name, std::initializer_list<const char*> outputs,
                 OutputModel& model) {
  const std::string text = setting(estimate, name);
  for (const char* output : outputs) {
    if (text.empty()) return;
    try {
      model.nominal = 1.0 / parse_si(text, Unit::parse(fmt::format("({})/({})", output, model.unit.text())));
      model.recorded = Unit::parse(output);
      return;
    } catch (const Error&) {  // another unit
    }
  }
}

std::vector<OutputModel> accelerometer(const Estimate& estimate) {
  Settings constants = defaults(find_model("pendulous_accelerometer").constants());
  if (const double tilt = number_of(estimate, "tilt", "1/g", 0.0); tilt != 0.0) {
    constants.set_number("pendulosity", tilt, Unit::parse("kg*m"));
    constants.set_number("servo_stiffness", 1.0, Unit::parse("N*m/rad"));
  }
  auto terms = terms_of("pendulous_accelerometer", constants);
  if (estimate.method != "accelerometer_dynamic")
    std::erase_if(terms, [](const Term& term) { return term.name == "scale_factor_error"; });
  OutputModel model =
      output_model(estimate, "accelerometer", Input::specific_force_x, "g", ranges_of(estimate, std::move(terms)));
  set_scale(estimate, "scale_factor", model);
  if (!model.scale) set_nominal(estimate, "scale_factor", {"mA", "V", "pulse/s"}, model);
  return {model};
}

std::vector<OutputModel> four_position(const Estimate& estimate) {
  const Table* range = find_table(estimate, "calibrated_range");
  if (!range || range->rows.size() != 1) return {};
  OutputModel model = accelerometer::over_temperature(estimate, cell(*range, 0, 0), cell(*range, 0, 1));
  if (find_parameter(estimate, "b_1") || find_parameter(estimate, "c_1"))
    model.reference_temperature = number_of(estimate, "report_temperature", "degC", 293.15);
  set_nominal(estimate, "scale_factor", {"mA", "V", "pulse/s"}, model);
  return {model};
}

std::vector<OutputModel> sdof_gyro(const Estimate& estimate) {
  auto terms = terms_of("sdof_gyro");
  terms.push_back({"drift_rate", "", "", "", Input::since_power_on});
  OutputModel model = output_model(estimate, "gyro", Input::rate_x, "deg/h", ranges_of(estimate, std::move(terms)));
  if (const double s = number_of(estimate, "torquer_scale_factor", "deg/h/mA", 0.0); s != 0.0)
    model.recorded = Unit::parse("mA"), model.nominal = s;
  return {model};
}

std::vector<OutputModel> scale_factor(const Estimate& estimate) {
  std::vector<Term> terms{{"bias", "", "", "", 1.0}, {"scale_factor_asymmetry", "", "", "", 0.5 * magnitude(w_x)}};
  if (const Table* powers = find_table(estimate, "odd_powers"))
    for (std::size_t r = 0; r < powers->rows.size(); ++r) {
      const int n = cell(*powers, r, 0) == 3.0 ? 3 : 5;
      terms.push_back({n == 3 ? "third_order_coefficient" : "fifth_order_coefficient", "", "", "",
                       std::pow(cell(*powers, r, 1), 1 - n) * power(w_x, n) - cell(*powers, r, 2) * Regressor(w_x)});
    }
  OutputModel model = output_model(estimate, "gyro", Input::rate_x, "deg/s", ranges_of(estimate, std::move(terms)));
  set_scale(estimate, "scale_factor", model);
  const Table *line = find_table(estimate, "line"), *residuals = find_table(estimate, "residuals");
  if (!line || line->rows.size() != 1 || !residuals || residuals->rows.size() < 3) return {model};
  MeasuredDepartures& measured = model.measured.emplace();
  measured.slope = cell(*line, 0, 0);
  measured.offset = measured.slope * cell(*line, 0, 1);
  for (std::size_t r = 0; r < residuals->rows.size(); ++r) {
    measured.input.push_back(cell(*residuals, r, 0));
    measured.departure.push_back(measured.slope * cell(*line, 0, 2) * cell(*residuals, r, 1));
  }
  return {model};
}

std::vector<OutputModel> static_bias(const Estimate& estimate) {
  const Parameter* bias = find_parameter(estimate, "bias");
  if (!bias) return {};
  const bool rate = bias->unit.dimension() == Unit::parse("deg/h").dimension();
  OutputModel model = output_model(estimate, "signal", rate ? Input::rate_x : Input::specific_force_x,
                                   rate ? "deg/h" : "ug", {{{"bias", "", "", "", 1.0}}, {1.0}, {1.0}});
  model.spread = parameter_index(estimate, "turn_on_repeatability");
  const Table* runs = find_table(estimate, "runs");
  if (runs && runs->rows.size() == 1) model.caveats.emplace_back("turn_on_change_not_included");
  if (const auto axis = setting(estimate, "axis"); axis.empty() || axis == "none")
    model.caveats.emplace_back("bias_of_one_attitude");
  return {model};
}

std::vector<OutputModel> fog(const Estimate& estimate) {
  const Table *range = find_table(estimate, "calibrated_range"), *misfit = find_table(estimate, "misfit");
  Settings constants;
  const double reference = number_of(estimate, "start_temperature_reference", "degC", 293.15);
  constants.set_number("start_temperature_reference", reference, Unit::parse("degC"));
  constants.set_word("form", setting(estimate, "form") == "raw" ? "raw" : "from_start");
  constants.set_number("startup_time", number_of(estimate, "startup_time", "s", 1.0), Unit::parse("s"));
  auto terms = terms_of("fiber_optic_gyro", constants);
  std::erase_if(terms, [](const Term& term) { return term.name.starts_with("bias_"); });
  OutputModel model = output_model(estimate, "gyro", Input::rate_x, "deg/h", ranges_of(estimate, std::move(terms)));
  if (misfit && !misfit->rows.empty()) model.misfit = cell(*misfit, misfit->rows.size() - 1, 1);
  model.thermal = {number_of(estimate, "smoothing", "s", 30.0), number_of(estimate, "sensor_lag", "s", 0.0),
                   number_of(estimate, "start_window", "s", 120.0), number_of(estimate, "averaging", "s", 100.0)};
  model.reference_temperature = reference;
  model.in_region = true;
  for (std::size_t r = 0; range && range->columns.size() == 6 && r < range->rows.size(); ++r) {
    Covered& covered = model.covered.emplace_back(Covered{{}, cell(*range, r, 4), cell(*range, r, 5), 0.0});
    std::size_t column = 0;
    for (const Input input :
         {Input::temperature, Input::temperature_gradient, Input::temperature_rate, Input::start_temperature})
      if (const double weight = cell(*range, r, column++); weight != 0.0) covered.weights.emplace_back(input, weight);
  }
  return {model};
}

std::vector<OutputModel> tuned_gyro(const Estimate& estimate) {
  const Settings constants = defaults(truth_options(find_model("dynamically_tuned_gyro")));
  double force = 0.0, low = infinity, high = -infinity;
  if (const Table* table = find_table(estimate, "nonlinearity"))
    for (std::size_t r = 0; r < table->rows.size(); ++r) {
      const auto* spin = std::get_if<std::string>(&table->rows[r].at(3));
      const double along = si(spin && *spin == "up" ? 1.0 : -1.0, "g");
      force = std::max(force, cell(*table, r, 2));
      low = std::min(low, along), high = std::max(high, along);
    }
  std::vector<OutputModel> models;
  for (const bool second : {false, true}) {
    const std::string prefix = second ? "y_" : "";
    if (!find_parameter(estimate, prefix + "D_x") || !find_parameter(estimate, prefix + "D_y")) continue;
    auto terms = terms_of("dynamically_tuned_gyro", constants, second);
    std::erase_if(terms, [&](const Term& term) { return term.name == prefix + "D_xy"; });
    const Regressor square = power(f_x, 2) + power(f_y, 2);
    terms.push_back({prefix + "p_4", "", "", "", f_x * (square * square)});
    terms.push_back({prefix + "q_4", "", "", "", f_y * (square * square)});
    models.push_back(output_model(estimate, second ? "gyro_y" : "gyro", second ? w_y : w_x, "deg/h",
                                  ranges_of(estimate, std::move(terms))));
    models.back().covered = {{{{f_x, 1.0}}, -force, force}, {{{f_y, 1.0}}, -force, force}, {{{f_z, 1.0}}, low, high}};
    models.back().in_region = true;
    models.back().caveats = {"even_drift_terms_remain"};
  }
  return models;
}

/// Greatest rates [rad/s] and specific forces [m/s^2] of the table `covered`.
std::pair<Vector3, Vector3> greatest(const Estimate& estimate) {
  std::pair<Vector3, Vector3> out;
  if (const Table* table = find_table(estimate, "covered"); table && table->rows.size() == 3)
    for (std::size_t i = 0; i < 3; ++i) out.first[i] = cell(*table, i, 1), out.second[i] = cell(*table, i, 2);
  return out;
}

std::vector<OutputModel> unit(const Estimate& estimate) {
  const auto [rate, force] = greatest(estimate);
  auto models = imu::models_of(estimate, [&](const Term& term, imu::Kind) {
    const TermRanges ranges = ranges_of(estimate, {term});
    return std::pair{ranges.least.front(), ranges.greatest.front()};
  });
  for (OutputModel& model : models) {
    imu::set_covered(rate, force, model);
    const bool gyro = static_cast<std::size_t>(model.shows) < 3;
    if (gyro && !model.scale) set_nominal(estimate, "gyro_scale_factor", {"pulse/s"}, model);
    if (!gyro && !model.scale) set_nominal(estimate, "accelerometer_scale_factor", {"pulse/s", "mA", "V"}, model);
  }
  return models;
}

/// u = M y - nabla: the outputs stand in the regressors with the other sign.
std::vector<OutputModel> channels(const Estimate& estimate) {
  auto models = unit(estimate);
  for (OutputModel& model : models) {
    model.by_output = true;
    for (ModelTerm& term : model.terms)
      if (!term.regressor.front().factors.empty()) term.regressor.front().weight = -1.0;
  }
  return models;
}

/// Sign of the diagonal of R in row `i`, which no parameter states: -1 where the table `matrices` has it so.
double sign_of_diagonal(const Estimate& estimate, bool gyro, std::size_t i) {
  const Table* table = find_table(estimate, "matrices");
  std::size_t row = 0;
  for (std::size_t r = 0; table && table->columns.size() == 6 && r < table->rows.size(); ++r) {
    const auto* of = std::get_if<std::string>(&table->rows[r].at(0));
    if (of && *of == (gyro ? "R_g" : "R_a") && row++ == i) return cell(*table, r, 3 + i) < 0.0 ? -1.0 : 1.0;
  }
  return 1.0;
}

std::vector<OutputModel> ferraris(const Estimate& estimate) {
  const auto [rate, force] = greatest(estimate);
  std::vector<OutputModel> models;
  for (const imu::Kind kind : imu::kinds)
    for (std::size_t i = 0; i < 3 && find_parameter(estimate, imu::role_of(kind, 0) + "_bias"); ++i)
      models.push_back(
          imu::directed_model(estimate, kind, i, sign_of_diagonal(estimate, kind == imu::Kind::gyro, i), rate, force));
  return models;
}

std::vector<OutputModel> north_finder(const Estimate& estimate) {
  std::vector<OutputModel> models;
  for (const auto& [role, first, axis] :
       {std::tuple{"gyro", w_x, 0u}, {"accelerometer_x", f_x, 0u}, {"accelerometer_y", f_x, 1u}}) {
    std::vector<Term> terms{{fmt::format("{}.bias", role), "", "", "", 1.0}};
    for (std::size_t j = 0; j < 3; ++j)
      if (j != axis) terms.push_back({fmt::format("{}.misalignment_{}", role, "xyz"[j]), "", "", "", along(first, j)});
    models.push_back(output_model(estimate, role, along(first, axis), first == w_x ? "deg/h" : "g",
                                  ranges_of(estimate, std::move(terms))));
    set_scale(estimate, fmt::format("{}.scale_factor", role), models.back());
  }
  return models;
}

using Reader = std::vector<OutputModel> (*)(const Estimate& estimate);

const std::map<std::string, Reader>& readers() {
  static const std::map<std::string, Reader> all{{"accelerometer_tumble", accelerometer},
                                                 {"accelerometer_centrifuge", accelerometer},
                                                 {"accelerometer_dynamic", accelerometer},
                                                 {"accelerometer_four_position", four_position},
                                                 {"sdof_gyro_static", sdof_gyro},
                                                 {"sdof_gyro_dynamic", sdof_gyro},
                                                 {"gyro_scale_factor", scale_factor},
                                                 {"static_bias", static_bias},
                                                 {"fog_thermal_bias", fog},
                                                 {"dtg_centrifuge", tuned_gyro},
                                                 {"imu_turntable", unit},
                                                 {"imu_multi_position", unit},
                                                 {"imu_channel_calibration", channels},
                                                 {"imu_ferraris", ferraris},
                                                 {"rlg_north_finder", north_finder}};
  return all;
}

}  // namespace

std::vector<OutputModel> legacy_models(const Estimate& estimate) {
  const auto reader = readers().find(estimate.method);
  if (reader == readers().end() || estimate.parameters.empty()) return {};
  try {
    return reader->second(estimate);
  } catch (const Error&) {  // a setting or a table that no version wrote: the result is as if it had no model
    return {};
  } catch (const std::exception&) {
    return {};
  }
}

}  // namespace tumble::error_model
