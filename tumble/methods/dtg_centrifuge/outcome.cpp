#include "tumble/methods/dtg_centrifuge/outcome.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "tumble/methods/dtg_centrifuge/causes.hpp"
#include "tumble/methods/dtg_centrifuge/fourier.hpp"
#include "tumble/methods/dtg_centrifuge/lag.hpp"
#include "tumble/methods/dtg_centrifuge/misfit.hpp"

namespace tumble::dtg_centrifuge {
namespace {

constexpr int most_rounds_of_lag = 12;
constexpr double lag_settled = 1e-3;  ///< [sd] of a change of the lag, after which no further round follows
/// [sd] from which on a lag that the levels show contradicts what is stated: p = 5e-4.
constexpr double lag_contradicts = 3.5;
/// [sd] from which on such a lag is an uncertainty, though it is not used: p = 5 %.
constexpr double lag_hints = 2.0;
/// [1] chance below which another cause is an uncertainty, though it is not named.
constexpr double doubtful_cause = 0.01;
/// Filters that are tried where levels are far off: lags from one to the other [s], each greater by this factor; [1] of the
/// misfit that one must explain; [1] of its lag, to which it is then known: electronics and programs are not alike.
constexpr double shortest_filter = 0.02, longest_filter = 0.8, next_filter = 1.25;
constexpr double explained_by_filter = 0.8, filter_sd = 0.05, rare_misfit = 1e-5;
constexpr double least_lag = 1e-5;  ///< [s] chosen: far less than the lag of any loop
/// [1] of the misfit, that a lag must explain: levels that differ for another reason feign one.
constexpr double least_explained = 0.5;
constexpr double same_lag_sd = 4.0;  ///< [sd] within which the lags of both gyros are one
constexpr double nearer_by =
    4.0;  ///< of chi-square, by which the lag of the reference explains the gyro better than none
/// [1] of a lag, within which those of both gyros are one: a loop in one of them is seldom so near to a clock.
constexpr double same_lag_share = 0.02;

int powers_of(const Settings& settings) {
  const std::string& order = settings.word("order");
  return order == "auto" ? -1 : order == "constant" ? 0 : order == "cubic" ? 1 : 2;
}

Relation relation_for(const Task& task, const std::vector<Measured>& measured, Findings& findings) {
  const auto given = [&](const char* name) { return task.settings.has(name) ? task.settings.number(name) : 0.0; };
  if (task.fourier) return {0.0, 0.0, given("reference_gain_sd"), given("reference_azimuth_sd"), false, 0.0};
  return relation_of(measured, task.output, task.settings, task.test.encoders, findings);
}

/// The harmonics, then the levels with what the harmonics say of the lag.
void fit_all(const Task& task, const Circumstances& around, const std::vector<Effect>& effects, Outcome& out,
             Findings& findings) {
  LagColumn column;
  if (task.phase_known && out.lag.quantity) {
    out.second = harmonic_with_lag(around, out.observations, effects, 2);
    out.third = harmonic_with_lag(around, out.observations, effects, 3);
    column = lag_column(around, out.observations, out.lag.value, {*out.second, *out.third});
  } else if (task.phase_known) {
    out.second = fit_harmonic(out.observations, effects, 2, {});
    out.third = fit_harmonic(out.observations, effects, 3, {});
  }
  out.levels =
      fit_levels(out.observations, effects, task.reduction.levels.size(), out.take, !task.fourier, column, findings);
}

/// One output with lines that are corrected for the lag given.
Outcome with_lag(const Task& task, const std::vector<Measured>& measured, const Lag& lag, Findings& findings,
                 const Doubt& doubt = {}) {
  Outcome out{.output = task.output,
              .take = task.phase_known ? Take::both_parts : Take::size,
              .corrected = !task.fourier,
              .lag = lag};
  out.power_ups = task.test.starts;
  out.relation = relation_for(task, measured, findings);
  const Complex own = task.sensitivity.known ? task.sensitivity.v : 0.0;
  std::vector<std::size_t> cell_of;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    if (!measured[i].of[task.output].present || !measured[i].of[reference].present) continue;
    out.observations.push_back(
        task.fourier ? fourier_observation(task.test, measured[i], task.reduction, i, out.relation)
                     : observe(measured[i], task.reduction, i, task.output, out.relation, own, task.phase_known));
    cell_of.push_back(task.cells.of[i]);
  }
  const bool late = task.line.cause == ReferenceLine::Cause::late;
  const Circumstances around{task.test,
                             measured,
                             task.reduction,
                             task.settings,
                             out.relation,
                             task.sensitivity,
                             task.output,
                             task.phase_known,
                             task.fourier,
                             out.lag,
                             late ? task.line.late_sd : 0.0,
                             doubt};
  auto effects = rig_effects(around, out.observations, task.shifts, cell_of, task.cells.nominal, task.cells.stretch);
  for (auto& effect : instrument_effects(around, out.observations)) effects.push_back(std::move(effect));
  fit_all(task, around, effects, out, findings);
  double values = 0.0;
  for (const auto& o : out.observations) values += static_cast<double>(o.part.size()) * (task.phase_known ? 2.0 : 1.0);
  out.polynomial = polynomial_of(out.levels, task.reduction.levels, out.take, powers_of(task.settings), values);
  out.feigned_azimuth = task.fourier ? 0.0 : lag.sd * azimuth_of_lag(around, out.observations);
  return out;
}

double chi_square_of(const Outcome& outcome) {
  return std::ranges::find(outcome.polynomial.tried, true, &Order::chosen)->chi_square;
}

/// The lag by levels and harmonics, found in a few rounds because it turns the lines by a finite angle. Given: the lag without
/// its value.
Lag estimated_lag(const Task& task, const std::vector<Measured>& measured, Lag lag) {
  lag.quantity = true;
  lag.sd = usual_lag;
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

/// The lag [s] that the second and third harmonics show by themselves: no other cause turns them.
LagFit lag_by_harmonics(const Outcome& outcome) {
  double weight = 0.0, sum = 0.0;
  for (const auto* harmonic : {&*outcome.second, &*outcome.third}) {
    if (harmonic->value.size() < 3) continue;
    const double variance = harmonic->fit.covariance(2, 2);
    weight += 1.0 / variance;
    sum += harmonic->value[2] / variance;
  }
  if (!(weight > 0.0)) return {};
  return {usual_lag * sum / weight, usual_lag / std::sqrt(weight), {}};
}

bool contradicts(const LagFit& lag) {
  return std::abs(lag.value) > lag_contradicts * lag.sd && std::abs(lag.value) > least_lag;
}

void report_lag(const Task& task, const Lag& lag, Findings& findings) {
  if (lag.of_stamps) return;  // said once, of both gyros
  findings.push_back({Finding::Severity::warning,
                      "loop_lag_differs",
                      {{"difference", lag.value, "ms"}, {"sd", lag.sd, "ms"}},
                      task.output == gyro ? "gyro" : "gyro_y"});
}

}  // namespace

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

bool has_lag_of_reference(const Task& task, const std::vector<Measured>& measured) {
  Findings unused;
  struct Off {
    double ratio, chi_square;  // of the lag beyond, and of the levels with this lag
  };
  const auto off = [&](double late) {
    const auto lines = without_lag(measured, task.output, late);
    const Outcome outcome = with_lag(task, lines, {.stated = true, .quantity = true}, unused);
    const LagFit more = lag_of(outcome.levels, outcome.polynomial);
    const double ratio = std::abs(more.value) / std::hypot(more.sd, same_lag_share * late);
    return Off{ratio, ratio * ratio + chi_square_of(outcome)};
  };
  const Off with = off(task.line.late);
  return with.ratio < same_lag_sd && with.chi_square + nearer_by < off(0.0).chi_square;
}

namespace {

/// What is left of the levels beyond their freedom.
double misfit_of(const Outcome& outcome) {
  return chi_square_of(outcome) - static_cast<double>(outcome.levels.value.size() - outcome.polynomial.value.size());
}

/// The low pass that explains levels far off their polynomial; without stages where none does, or another cause explains more.
Filter filter_of(const Task& task, const std::vector<Measured>& measured, const Outcome& plain) {
  if (level_misfit(plain, task.reduction.levels).probability > rare_misfit) return {};
  Findings unused;
  const double step = measured.front().of[task.output].step, before = misfit_of(plain);
  Filter best;
  double least = before;
  for (const double each_step : {0.0, step})
    for (const std::size_t stages : {1, 2})
      for (double lag = shortest_filter; lag < longest_filter; lag *= next_filter) {
        const Filter filter{lag, stages, each_step};
        const double left = misfit_of(with_lag(task, without_filter(measured, task.output, filter), {}, unused));
        if (left < least) least = left, best = filter;
      }
  const double fall = before - least;
  const double of_others = std::max(other_relation(plain, measured, task.reduction.levels).fall,
                                    line_beside_force(plain, measured, task.reduction.levels).fall);
  return fall > explained_by_filter * before && fall > of_others ? best : Filter{};
}

/// The lag beyond that of a stated loop that the levels and the harmonics of an output show; none where they do not contradict
/// the statement.
Lag contradicting_lag(const Task& task, const std::vector<Measured>& measured) {
  Findings unused;
  const Outcome plain = with_lag(task, measured, {}, unused);
  const Outcome free = with_lag(task, measured, {.stated = true, .quantity = true}, unused);
  const LagFit more = lag_of(free.levels, free.polynomial);
  const LagFit harmonics = lag_by_harmonics(free);
  if (const Filter filter = filter_of(task, measured, plain); filter.stages > 0)
    return {.stated = true, .contradicted = true, .filter = filter, .value = filter.lag, .sd = filter_sd * filter.lag};
  const bool hints = std::abs(more.value) > lag_hints * more.sd && std::abs(more.value) > least_lag;
  const Lag doubt = hints ? Lag{.stated = true, .doubtful = true, .sd = std::abs(more.value)} : Lag{};
  if (!contradicts(more) && !contradicts(harmonics)) return doubt;
  const Lag lag = estimated_lag(
      task, measured, {.stated = true, .contradicted = true, .value = contradicts(harmonics) ? harmonics.value : 0.0});
  const Outcome corrected = with_lag(task, without_lag(measured, task.output, lag.value), {}, unused);
  const double fall = chi_square_of(plain) - chi_square_of(corrected);
  const double misfit =
      chi_square_of(plain) - static_cast<double>(plain.levels.value.size() - plain.polynomial.value.size());
  if (contradicts(harmonics)) return lag;
  if (fall < least_explained * misfit) return doubt;
  // each of the others has one number more
  const double of_others = std::max(other_relation(plain, measured, task.reduction.levels).fall,
                                    line_beside_force(plain, measured, task.reduction.levels).fall) -
                           2.0;
  return std::max(std::pow(more.value / more.sd, 2), fall) < of_others ? doubt : lag;
}

/// The size of each cause that is no chance, though it may be too little to be named.
Doubt doubt_of(const Cause& relation, const Cause& beside) {
  return {relation.probability < doubtful_cause ? std::abs(relation.value) : 0.0,
          beside.probability < doubtful_cause ? std::abs(beside.value) : 0.0};
}

/// The lag of an output: that of the stamps, of a stated loop with what contradicts it, or of a loop that nobody stated.
Lag lag_for(const Task& task, const std::vector<Measured>& measured) {
  if (task.late_alike && task.loop_stated())
    return {.stated = true, .contradicted = true, .of_stamps = true, .value = task.line.late, .sd = task.line.late_sd};
  if (task.phase_known)
    return task.loop_stated() ? contradicting_lag(task, measured) : estimated_lag(task, measured, {.stated = false});
  if (!task.loop_stated() && !task.fourier) return {.stated = false, .sd = usual_lag};
  return {};
}

}  // namespace

Outcome outcome_of(const Task& task, const std::vector<Measured>& measured, Findings& findings) {
  Findings unused;
  check_relation(relation_of(measured, task.output, task.settings, task.test.encoders, unused), task.output,
                 task.settings, findings);
  const Lag lag = lag_for(task, measured);
  if (lag.contradicted) report_lag(task, lag, findings);
  const auto lines = lag.filter.stages > 0 ? without_filter(measured, task.output, lag.filter)
                                           : without_lag(measured, task.output, lag.value);
  Outcome outcome = with_lag(task, lines, lag, findings);
  const std::vector<Level>& levels = task.reduction.levels;
  if (!lag.contradicted) name_cause(outcome, lines, levels, findings);
  check_levels(outcome, levels, findings);  // by what is known, and not by what is doubted
  if (lag.contradicted) return outcome;
  const Doubt doubt = doubt_of(other_relation(outcome, lines, levels), line_beside_force(outcome, lines, levels));
  return doubt.any() ? with_lag(task, lines, lag, unused, doubt) : std::move(outcome);
}

}  // namespace tumble::dtg_centrifuge
