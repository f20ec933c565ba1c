#include "tumble/methods/fog_thermal_bias/describe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/regression/least_squares.hpp"
#include "tumble/reduce/answer.hpp"

namespace tumble::fog_thermal_bias {
namespace {

constexpr const char* noise_source = "output noise";

/// Standard deviations before and after, with their uncertainty by the jackknife over the runs.
void append_scores(Estimate& estimate, const Answer& answer) {
  const Unit unit = Unit::parse("deg/h");
  const Candidate& chosen = answer.candidates[answer.chosen];
  struct Score {
    const char* name;
    const char* symbol;
    const char* description;
    std::vector<double> squares;
  };
  std::vector<Score> scores{
      {"bias_sd_raw", "s_raw", "of the averages about their run's mean, before compensation", {}},
      {"bias_sd_compensated", "s_c", "the same after compensation, in sample", {}},
      {"bias_sd_held_out", "s_h", "the same, every run predicted from the others", chosen.held_out_squares}};
  std::vector<double> counts;
  for (const auto& run : answer.runs) {
    if (run.held_out) continue;
    const Residual raw = residual_of(run, {}, {});
    scores[0].squares.push_back(raw.squares);
    scores[1].squares.push_back(residual_of(run, chosen.columns, answer.fit.parameters).squares);
    counts.push_back(std::max(0.0, raw.count - 1.0));
  }
  for (auto& s : scores) {
    double sum = 0.0, count = 0.0, mean = 0.0, spread = 0.0;
    const double n = static_cast<double>(counts.size());
    for (std::size_t r = 0; r < counts.size(); ++r) {
      sum += s.squares[r];
      count += counts[r];
    }
    std::vector<double> left_out;
    for (std::size_t r = 0; r < counts.size(); ++r)
      left_out.push_back(std::sqrt((sum - s.squares[r]) / std::max(1.0, count - counts[r])));
    for (const double v : left_out) mean += v / n;
    for (const double v : left_out) spread += (v - mean) * (v - mean) * (n - 1.0) / n;
    if (counts.size() < 2) {  // nothing to leave out
      if (s.squares.data() == scores[2].squares.data()) continue;
      spread = std::pow(uncertainty_of_sd(std::sqrt(sum / count), std::max(1.0, count)), 2);
    }
    append_parameter(estimate, {s.name, s.symbol, unit, std::sqrt(sum / count), s.description, std::max(1.0, n - 1.0)},
                     noise_source, spread);
  }
}

/// L_0 over start temperature by least squares on the runs' levels; the scatter is the turn-on repeatability.
void append_levels(Estimate& estimate, const Answer& answer, const Settings& settings, const std::vector<Term>& terms) {
  const Candidate& chosen = answer.candidates[answer.chosen];
  const auto powers = static_cast<std::size_t>(settings.integer("start_temperature_power")) + 1;
  std::vector<double> levels, starts;
  for (const auto& run : answer.runs) {
    if (run.held_out) continue;
    double sum = 0.0, count = 0.0;
    for (std::size_t k = 0; k < run.time.size(); ++k) {
      if (run.share[k] <= 0.0) continue;
      double level = run.output[k];
      for (std::size_t c = 0; c < chosen.columns.size(); ++c)
        level -= answer.fit.parameters[c] * run.regressors(k, chosen.columns[c]);
      sum += level;
      count += 1.0;
    }
    if (count == 0.0) continue;
    levels.push_back(sum / count);
    starts.push_back(run.start_temperature - settings.number("start_temperature_reference"));
  }
  if (levels.size() < powers + 2) return;
  Matrix design(levels.size(), powers);
  for (std::size_t r = 0; r < levels.size(); ++r)
    for (std::size_t j = 0; j < powers; ++j) design(r, j) = std::pow(starts[r], static_cast<double>(j));
  const auto fit = least_squares(design, levels, {}, {});
  if (!fit.unobservable.empty()) return;
  Estimate levels_of_runs;
  for (std::size_t j = 0; j < powers; ++j) {
    const auto term = std::ranges::find(terms, fmt::format("bias_{}", j), &Term::name);
    levels_of_runs.parameters.push_back({term->name, term->symbol, Unit::parse(term->unit), fit.parameters[j],
                                         term->description, fit.degrees_of_freedom});
  }
  settle(levels_of_runs, {from_covariance(noise_source, fit.covariance)});
  append(estimate, levels_of_runs);
  append_parameter(
      estimate,
      {"turn_on_repeatability", "s_on", Unit::parse("deg/h"), fit.sigma,
       "standard deviation of a run's level about the polynomial in the start temperature", fit.degrees_of_freedom},
      noise_source, std::pow(uncertainty_of_sd(fit.sigma, fit.degrees_of_freedom), 2));
}

}  // namespace

Estimate describe(const Evidence& evidence, const std::vector<Term>& terms, const Answer& answer) {
  const Settings& settings = evidence.plan.settings;
  Estimate estimate;
  estimate.method = "fog_thermal_bias";
  const auto& columns = answer.candidates[answer.chosen].columns;
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const Term& term = terms[columns[k]];
    estimate.parameters.push_back({term.name, term.symbol, Unit::parse(term.unit), answer.fit.parameters[k],
                                   term.description, answer.degrees_of_freedom[k]});
  }
  std::vector<ErrorLine> lines{from_covariance(noise_source, answer.fit.covariance)};
  if (settings.number("sensor_lag_sd") > 0.0) {
    const auto shift =
        shift_by_lag(evidence, terms, answer, settings.number("sensor_lag") + settings.number("sensor_lag_sd"));
    Matrix shifts(shift.size(), 1);
    shifts.values = shift;
    lines.push_back(from_shifts("temperature sensor lag", std::move(shifts)));
  }
  settle(estimate, lines);
  append_scores(estimate, answer);
  append_levels(estimate, answer, settings, terms);
  double averages = 0.0;
  for (const auto& run : answer.runs)
    if (!run.held_out) averages += residual_of(run, {}, {}).count;
  estimate.fit = {static_cast<std::size_t>(averages), answer.fit.degrees_of_freedom, answer.fit.chi_square,
                  answer.fit.condition};
  return estimate;
}

}  // namespace tumble::fog_thermal_bias
