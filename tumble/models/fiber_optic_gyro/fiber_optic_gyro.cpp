#include <fmt/format.h>

#include <cmath>

#include "tumble/core/attempt.hpp"
#include "tumble/models/electronics/stages.hpp"
#include "tumble/models/fiber_optic_gyro/coil.hpp"
#include "tumble/models/given/given.hpp"
#include "tumble/models/model.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::fiber_optic_gyro {
namespace {

using namespace given;
using Input::w_x, Input::w_y, Input::w_z, Input::f_x, Input::f_y, Input::f_z;

constexpr int highest_power = 4;  ///< of T, source test
constexpr int highest_pair = 2;   ///< of gradient and rate
constexpr int start_powers = 4;   ///< cubic in the start temperature, docs/equations (5.3)

std::vector<Option> constants() {
  std::vector<Option> options{
      quantity("start_temperature_reference", "degC")
          .otherwise("20 degC")
          .says("reference of the start temperature in docs/equations (5.3)"),
      word("form", {"from_start", "raw"})
          .otherwise("from_start")
          .says("powers of T - T_0 (from_start), or of T in degC as the source writes them (raw)"),
      quantity("startup_time", "s").above(0).otherwise("5 min").says("time constant of the start-up transient"),
      quantity("time_constant", "s")
          .above(0)
          .says("time constant of a loop of first order; give natural_frequency for second order")};
  for (auto& part : {coil_options(), electronics::loop_options(), electronics::limit_options("deg/s")})
    options.insert(options.end(), part.begin(), part.end());
  return options;
}

std::string symbol_of(char letter, int i, int j) { return fmt::format("{}_{}{}", letter, i, j); }

std::string power(const std::string& what, int n) { return n == 1 ? what : fmt::format("{}^{}", what, n); }

std::string in_words(const std::string& what, int i, int j) {
  const std::string start = j == 0 ? "" : ", " + power("start temperature", j);
  return "coefficient of " + power(i > 1 ? "(" + what + ")" : what, i) + start;
}

/// coefficient i of a power series in x, power j of the start temperature
void append_series(std::vector<Term>& terms, char letter, int highest, const std::string& unit_of_x,
                   const std::string& what, double reference, const Regressor& x) {
  for (int i = 1; i <= highest; ++i)
    for (int j = 0; j < start_powers; ++j) {
      std::string unit = "deg/h";
      for (int k = 0; k < i && unit_of_x != "K"; ++k) unit += "/" + unit_of_x;
      const int kelvins = unit_of_x == "K" ? i + j : j;
      if (kelvins == 1) unit += "/K";
      if (kelvins > 1) unit += fmt::format("/K^{}", kelvins);
      terms.push_back({fmt::format("{}{}_{}", letter, i, j), symbol_of(letter, i, j), unit, in_words(what, i, j),
                       power(x, i) * power(from(Input::start_temperature, reference), j)});
    }
}

/// scale factor, misalignments and sensitivity to specific force: x = the input axis, y and z across it
void append_input_terms(std::vector<Term>& table) {
  table.push_back({"scale_factor_error", "dS", "ppm", "relative error of the nominal scale factor", w_x});
  table.push_back({"gamma_y", "gamma_y", "arcsec", "angle of the input axis toward y", w_y});
  table.push_back({"gamma_z", "gamma_z", "arcsec", "angle of the input axis toward z", w_z});
  table.push_back({"D_x", "D_x", "deg/h/g", "drift per specific force along the input axis", f_x});
  table.push_back({"D_y", "D_y", "deg/h/g", "drift per specific force along y", f_y});
  table.push_back({"D_z", "D_z", "deg/h/g", "drift per specific force along z", f_z});
}

std::vector<Term> terms(const Settings& constants) {
  const double reference = constants.number("start_temperature_reference");
  const bool raw = constants.word("form") == "raw";
  const double startup_time = constants.number("startup_time");
  constexpr double zero_celsius = 273.15;  // the source's T is in degC: powers of it depend on where zero is
  std::vector<Term> table;
  for (int j = 0; j < start_powers; ++j)
    table.push_back({fmt::format("bias_{}", j), fmt::format("L_0{}", j),
                     j == 0   ? "deg/h"
                     : j == 1 ? "deg/h/K"
                              : fmt::format("deg/h/K^{}", j),
                     "bias at power-on" + (j == 0 ? std::string() : ", " + power("start temperature", j)),
                     power(from(Input::start_temperature, reference), j)});
  append_series(table, 'A', highest_power, "K", raw ? "T" : "T - T_0", reference,
                raw ? from(Input::temperature, zero_celsius) : from_start(Input::temperature));
  append_series(table, 'B', highest_pair, "K", "temperature gradient", reference, Input::temperature_gradient);
  append_series(table, 'C', highest_pair, "(K/s)", "temperature rate", reference, Input::temperature_rate);
  table.push_back({"startup_transient", "E", "deg/h", "exp(-t/startup_time) since power-on",
                   decay(Input::since_power_on, startup_time)});
  append_input_terms(table);
  return table;
}

std::vector<Output> outputs(const Settings& constants) {
  return {{.channel = "gyro",
           .kind = QuantityKind::angular_rate,
           .unit = "deg/h",
           .input = w_x,
           .terms = terms(constants)}};
}

/// The closed loop, what limits its output, and the coil that heat goes through.
Recorded record(const Settings& truth, std::size_t, double step, const RandomStream&) {
  Problems problems;
  std::vector<Response> stages{attempt(problems, [&] { return electronics::loop(truth, step); }),
                               attempt(problems, [&] { return electronics::limits(truth); })};
  auto history = attempt(problems, [&] { return coil_drift(truth, step); });
  refuse(std::move(problems));
  return {.kind = QuantityKind::angular_rate,
          .unit = "deg/h",
          .response = electronics::in_series(std::move(stages)),
          .history = std::move(history)};
}

}  // namespace

extern const Model fiber_optic_gyro{
    .name = "fiber_optic_gyro",
    .summary =
        "fibre-optic gyro: bias over temperature, its gradient and rate, start-up, heat in the coil, closed loop",
    .source =
        "Zhou Haiyuan et al., published 2018-04-04, eq. (1)-(3); Yan Gongmin, lecture on modelling gyros and "
        "accelerometers, NWPU, 2015, slides 57-58; IEEE Std 528 names",
    .constants = constants,
    .outputs = outputs,
    .record = record};

}  // namespace tumble::fiber_optic_gyro
