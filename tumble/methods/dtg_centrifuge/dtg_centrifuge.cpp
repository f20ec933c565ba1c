#include <algorithm>
#include <cmath>

#include "tumble/math/parallel.hpp"
#include "tumble/methods/dtg_centrifuge/describe.hpp"
#include "tumble/methods/dtg_centrifuge/lag.hpp"
#include "tumble/methods/dtg_centrifuge/misfit.hpp"
#include "tumble/methods/dtg_centrifuge/outcome.hpp"
#include "tumble/methods/dtg_centrifuge/phases.hpp"
#include "tumble/methods/dtg_centrifuge/reference_line.hpp"
#include "tumble/methods/dtg_centrifuge/screen.hpp"
#include "tumble/methods/method.hpp"

// w_t rate of the arm, w_s of the table against it, w_n = w_t - w_s; theta = -table angle, beta = arm + table angle.
//   y = Re{Z e^{i theta}} + Re{E e^{i beta}} + ...          lines of each gyro by least squares         (1.12)
//   c = E_g/E_f,  Z_D = Z_g - conj(c) Z_f                   true rate at the table's angle subtracted
//   Z_D/F_X = p - i sigma q,  K = |Z_D|/a                   F_X = -a, sigma = +1: spin axis up          (1.10), (1.14)
//   p(a) = p_0 + p_2 a^2 + ..., q alike, zeta = K(a)/K(a_1) - 1                                         (1.13)

namespace tumble::dtg_centrifuge {
namespace {

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

/// What the line of the reference shows beside the true rate, where its sensitivity is not fitted.
void report_line(const ReferenceLine& line, bool both_late, Findings& findings) {
  using Cause = ReferenceLine::Cause;
  using Severity = Finding::Severity;
  const Unit unit = Unit::parse("deg/h/g");
  const Sensitivity& s = line.sensitivity;
  const std::vector<FindingValue> late{{"late", line.late, "ms"}, {"sd", line.late_sd, "ms"}};
  const std::vector<FindingValue> feels{
      {"x", -s.v.real(), unit}, {"y", s.v.imag(), unit}, {"sd", s.sd, unit}, {"late", line.late, "ms"}};
  if (line.cause == Cause::late)
    findings.push_back({Severity::warning, both_late ? "gyros_late_on_angles" : "reference_late_on_angles", late,
                        both_late ? "" : "reference_gyro"});
  if (line.cause == Cause::sensitive)
    findings.push_back({Severity::warning, "reference_sensitive_to_force", feels, "reference_gyro"});
  if (line.cause == Cause::either)
    findings.push_back({Severity::warning, "reference_late_or_sensitive", feels, "reference_gyro"});
  if (line.cause == Cause::beside)
    findings.push_back(
        {Severity::error, "line_beside_force", {{"size", std::abs(line.beside), "deg/h"}}, "reference_gyro"});
}

/// The sensitivity of the reference where it is to be subtracted.
void report_fitted(const Sensitivity& s, Findings& findings) {
  if (!s.known) {
    findings.push_back({Finding::Severity::warning, "too_few_levels_for_sensitivity", {}, "reference_gyro"});
    return;
  }
  const Unit unit = Unit::parse("deg/h/g");
  findings.push_back({Finding::Severity::info,
                      "reference_sensitivity_subtracted",
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

/// The lines without the lag of the reference gyro, and a finding of what its line shows. What a lag and a sensitivity explain alike
/// is a lag where the gyro under test has the same. Sets whether it has.
std::vector<Measured> with_line(const Task& task, ReferenceLine& line, bool& late_alike, std::vector<Measured> measured,
                                Findings& findings) {
  using Cause = ReferenceLine::Cause;
  const bool late = line.cause == Cause::late || line.cause == Cause::either;
  late_alike = late && line.droop == 0.0 && line.filter.stages == 0 && task.loop_stated() &&
               has_lag_of_reference(task, without_lag(measured, line));
  if (late_alike) line.cause = Cause::late;
  report_line(line, late_alike, findings);
  return line.cause == Cause::late ? without_lag(std::move(measured), line) : std::move(measured);
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  const Settings& settings = evidence.plan.settings;
  const bool fourier = settings.word("estimator") == "fourier";
  Test test = test_of(evidence);
  const Instruments instruments = instruments_of(settings);
  std::vector<Measured> measured(test.levels.size());
  parallel_for(measured.size(), [&](std::size_t i) { measured[i] = measure(test, test.levels[i], instruments); });
  report(progress, 0.7, "lines");
  Estimate estimate;
  estimate.findings = test.findings;
  if (test.encoders) assign_levels(test, measured, estimate.findings);
  measured = screened(std::move(measured), test, fourier, estimate.findings);
  add_missing_rests(test, fourier, estimate.findings);
  if (!fourier) check_earth(measured, test, estimate.findings);
  if (test.encoders && !fourier) check_turn(measured, estimate.findings);
  const Reduction reduction = reduction_of(test, measured);
  check_forces(test, measured, reduction, estimate.findings);
  const Cells cells = cells_of(test, measured, reduction);
  const auto shifts = shifts_of(test, cells.stretch, cells.nominal);
  report(progress, 0.9, "errors of the rig");
  const bool fitted = settings.word("reference_sensitivity") == "fitted";
  ReferenceLine line = test.encoders && !fourier ? reference_line_of(measured, reduction) : ReferenceLine{};
  check_exchange(line, measured, reduction, estimate.findings);
  const Sensitivity sensitivity = fitted ? line.sensitivity : Sensitivity{};
  if (fitted) {
    report_fitted(sensitivity, estimate.findings);
    line.cause = ReferenceLine::Cause::none;
  }
  bool late_alike = false;
  const auto task_of = [&](Signal output) {
    return Task{test,
                reduction,
                cells,
                shifts,
                settings,
                sensitivity,
                line,
                late_alike,
                output,
                fourier,
                test.encoders && !fourier};
  };
  measured = with_line(task_of(gyro), line, late_alike, std::move(measured), estimate.findings);
  Ledger ledger;
  for (const Signal output : {gyro, gyro_y}) {
    const bool present = std::ranges::all_of(measured, [&](const Measured& m) { return m.of[output].present; });
    if (output == gyro_y && (!present || fourier || !test.encoders)) continue;
    const Outcome outcome = outcome_of(task_of(output), measured, estimate.findings);
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
