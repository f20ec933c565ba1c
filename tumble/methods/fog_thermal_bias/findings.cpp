#include "tumble/methods/fog_thermal_bias/findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/regression/least_squares.hpp"

namespace tumble::fog_thermal_bias {
namespace {

const Unit& rate_unit() {
  static const Unit unit = Unit::parse("deg/h");
  return unit;
}

/// Share of the variance of one thermal quantity within the runs that others explain: R^2 of a regression with a free
/// level in every run.
double explained(const std::vector<RunData>& runs, const std::function<double(const Felt&)>& target,
                 const std::vector<std::function<double(const Felt&)>>& by) {
  std::vector<double> y;
  std::vector<std::vector<double>> x(by.size());
  for (const auto& run : runs) {
    if (run.held_out) continue;
    std::vector<std::size_t> rows;
    for (std::size_t k = 0; k < run.time.size(); ++k)
      if (run.share[k] > 0.0) rows.push_back(k);
    const auto centred = [&](const auto& of, std::vector<double>& out) {
      double mean = 0.0;
      for (const auto k : rows) mean += of(run.felt[k]) / static_cast<double>(rows.size());
      for (const auto k : rows) out.push_back(of(run.felt[k]) - mean);
    };
    centred(target, y);
    for (std::size_t c = 0; c < by.size(); ++c) centred(by[c], x[c]);
  }
  Matrix design(y.size(), by.size());
  for (std::size_t c = 0; c < by.size(); ++c)
    std::ranges::copy(x[c], design.values.begin() + static_cast<std::ptrdiff_t>(c * y.size()));
  double total = 0.0;
  for (const double v : y) total += v * v;
  if (!(total > 0.0) || y.size() <= by.size()) return 0.0;
  return 1.0 - least_squares(design, y, {}, {}).chi_square / total;
}

using Severity = Finding::Severity;

void add_collinearity(Findings& findings, const std::vector<RunData>& runs, const Candidate& largest) {
  const auto from_start = [](const Felt& f) { return f.temperature - f.start_temperature; };
  const auto square = [=](const Felt& f) { return from_start(f) * from_start(f); };
  const auto gradient = [](const Felt& f) { return f.temperature_gradient; };
  const auto rate = [](const Felt& f) { return f.temperature_rate; };
  if (largest.rate == 0) return;
  if (const double shared = explained(runs, rate, {from_start, square}); shared > 0.95)
    findings.push_back({Severity::warning, "rate_follows_temperature", {{"shared", shared, "%"}}, "temperature"});
  if (largest.gradient == 0) return;
  if (const double shared = explained(runs, gradient, {rate, from_start}); shared > 0.95)
    findings.push_back({Severity::warning, "gradient_follows_rate", {{"shared", shared, "%"}}, "temperature gradient"});
}

std::vector<FindingValue> orders(const Candidate& candidate) {
  return {{"temperature", candidate.temperature}, {"gradient", candidate.gradient}, {"rate", candidate.rate}};
}

void add_orders(Findings& findings, const Answer& answer) {
  const auto& candidates = answer.candidates;
  if (candidates.size() > 1) {
    const Candidate& largest = candidates[answer.largest];
    auto values = orders(candidates[answer.chosen]);
    values.emplace_back("largest_temperature", largest.temperature);
    values.emplace_back("largest_gradient", largest.gradient);
    values.emplace_back("largest_rate", largest.rate);
    findings.push_back({Severity::info, "orders_chosen", std::move(values), "models"});
  }
  for (const Candidate& candidate : candidates) {
    if (candidate.unobservable.empty()) continue;
    auto values = orders(candidate);
    values.emplace_back("combination", candidate.unobservable);
    findings.push_back({Severity::warning, "orders_not_determined", std::move(values), "models"});
  }
}

/// Runs that the two-stage fit could not use; `not_used` counts the fitted runs.
void add_not_used(Findings& findings, const std::vector<RunData>& runs, const std::vector<std::size_t>& not_used) {
  if (not_used.empty()) return;
  std::vector<int> numbers;
  for (const RunData& run : runs)
    if (!run.held_out) numbers.push_back(run.number);
  findings.push_back({Severity::info,
                      "run_alone_not_determined",
                      {},
                      "two_stage",
                      {not_used.size(), fmt::format("run {}", numbers[not_used.front()]), {}}});
}

/// What the columns beside the model show, where noise does not give it.
void add_misfit(Findings& findings, const Misfit& misfit) {
  constexpr double significant = 1e-6, least_share = 0.2;  // a small part may make good what another lacks
  for (const auto& part : misfit.parts) {
    if (part.p_value > significant || part.sd < least_share * misfit.sd) continue;
    const bool hysteresis = part.departure == Departure::hysteresis;
    // Rising and falling lie on both sides of their mean.
    findings.push_back({Severity::warning,
                        hysteresis ? "hysteresis" : "drift_lags_temperature",
                        {{"size", hysteresis ? 2.0 * part.sd : part.sd, "deg/h"}, {"misfit", misfit.sd, "deg/h"}},
                        "fit"});
  }
}

/// Root mean square of a residual over runs.
double pooled_sd(const std::vector<RunData>& runs, bool held_out, const std::vector<std::size_t>& columns,
                 const std::vector<double>& parameters) {
  double squares = 0.0, count = 0.0;
  for (const auto& run : runs) {
    if (run.held_out != held_out) continue;
    const Residual residual = residual_of(run, columns, parameters);
    squares += residual.squares;
    count += std::max(0.0, residual.count - 1.0);
  }
  return count > 0.0 ? std::sqrt(squares / count) : std::nan("");
}

/// Runs that were not fitted, or each predicted from the others, are worse after the compensation than before.
void add_held_out(Findings& findings, const Answer& answer) {
  constexpr double worse = 1.1;  // coefficients that noise determines badly add a few per cent
  const auto add = [&](const char* code, double before, double after) {
    if (after > worse * before)
      findings.push_back({Severity::warning, code, {{"before", before, "deg/h"}, {"after", after, "deg/h"}}, "runs"});
  };
  add("held_out_runs_worse", pooled_sd(answer.runs, true, {}, {}),
      pooled_sd(answer.runs, true, answer.columns, answer.fit.parameters));
  add("predicted_runs_worse", pooled_sd(answer.runs, false, {}, {}), answer.candidates[answer.chosen].sd_held_out);
}

}  // namespace

Table models_table(const std::vector<Candidate>& candidates, std::size_t chosen, const Estimate& estimate) {
  const double raw = find_parameter(estimate, "bias_sd_raw")->value;
  const Unit one;
  Table table{
      "models",
      "orders of T, its gradient DT and its rate; sd of the averages about their run's mean and its ratio to raw; "
      "held out: every run predicted from the others",
      {{"T", one},
       {"DT", one},
       {"dT/dt", one},
       {"terms", one},
       {"sd", rate_unit()},
       {"ratio", one},
       {"held-out sd", rate_unit()},
       {"held-out ratio", one},
       {"AICc", one},
       {"chosen", one}},
      {}};
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    const Candidate& m = candidates[c];
    table.rows.push_back({static_cast<double>(m.temperature), static_cast<double>(m.gradient),
                          static_cast<double>(m.rate), static_cast<double>(m.columns.size()), m.sd, m.sd / raw,
                          m.sd_held_out, m.sd_held_out / raw, m.aicc,
                          std::string(c == chosen               ? "yes"
                                      : !m.unobservable.empty() ? "not determined"
                                                                : "")});
  }
  return table;
}

