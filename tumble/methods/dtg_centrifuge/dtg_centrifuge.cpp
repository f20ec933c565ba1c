#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "tumble/math/parallel.hpp"
#include "tumble/methods/dtg_centrifuge/describe.hpp"
#include "tumble/methods/dtg_centrifuge/fourier.hpp"
#include "tumble/methods/dtg_centrifuge/lag.hpp"
#include "tumble/methods/dtg_centrifuge/misfit.hpp"
#include "tumble/methods/dtg_centrifuge/screen.hpp"
#include "tumble/methods/method.hpp"

// w_t rate of the arm, w_s of the table against it, w_n = w_t - w_s; theta = -table angle, beta = arm + table angle.
//   y = Re{Z e^{i theta}} + Re{E e^{i beta}} + ...          lines of each gyro by least squares         (1.12)
//   c = E_g/E_f,  Z_D = Z_g - conj(c) Z_f                   true rate at the table's angle subtracted
//   Z_D/F_X = p - i sigma q,  K = |Z_D|/a                   F_X = -a, sigma = +1: spin axis up          (1.10), (1.14)
//   p(a) = p_0 + p_2 a^2 + ..., q alike, zeta = K(a)/K(a_1) - 1                                         (1.13)

namespace tumble::dtg_centrifuge {
namespace {

constexpr int most_rounds_of_lag = 6;
constexpr double lag_settled = 1e-3;  ///< [sd] of a change of the lag, after which no further round follows
/// [sd] from which on a lag or a sensitivity that the levels show contradicts what is stated: p = 6e-7.
constexpr double contradicts = 5.0;
constexpr double least_lag = 1e-5;  ///< [s] chosen: far less than the lag of any loop
/// [1] of a line, that the rate which remains in it must reach to be a finding.
constexpr double least_true_rate = 1e-3;

std::vector<Role> roles() {
  return {{"gyro", "deg/h", true, "output X of the gyro under test"},
          {"reference_gyro", "deg/h", true, "fibre-optic gyro on the same fixture, its input axis along X"},
          {"gyro_y", "deg/h", false, "output Y of the gyro under test"},
          {"table_angle", "deg", false, "angle of the table against the arm, counter-clockwise seen from above"},
          {"arm_angle", "deg", false, "angle of the arm, counter-clockwise seen from above"},
          {"specific_force_x", "g", false, "for compensate: specific force along X where the gyro is used"},
          {"specific_force_y", "g", false, "for compensate: along Y"},
          {"specific_force_z", "g", false, "for compensate: along the spin axis Z"}};
}

/// Options of the capture loop and of the averaging of one gyro.
void add_electronics(const std::string& prefix, std::vector<Option>& options) {
  const std::string whose = prefix.empty() ? "the gyro" : "the reference gyro";
  options.push_back(quantity(prefix + "averaging", "s")
                        .at_least(0)
                        .says("time over which a sample of " + whose +
                              " is averaged, docs/equations (1.15); absent: one sampling interval"));
  options.push_back(
      quantity(prefix + "natural_frequency", "Hz")
          .above(0)
          .says("natural frequency of the capture loop of " + whose + "; absent: the loop is not of second order"));
  options.push_back(quantity(prefix + "damping_ratio").above(0).otherwise("0.7").says("damping ratio of that loop"));
  options.push_back(quantity(prefix + "time_constant", "s")
                        .at_least(0)
                        .says("time constant of a capture loop of first order of " + whose +
                              "; 0 s: the output has no lag" +
                              (prefix.empty() ? "; absent, like natural_frequency: the lag is estimated" : "")));
}

void add_reference(std::vector<Option>& options) {
  const std::vector<Option> own{
      quantity("reference_gain")
          .above(0)
          .otherwise("1")
          .says("scale factor of the reference gyro over that of the gyro, from another test; used if "
                "reference_gain_sd is given"),
      quantity("reference_gain_sd", "ppm")
          .at_least(0)
          .says("standard uncertainty of reference_gain; absent: only the Earth's rate determines the gain"),
      quantity("reference_azimuth", "deg")
          .otherwise("0 deg")
          .says("angle from X toward Y to the input axis of the reference gyro; used if reference_azimuth_sd is given"),
      quantity("reference_azimuth_sd", "deg")
          .at_least(0)
          .says("standard uncertainty of reference_azimuth; absent: only the Earth's rate determines the azimuth"),
      word("reference_sensitivity", {"zero", "fitted"})
          .otherwise("zero")
          .says("sensitivity of the reference gyro to specific force: zero, or fitted to its line over the levels")};
  options.insert(options.end(), own.begin(), own.end());
}

std::vector<Option> options() {
  std::vector<Option> options{
      word("estimator", {"regression", "fourier"})
          .otherwise("regression")
          .says("regression on the angles, which subtracts the true rate, docs/equations (1.12)-(1.15), or the "
                "source's steps, docs/equations (1.6)-(1.11)"),
      word("order", {"auto", "constant", "cubic", "quintic"})
          .otherwise("auto")
          .says("order of the drift in specific force, docs/equations (1.13); auto: the highest that the levels can "
                "carry, cubic with two or three levels and quintic with four or more"),
      quantity("settling", "s")
          .at_least(0)
          .otherwise("1 s")
          .says("time after the rig has settled that is skipped in each segment")};
  add_electronics("", options);
  options.push_back(quantity("loop_lag_sd", "%")
                        .at_least(0)
                        .otherwise("1 %")
                        .says("relative standard uncertainty of the lag of the gyro's loop"));
  options.push_back(quantity("scale_factor_sd", "ppm")
                        .at_least(0)
                        .otherwise("0 ppm")
                        .says("standard uncertainty of the gyro's scale factor"));
  add_reference(options);
  add_electronics("reference_", options);
  options.push_back(
      quantity("reference_clock_offset", "s").otherwise("0 s").says("delay of the stamps of the reference gyro"));
  options.push_back(quantity("reference_clock_offset_sd", "s")
                        .at_least(0)
                        .otherwise("0 s")
                        .says("standard uncertainty of reference_clock_offset"));
  options.push_back(word("encoder_stamps", {"begin", "instant"})
                        .otherwise("begin")
                        .says("time of an angle: the middle of the interval that begins at its stamp, as `tumble "
                              "simulate` writes it (begin), or its stamp (instant)"));
  return options;
}

/// A cell: one level in one sense in one plan, alike in every power-up.
struct Cells {
  std::vector<const Spin*> stretch;
  std::vector<RigLines> nominal;
  std::vector<std::size_t> of;  ///< of each measured
};

Cells cells_of(const Test& test, const std::vector<Measured>& measured, const Reduction& reduction) {
  Cells out;
  std::map<std::tuple<const Plan*, std::size_t, double>, std::size_t> known;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const Spin& s = *measured[i].stretch;
    const auto [cell, fresh] =
        known.try_emplace({test.power_ups[s.power_up].plan, reduction.level_of[i], s.arm_rate}, out.stretch.size());
    out.of.push_back(cell->second);
    if (!fresh) continue;
    out.stretch.push_back(&s);
    out.nominal.push_back(reduction.nominal[i]);
  }
  return out;
}

int powers_of(const Settings& settings) {
  const std::string& order = settings.word("order");
  return order == "auto" ? -1 : order == "constant" ? 0 : order == "cubic" ? 1 : 2;
}

/// What the reduction of one output starts from.
struct Task {
  const Test& test;
  const Reduction& reduction;
  const Cells& cells;
  const std::vector<RigLinesShift>& shifts;
  const Settings& settings;
  const Sensitivity& sensitivity;
  Signal output;
  bool fourier, phase_known;
};

/// One output with lines that are corrected for the lag given.
Outcome with_lag(const Task& task, const std::vector<Measured>& measured, const Lag& lag, Findings& findings) {
  const Settings& settings = task.settings;
  Outcome out{.output = task.output,
              .take = task.phase_known ? Take::both_parts : Take::size,
              .corrected = !task.fourier,
              .lag = lag};
  out.power_ups = task.test.starts;
  const auto given = [&](const char* name) { return settings.has(name) ? settings.number(name) : 0.0; };
  out.relation = task.fourier
                     ? Relation{0.0, 0.0, given("reference_gain_sd"), given("reference_azimuth_sd"), false, 0.0}
                     : relation_of(measured, task.output, settings, task.test.encoders, findings);
  const Complex own = task.sensitivity.known ? task.sensitivity.v : 0.0;
  std::vector<std::size_t> cell_of;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    if (!measured[i].of[task.output].present || !measured[i].of[reference].present) continue;
    out.observations.push_back(
        task.fourier ? fourier_observation(task.test, measured[i], task.reduction, i, out.relation)
                     : observe(measured[i], task.reduction, i, task.output, out.relation, own, task.phase_known));
    cell_of.push_back(task.cells.of[i]);
  }
  const Circumstances around{task.test,        measured,    task.reduction,   settings,     out.relation,
                             task.sensitivity, task.output, task.phase_known, task.fourier, out.lag};
  auto effects = rig_effects(around, out.observations, task.shifts, cell_of, task.cells.nominal, task.cells.stretch);
  for (auto& effect : instrument_effects(around, out.observations)) effects.push_back(std::move(effect));
  const std::size_t levels = task.reduction.levels.size();
  out.levels = fit_levels(out.observations, effects, levels, out.take, !task.fourier,
                          lag.quantity ? lag_column(around, out.observations, lag.value) : LagColumn{}, findings);
  double values = 0.0;
  for (const auto& o : out.observations) values += static_cast<double>(o.part.size()) * (task.phase_known ? 2.0 : 1.0);
  out.polynomial = polynomial_of(out.levels, task.reduction.levels, out.take, powers_of(settings), values);
  out.feigned_azimuth = task.fourier ? 0.0 : lag.sd * azimuth_of_lag(around, out.observations);
  if (!task.phase_known) return out;
  out.second = fit_harmonic(out.observations, effects, 2);
  out.third = fit_harmonic(out.observations, effects, 3);
  return out;
}

