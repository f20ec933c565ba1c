#include <fmt/format.h>

#include <algorithm>

#include "tumble/methods/fog_thermal_bias/compensate.hpp"
#include "tumble/methods/fog_thermal_bias/describe.hpp"
#include "tumble/methods/fog_thermal_bias/findings.hpp"
#include "tumble/methods/fog_thermal_bias/range.hpp"
#include "tumble/methods/fog_thermal_bias/trial.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/error.hpp"

// Symbols of the source: L output, L_0 its mean over the first two minutes, T temperature, DT gradient
// (top minus side sensor), T_0 start temperature; A_i, B_j, C_k coefficients of T, DT and dT/dt, each a cubic in T_0:
//   L - L_0 = sum A_i (T - T_0)^i + sum B_j DT^j + sum C_k (dT/dt)^k                 (5.1)
//   a_i(T_0) = A_i0 + A_i1 T_0 + A_i2 T_0^2 + A_i3 T_0^3                             (5.3)
// Every run has a free level instead of L_0, whose noise would else go into the coefficients.

namespace tumble::fog_thermal_bias {
namespace {

std::vector<Role> roles() {
  return {{"gyro", "deg/h", true, "output of the gyro"},
          {"temperature", "degC", false, "temperature of the gyro, where there is one sensor"},
          {"temperature_top", "degC", false, "sensor on top of the gyro"},
          {"temperature_side", "degC", false, "sensor on its side; top minus side is the gradient"}};
}

std::vector<Option> options() {
  using Type = Option::Type;
  return {
      {"estimator",
       Type::word,
       "1",
       "joint",
       {"joint", "two_stage"},
       "one fit of all runs, or the source's fit of each run and then of the coefficients over start temperature"},
      {"order", Type::word, "1", "auto", {"auto", "1", "2", "3", "4"}, "highest power of T; auto: by held-out runs"},
      {"gradient_order", Type::word, "1", "auto", {"auto", "0", "1", "2"}, "highest power of the gradient"},
      {"rate_order", Type::word, "1", "auto", {"auto", "0", "1", "2"}, "highest power of dT/dt"},
      {"form",
       Type::word,
       "1",
       "from_start",
       {"from_start", "raw"},
       "powers of T - T_0, or of T in degC as the source writes"},
      {"start_temperature_power",
       Type::integer,
       "1",
       "3",
       {},
       "highest power of the start temperature in (5.3), 0 to 3"},
      {"start_temperature_reference",
       Type::quantity,
       "degC",
       "20 degC",
       {},
       "T_0 enters (5.3) as its difference from this"},
      {"start_window", Type::quantity, "s", "120 s", {}, "time after power-on whose means are L_0 and T_0"},
      {"startup_time", Type::quantity, "s", "", {}, "time constant of a start-up transient to be fitted; absent: none"},
      {"averaging", Type::quantity, "s", "100 s", {}, "length of the averages that are fitted and scored"},
      {"smoothing", Type::quantity, "s", "30 s", {}, "window of the local quadratic that smooths and differentiates T"},
      {"sensor_lag", Type::quantity, "s", "0 s", {}, "lag of the temperature sensors, taken out"},
      {"sensor_lag_sd", Type::quantity, "s", "0 s", {}, "its standard uncertainty"},
      {"hold_out", Type::integers, "1", "", {}, "runs kept out of the fit; they are only scored"}};
}

void refuse_impossible(const Evidence& evidence) {
  const Settings& settings = evidence.plan.settings;
  std::vector<std::string> problems;
  const int power = settings.integer("start_temperature_power");
  if (power < 0 || power > 3) problems.push_back("start_temperature_power must lie between 0 and 3");
  if (settings.word("estimator") == "two_stage" && settings.has("startup_time"))
    problems.push_back("estimator = \"two_stage\" has no start-up transient: leave startup_time out or use \"joint\"");
  for (const char* name : {"averaging", "smoothing", "start_window"})
    if (!(settings.number(name) > 0.0)) problems.push_back(fmt::format("{} must be positive", name));
  if (settings.has("startup_time") && !(settings.number("startup_time") > 0.0))
    problems.push_back("startup_time must be positive");
  for (const char* name : {"sensor_lag", "sensor_lag_sd"})
    if (!(settings.number(name) >= 0.0 && settings.number(name) <= 600.0))
      problems.push_back(fmt::format("{} must lie between 0 s and 600 s", name));
  if (settings.number("averaging") < 2.0 * settings.number("smoothing"))
    problems.push_back(
        fmt::format("averaging = {:.6g} s must be at least twice smoothing = {:.6g} s: in shorter averages the "
                    "noise of the temperature sensors pulls the coefficients towards zero",
                    settings.number("averaging"), settings.number("smoothing")));
  if (settings.number("smoothing") > 1800.0)
    problems.push_back("smoothing must not exceed 30 min: it would hide the ramps");
  if (settings.has("startup_time") && settings.number("startup_time") > 36000.0)
    problems.push_back("startup_time must not exceed 10 h: such a transient cannot be told from a level");
  const auto runs = runs_of(evidence.recordings);
  if (settings.has("hold_out"))
    for (const int held : settings.integers("hold_out"))
      if (std::ranges::find(runs, held, &Run::number) == runs.end())
        problems.push_back(fmt::format("hold_out: there is no run {} (the recordings hold runs {} to {})", held,
                                       runs.empty() ? 0 : runs.front().number, runs.empty() ? 0 : runs.back().number));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "fog_thermal_bias needs at least one recording");
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  refuse_impossible(evidence);
  const Settings& settings = evidence.plan.settings;
  const Model& model = find_model("fiber_optic_gyro");
  const auto terms = model.outputs(constants_of(settings))[0].terms;
  report(progress, 0.0, "averaging the runs");
  const Answer answer = solve(evidence, terms, settings.number("sensor_lag"), progress);
  Estimate estimate = describe(evidence, terms, answer);
  estimate.tables = {models_table(answer.candidates, answer.chosen, estimate),
                     runs_table(answer.runs, answer.candidates[answer.chosen], answer.fit), noise_table(answer.noise),
                     calibrated_range(answer.runs)};
  estimate.curves = residual_curves(answer.runs, answer.candidates[answer.chosen], answer.fit);
  estimate.findings = findings_of(answer.runs, answer.candidates, answer.chosen, answer.fit, answer.noise, settings,
                                  answer.not_used, terms);
  report(progress, 1.0, "done");
  return estimate;
}

Estimate predict(const Plan& plan) {
  // The uncertainty does not depend on the coefficients: a rehearsal with the instrument's noise gives it.
  Estimate estimate = identify({plan, {simulate(plan, 1, {})}}, {});
  for (auto& parameter : estimate.parameters)
    if (plan.truth.texts().contains(parameter.name)) parameter.value = plan.truth.number(parameter.name);
  return estimate;
}

}  // namespace

extern const Method fog_thermal_bias{
    .name = "fog_thermal_bias",
    .summary = "bias of a fibre-optic gyro over temperature, its gradient and its rate, with start temperature",
    .source = "Zhou Haiyuan et al., bias stability of a FOG by polynomial fitting, published 2018-04-04, eq. (1)-(3)",
    .needs_plan = false,
    .roles = roles,
    .options = options,
    .identify = identify,
    .trial = trial,
    .compensate = compensate,
    .predict = predict};

}  // namespace tumble::fog_thermal_bias
