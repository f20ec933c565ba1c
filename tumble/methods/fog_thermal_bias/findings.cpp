#include "tumble/methods/fog_thermal_bias/findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/math/regression/least_squares.hpp"

namespace tumble::fog_thermal_bias {
namespace {

/// [1] of the squares of one input that others explain: 5 % remain for its term.
constexpr double follows_share = 0.95;
/// Condition of the columns of unit length. At 30 an uncertainty is up to 30 times that of the term by itself; at 1000
/// a thousandth of model error moves the terms by their size.
constexpr double correlated = 30.0, nearly_dependent = 1e3;
constexpr double hottest_chamber = 473.15;  ///< [K] 200 degC: kelvin of -70 degC and more, read as degC
constexpr double widened = 1.3;  ///< chi-square over its degrees of freedom, from which on uncertainties are 14 % wider

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
  if (const double shared = explained(runs, rate, {from_start, square}); shared > follows_share)
    findings.push_back({Severity::warning, "rate_follows_temperature", {{"shared", shared, "%"}}, "temperature"});
  if (largest.gradient == 0) return;
  if (const double shared = explained(runs, gradient, {rate, from_start}); shared > follows_share)
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

/// Power-ups of which a part of this length [s] has readings of another.
void add_of_others(Findings& findings, const std::vector<RunData>& runs, const char* code, double RunData::*length) {
  Occurrences often{0, {}, {}};
  double longest = 0.0;
  for (const RunData& run : runs) {
    if (run.*length <= 0.0) continue;
    const Place place(fmt::format("run {}", run.number));
    if (often.count++ == 0) often.first = place;
    if (run.*length > longest) longest = run.*length, often.worst = place;
  }
  if (often.count > 0) findings.push_back({Severity::warning, code, {{"length", longest, "s"}}, "", often});
}

/// A thermometer whose column says degC and holds kelvin: no chamber is so hot.
void add_kelvin(Findings& findings, const std::vector<RunData>& runs) {
  double least = INFINITY, greatest = -INFINITY;
  each_average(runs, [&](const RunData& run, std::size_t k) {
    const double half = 0.5 * run.felt[k].temperature_gradient;
    for (const double one : {run.felt[k].temperature - half, run.felt[k].temperature + half}) {
      if (one < hottest_chamber) continue;
      least = std::min(least, one);
      greatest = std::max(greatest, one);
    }
  });
  if (greatest > hottest_chamber)
    findings.push_back(
        {Severity::error, "temperature_of_no_chamber", {{"least", least, "degC"}, {"greatest", greatest, "degC"}}});
}

}  // namespace

Table models_table(const std::vector<Candidate>& candidates, std::size_t chosen, const Estimate& estimate) {
  const double raw = find_parameter(estimate, "bias_sd_raw")->value;
  const auto verdict = [&](const Candidate& m) {
    return &m == &candidates[chosen] ? "yes" : !m.unobservable.empty() ? "not determined" : "";
  };
  return tabulate(
      "models",
      "orders of T, its gradient DT and its rate; sd of the averages about their run's mean and its ratio to raw; "
      "held out: every run predicted from the others",
      candidates,
      {{"T", &Candidate::temperature},
       {"DT", &Candidate::gradient},
       {"dT/dt", &Candidate::rate},
       {"terms", [](const Candidate& m) { return m.columns.size(); }},
       {"sd", rate_unit(), &Candidate::sd},
       {"ratio", [raw](const Candidate& m) { return m.sd / raw; }},
       {"held-out sd", rate_unit(), &Candidate::sd_held_out},
       {"held-out ratio", [raw](const Candidate& m) { return m.sd_held_out / raw; }},
       {"AICc", &Candidate::aicc},
       {"chosen", verdict}});
}

Table runs_table(const std::vector<RunData>& runs, const std::vector<std::size_t>& columns, const LinearFit& fit) {
  const auto sd = [](const Residual& r) { return std::sqrt(r.squares / std::max(1.0, r.count - 1.0)); };
  const auto raw = [&](const RunData& run) { return sd(residual_of(run, {}, {})); };
  const auto compensated = [&](const RunData& run) { return sd(residual_of(run, columns, fit.parameters)); };
  return tabulate("runs", "each power-up: sd of its averages before and after compensation", runs,
                  {{"run", &RunData::number},
                   {"label", &RunData::label},
                   {"start temperature", "degC", &RunData::start_temperature},
                   {"L_0", rate_unit(), &RunData::start_output},
                   {"sd raw", rate_unit(), raw},
                   {"sd compensated", rate_unit(), compensated},
                   {"ratio", [&](const RunData& run) { return compensated(run) / raw(run); }},
                   {"used", [](const RunData& run) { return run.held_out ? "held out" : "fitted"; }},
                   {"file", &RunData::file}});
}

Table noise_table(const NoiseModel& noise) {
  struct Row {
    const char* term;
    double value;  ///< [unit]
    const char* unit;
  };
  const std::vector<Row> rows{{"angle_random_walk", noise.angle_random_walk, "deg/sqrt(h)"},
                              {"bias_instability", noise.bias_instability, "deg/h"},
                              {"rate_random_walk", noise.rate_random_walk, "deg/h/sqrt(h)"}};
  return tabulate("noise", "noise of the residuals by restricted maximum likelihood", rows,
                  {{"term", &Row::term},
                   {"value", [](const Row& r) { return Unit::parse(r.unit).difference_from_si(r.value); }},
                   {"unit", &Row::unit}});
}

std::vector<Curve> residual_curves(const std::vector<RunData>& runs, const std::vector<std::size_t>& columns,
                                   const LinearFit& fit) {
  Curve before{.name = "before compensation",
               .figure = "residual",
               .x = {"time, runs joined", Unit::parse("h")},
               .y = {"output less L_0", rate_unit()}};
  Curve after = before;
  after.name = "after compensation";
  double offset = 0.0;
  for (const auto& run : runs) {
    for (std::size_t k = 0; k < run.time.size(); ++k) {
      if (run.share[k] <= 0.0) continue;
      double drift = 0.0;
      for (std::size_t c = 0; c < columns.size(); ++c) drift += fit.parameters[c] * run.regressors(k, columns[c]);
      add_point(before, offset + run.time[k], run.output[k] - run.start_output);
      add_point(after, offset + run.time[k], run.output[k] - run.start_output - drift);
    }
    if (!run.time.empty()) offset += run.time.back() + run.time.front();
  }
  return {before, after};
}

Findings findings_of(const Answer& answer, const Settings& settings) {
  Findings findings;
  add_of_others(findings, answer.runs, "power_ups_end_in_next", &RunData::of_next);
  add_of_others(findings, answer.runs, "power_ups_begin_in_last", &RunData::of_last);
  add_kelvin(findings, answer.runs);
  const LinearFit& fit = answer.fit;
  add_orders(findings, answer);
  add_collinearity(findings, answer.runs, answer.candidates.back());
  if (fit.condition > correlated)
    findings.push_back({fit.condition > nearly_dependent ? Severity::warning : Severity::info,
                        "correlated_coefficients",
                        {{"condition", fit.condition}},
                        "fit"});
  const double misfit = fit.degrees_of_freedom > 0 ? fit.chi_square / fit.degrees_of_freedom : 1.0;
  if (misfit > widened)
    findings.push_back({Severity::warning, "misfit_widens_uncertainties", {{"reduced_chi_square", misfit}}, "fit"});
  add_misfit(findings, answer.misfit);
  add_held_out(findings, answer);
  findings.insert(findings.end(), answer.uneven.begin(), answer.uneven.end());
  add_not_used(findings, answer.runs, answer.not_used);
  if (settings.word("form") == "raw") findings.push_back({Severity::warning, "raw_powers_of_temperature", {}, "form"});
  if (!std::isfinite(answer.noise.angle_random_walk))
    findings.push_back({Severity::error, "noise_not_determined", {}, "fit"});
  return findings;
}

}  // namespace tumble::fog_thermal_bias