/// The lag by the levels, found in a few rounds because it turns the lines by a finite angle.
Lag estimated_lag(const Task& task, const std::vector<Measured>& measured) {
  Lag lag{.stated = false, .quantity = true, .value = 0.0, .sd = usual_lag};
  for (int round = 0; round < most_rounds_of_lag; ++round) {
    Findings unused;
    const Outcome outcome = with_lag(task, without_lag(measured, task.output, lag.value), lag, unused);
    const LagFit more = lag_of(outcome.levels, outcome.polynomial);
    lag.value += more.value;
    lag.sd = more.sd;
    if (std::abs(more.value) < lag_settled * more.sd) break;
  }
  return lag;
}

/// A loop that is stated and that the levels contradict.
void check_lag(const Task& task, const std::vector<Measured>& measured, Findings& findings) {
  Findings unused;
  const Outcome outcome = with_lag(task, measured, {.stated = true, .quantity = true}, unused);
  const LagFit more = lag_of(outcome.levels, outcome.polynomial);
  if (std::abs(more.value) < contradicts * more.sd || std::abs(more.value) < least_lag) return;
  findings.push_back({Finding::Severity::warning,
                      "loop_lag_differs",
                      {{"difference", more.value, "ms"}, {"sd", more.sd, "ms"}},
                      task.output == gyro ? "gyro" : "gyro_y"});
}

