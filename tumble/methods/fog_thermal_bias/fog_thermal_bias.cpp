#include <fmt/format.h>

#include <algorithm>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/methods/fog_thermal_bias/describe.hpp"
#include "tumble/methods/fog_thermal_bias/findings.hpp"
#include "tumble/methods/fog_thermal_bias/range.hpp"
#include "tumble/methods/fog_thermal_bias/stuck_sensors.hpp"
#include "tumble/methods/fog_thermal_bias/surface.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/reduce/output_model.hpp"
#include "tumble/units/error.hpp"

// Symbols of the source: L output, L_0 its mean over the first two minutes, T temperature, DT gradient
// (top minus side sensor), T_0 start temperature; A_i, B_j, C_k coefficients of T, DT and dT/dt, each a cubic in T_0:
//   L - L_0 = sum A_i (T - T_0)^i + sum B_j DT^j + sum C_k (dT/dt)^k                 (5.1)
//   a_i(T_0) = A_i0 + A_i1 T_0 + A_i2 T_0^2 + A_i3 T_0^3                             (5.3)
// Every run has a free level instead of L_0, so that the noise of L_0 does not enter the coefficients.

namespace tumble::fog_thermal_bias {
namespace {

std::vector<Role> roles() {
  return {{"gyro", "deg/h", true, "output of the gyro"},
          {"temperature", "degC", false, "temperature of the gyro, where there is one sensor"},
          {"temperature_top", "degC", false, "sensor on top of the gyro"},
          {"temperature_side", "degC", false, "sensor on its side; top minus side is the gradient"}};
}

std::vector<Option> options() {
  return {
      word("estimator", {"joint", "two_stage"})
          .otherwise("joint")
          .says("one fit of all runs, or the source's fit of each run and then of the coefficients over start "
                "temperature"),
      word("order", {"auto", "1", "2", "3", "4"}).otherwise("auto").says("highest power of T; auto: by AICc"),
      word("gradient_order", {"auto", "0", "1", "2"}).otherwise("auto").says("highest power of the gradient"),
      word("rate_order", {"auto", "0", "1", "2"}).otherwise("auto").says("highest power of dT/dt"),
      word("form", {"from_start", "raw"})
          .otherwise("from_start")
          .says("powers of T - T_0, or of T in degC as the source writes"),
      integer("start_temperature_power")
          .between(0, 3)
          .otherwise("3")
          .says("highest power of the start temperature in (5.3)"),
      quantity("start_temperature_reference", "degC")
          .otherwise("20 degC")
          .says("temperature that is subtracted from T_0 in (5.3)"),
      quantity("start_window", "s")
          .above(0)
          .otherwise("120 s")
          .says("time after power-on over which L_0 and T_0 are averaged"),
      quantity("startup_time", "s")
          .above(0)
          .at_most(36000)
          .says("time constant of a start-up transient, which is fitted with the drift; a longer one cannot be "
                "distinguished from a level; absent: no transient"),
      quantity("averaging", "s").above(0).otherwise("100 s").says("length of the averages that are fitted and scored"),
      quantity("smoothing", "s")
          .above(0)
          .at_most(1800)
          .otherwise("30 s")
          .says("window of the local quadratic that smooths and differentiates T; a longer one hides the ramps"),
      quantity("sensor_lag", "s")
          .between(0, 600)
          .otherwise("0 s")
          .says("lag of the temperature sensors, which is corrected"),
      quantity("sensor_lag_sd", "s").between(0, 600).otherwise("0 s").says("standard uncertainty of sensor_lag"),
      integers("hold_out").says("runs that are not fitted, only scored; absent: all runs are fitted")};
}

void refuse_impossible(const Evidence& evidence) {
  const Settings& settings = evidence.plan.settings;
  Problems problems;
  if (settings.word("estimator") == "two_stage" && settings.has("startup_time"))
    problems.push_back("estimator = \"two_stage\" has no start-up transient: remove startup_time or use \"joint\"");
  if (settings.number("averaging") < 2.0 * settings.number("smoothing"))
    problems.push_back(
        say("averaging = {:.6g} s must be at least twice smoothing = {:.6g} s: in shorter averages the "
            "noise of the temperature sensors pulls the coefficients towards zero",
            settings.number("averaging"), settings.number("smoothing")));
  const auto runs = runs_of(evidence.recordings);
  if (settings.has("hold_out"))
    for (const int held : settings.integers("hold_out"))
      if (std::ranges::find(runs, held, &Run::number) == runs.end())
        problems.push_back(say("hold_out: there is no run {} (the recordings hold runs {} to {})", held,
                               runs.empty() ? 0 : runs.front().number, runs.empty() ? 0 : runs.back().number));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "fog_thermal_bias needs at least one recording");
}

/// L_c = L - sum a_i(T_0) phi_i, docs/equations (5.4): the level at power-on stays, and each power-up has its own T_0.
OutputModel model_of(const std::vector<Term>& terms, const Answer& answer, const Settings& settings,
                     const Estimate& estimate) {
  std::vector<Term> drift = terms;
  for (std::size_t j = 0; j < terms.size(); ++j)  // the powers of the temperature at power-on
    std::erase_if(drift, [&](const Term& term) { return term.name == fmt::format("bias_{}", j); });
  std::vector<Felt> felt;
  each_average(answer.runs, [&](const RunData& run, std::size_t k) { felt.push_back(run.felt[k]); });
  TermRanges ranges = ranges_over(std::move(drift), felt);
  for (std::size_t j = 0; j < ranges.terms.size(); ++j)  // an average has no time since power-on
    if (ranges.terms[j].name == "startup_transient") ranges.least[j] = 0.0, ranges.greatest[j] = 1.0;
  OutputModel model = output_model(estimate, "gyro", Input::rate_x, "deg/h", ranges);
  model.misfit = answer.misfit.predicted;
  model.thermal = reading_of(settings, settings.number("sensor_lag"));
  model.covered = covered(answer.runs);
  model.in_region = true;
  model.reference_temperature = settings.number("start_temperature_reference");
  return model;
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
                     runs_table(answer.runs, answer.columns, answer.fit), noise_table(answer.noise),
                     misfit_table(answer.misfit)};
  estimate.models = {model_of(terms, answer, settings, estimate)};
  const std::size_t coefficients = answer.columns.size();
  for (auto& table : thermal_surface(terms, answer, block(estimate.covariance, 0, coefficients, 0, coefficients),
                                     settings.number("start_temperature_reference")))
    estimate.tables.push_back(std::move(table));
  estimate.curves = residual_curves(answer.runs, answer.columns, answer.fit);
  for (const Findings& findings : {findings_of(answer, settings), stuck_sensors(evidence)})
    estimate.findings.insert(estimate.findings.begin(), findings.begin(), findings.end());
  report(progress, 1.0, "done");
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
    .compensates = true};

}  // namespace tumble::fog_thermal_bias