Table runs_table(const std::vector<RunData>& runs, const std::vector<std::size_t>& columns, const LinearFit& fit) {
  const Unit one, celsius = Unit::parse("degC");
  Table table{"runs",
              "each power-up: sd of its averages before and after compensation",
              {{"run", one},
               {"label", one},
               {"start temperature", celsius},
               {"L_0", rate_unit()},
               {"sd raw", rate_unit()},
               {"sd compensated", rate_unit()},
               {"ratio", one},
               {"used", one},
               {"file", one}},
              {}};
  for (const auto& run : runs) {
    const Residual raw = residual_of(run, {}, {}), compensated = residual_of(run, columns, fit.parameters);
    const double before = std::sqrt(raw.squares / std::max(1.0, raw.count - 1.0)),
                 after = std::sqrt(compensated.squares / std::max(1.0, compensated.count - 1.0));
    table.rows.push_back({static_cast<double>(run.number), run.label, run.start_temperature, run.start_output, before,
                          after, after / before, std::string(run.held_out ? "held out" : "fitted"), run.file});
  }
  return table;
}

Table noise_table(const NoiseModel& noise) {
  Table table{"noise",
              "noise of the residuals by restricted maximum likelihood",
              {{"term", {}}, {"value", {}}, {"unit", {}}},
              {}};
  const auto add = [&](const char* name, double value, const char* unit) {
    table.rows.push_back({std::string(name), Unit::parse(unit).difference_from_si(value), std::string(unit)});
  };
  add("angle_random_walk", noise.angle_random_walk, "deg/sqrt(h)");
  add("bias_instability", noise.bias_instability, "deg/h");
  add("rate_random_walk", noise.rate_random_walk, "deg/h/sqrt(h)");
  return table;
}