/// Everything of one output.
Outcome outcome_of(const Task& task, const std::vector<Measured>& measured, Findings& findings) {
  Findings unused;
  check_relation(relation_of(measured, task.output, task.settings, task.test.encoders, unused), task.output,
                 task.settings, findings);
  const bool stated = task.settings.has("natural_frequency") || task.settings.has("time_constant");
  if (stated || task.fourier) {
    if (task.phase_known) check_lag(task, measured, findings);
    return with_lag(task, measured, {}, findings);
  }
  const Lag lag = task.phase_known ? estimated_lag(task, measured) : Lag{.stated = false, .sd = usual_lag};
  return with_lag(task, without_lag(measured, task.output, lag.value), lag, findings);
}

void add_sensitivity(const Sensitivity& s, bool fitted, Findings& findings) {
  if (!s.known) {
    if (fitted)
      findings.push_back({Finding::Severity::warning, "too_few_levels_for_sensitivity", {}, "reference_gyro"});
    return;
  }
  if (!fitted && std::abs(s.v) < contradicts * s.sd) return;
  const Unit unit = Unit::parse("deg/h/g");
  findings.push_back({fitted ? Finding::Severity::info : Finding::Severity::warning,
                      fitted ? "reference_sensitivity_subtracted" : "reference_sensitive_to_force",
                      {{"x", -s.v.real(), unit}, {"y", s.v.imag(), unit}, {"sd", s.sd, unit}},
                      "reference_gyro"});
}