std::vector<Curve> residual_curves(const std::vector<RunData>& runs, const std::vector<std::size_t>& columns,
                                   const LinearFit& fit) {
  const Unit hours = Unit::parse("h");
  Curve before{"before compensation",
               "residual",
               {"time, runs joined", hours, {}},
               {"output less L_0", rate_unit(), {}},
               {},
               {},
               "",
               false,
               false};
  Curve after = before;
  after.name = "after compensation";
  double offset = 0.0;
  for (const auto& run : runs) {
    for (std::size_t k = 0; k < run.time.size(); ++k) {
      if (run.share[k] <= 0.0) continue;
      double drift = 0.0;
      for (std::size_t c = 0; c < columns.size(); ++c) drift += fit.parameters[c] * run.regressors(k, columns[c]);
      before.x.values.push_back(offset + run.time[k]);
      before.y.values.push_back(run.output[k] - run.start_output);
      after.y.values.push_back(run.output[k] - run.start_output - drift);
    }
    if (!run.time.empty()) offset += run.time.back() + run.time.front();
  }
  after.x.values = before.x.values;
  return {before, after};
}

Findings findings_of(const Answer& answer, const Settings& settings) {
  Findings findings;
  const LinearFit& fit = answer.fit;
  add_orders(findings, answer);
  add_collinearity(findings, answer.runs, answer.candidates.back());
  if (fit.condition > 30.0)
    findings.push_back({fit.condition > 1e3 ? Severity::warning : Severity::info,
                        "correlated_coefficients",
                        {{"condition", fit.condition}},
                        "fit"});
  const double misfit = fit.degrees_of_freedom > 0 ? fit.chi_square / fit.degrees_of_freedom : 1.0;
  if (misfit > 1.3)
    findings.push_back({Severity::warning, "misfit_widens_uncertainties", {{"reduced_chi_square", misfit}}, "fit"});
  add_misfit(findings, answer.misfit);
  add_held_out(findings, answer);
  add_not_used(findings, answer.runs, answer.not_used);
  if (settings.word("form") == "raw") findings.push_back({Severity::warning, "raw_powers_of_temperature", {}, "form"});
  if (!std::isfinite(answer.noise.angle_random_walk))
    findings.push_back({Severity::error, "noise_not_determined", {}, "fit"});
  return findings;
}

}  // namespace tumble::fog_thermal_bias