void add_missing_rests(const Test& test, bool fourier, Findings& findings) {
  std::vector<bool> rested(test.starts, false);
  for (const Spin& rest : test.rests) rested[rest.start] = true;
  const auto missing = std::ranges::count(rested, false);
  if (missing == 0) return;
  findings.push_back({fourier ? Finding::Severity::warning : Finding::Severity::info,
                      fourier ? "mean_of_level_replaces_rest" : "no_static_segment",
                      {{"missing", missing}, {"power_ups", test.starts}}});
}

/// True rate that the plain difference of the source does not subtract, by the reference gyro's line of the Earth's
/// rate.
void add_remaining_rate(const std::vector<Measured>& measured, const Outcome& outcome, const Settings& settings,
                        bool encoders, Findings& findings) {
  Findings unused;
  const Relation relation = relation_of(measured, gyro, settings, encoders, unused);
  double worst = 0.0;
  for (const Observation& o : outcome.observations) {
    const Complex c = std::conj(relation.c(measured[o.measured].stretch->spin_up));
    worst = std::max(worst, std::abs((c - 1.0) * o.true_rate / o.force / o.value));
  }
  if (!relation.from_earth || worst < least_true_rate) return;
  findings.push_back({Finding::Severity::warning,
                      "true_rate_remains",
                      {{"gain", std::exp(-relation.log_gain) - 1.0, "%"},
                       {"azimuth", relation.azimuth, "deg"},
                       {"share", worst, "%"}}});
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  const Settings& settings = evidence.plan.settings;
  const bool fourier = settings.word("estimator") == "fourier";
  const Test test = test_of(evidence);
  const Instruments instruments = instruments_of(settings);
  std::vector<Measured> measured(test.levels.size());
  parallel_for(measured.size(), [&](std::size_t i) { measured[i] = measure(test, test.levels[i], instruments); });
  report(progress, 0.7, "lines");
  Estimate estimate;
  estimate.findings = test.findings;
  measured = screened(std::move(measured), test, fourier, estimate.findings);
  add_missing_rests(test, fourier, estimate.findings);
  if (!fourier) check_earth(measured, test, estimate.findings);
  const Reduction reduction = reduction_of(test, measured);
  check_forces(test, measured, reduction, estimate.findings);
  const Cells cells = cells_of(test, measured, reduction);
  const auto shifts = shifts_of(test, cells.stretch, cells.nominal);
  report(progress, 0.9, "errors of the rig");
  Sensitivity sensitivity = test.encoders && !fourier ? sensitivity_of(measured, reduction) : Sensitivity{};
  const bool fitted = settings.word("reference_sensitivity") == "fitted";
  add_sensitivity(sensitivity, fitted, estimate.findings);
  if (!fitted) sensitivity.known = false;
  Ledger ledger;
  for (const Signal output : {gyro, gyro_y}) {
    const bool present = std::ranges::all_of(measured, [&](const Measured& m) { return m.of[output].present; });
    if (output == gyro_y && (!present || fourier || !test.encoders)) continue;
    const Task task{test, reduction, cells, shifts, settings, sensitivity, output, fourier, test.encoders && !fourier};
    const Outcome outcome = outcome_of(task, measured, estimate.findings);
    check_levels(outcome, reduction.levels, estimate.findings);
    if (fourier) add_remaining_rate(measured, outcome, settings, test.encoders, estimate.findings);
    describe(outcome, measured, reduction, ledger, estimate);
  }
  ledger.settle(estimate);
  estimate.models = models_of(estimate, reduction.levels);
  report(progress, 1.0, "done");
  return estimate;
}

}  // namespace

extern const Method dtg_centrifuge{
    .name = "dtg_centrifuge",
    .summary =
        "specific-force-sensitive drift of a tuned gyro and its nonlinearity on a centrifuge with a table that "
        "turns against it",
    .source =
        "CN102636185A, 2012, steps 1-9 of the claim; GUM (JCGM 100:2008); Patterson and Thompson, Biometrika 58, 1971",
    .needs_plan = true,
    .roles = roles,
    .options = options,
    .identify = identify,
    .compensates = true};

}  // namespace tumble::dtg_centrifuge
