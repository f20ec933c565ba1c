#include "tumble/methods/fog_thermal_bias/describe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/reduce/answer.hpp"

namespace tumble::fog_thermal_bias {
namespace {

constexpr const char* noise_source = "output noise";

constexpr const char* scatter_source = "scatter between power-ups";

/// Squares of one kind of residual, run by run.
struct Score {
  const char* name;
  const char* symbol;
  const char* description;
  std::vector<double> squares;
};

std::vector<Score> scores_of(const Answer& answer, std::vector<double>& counts) {
  std::vector<Score> scores{{"bias_sd_raw", "s_raw", "of the averages about their run's mean, before compensation", {}},
                            {"bias_sd_compensated", "s_c", "the same after compensation, in sample", {}}};
  for (const auto& run : answer.runs) {
    if (run.held_out) continue;
    const Residual raw = residual_of(run, {}, {});
    scores[0].squares.push_back(raw.squares);
    scores[1].squares.push_back(residual_of(run, answer.columns, answer.fit.parameters).squares);
    counts.push_back(std::max(0.0, raw.count - 1.0));
  }
  if (counts.size() > 1)
    scores.push_back({"bias_sd_held_out", "s_h", "the same, every run predicted from the others",
                      answer.candidates[answer.chosen].held_out_squares});
  return scores;
}

/// Variance of a pooled standard deviation by the jackknife over the runs.
double jackknife(const std::vector<double>& squares, const std::vector<double>& counts, double sum, double count) {
  std::vector<double> without;
  for (std::size_t r = 0; r < counts.size(); ++r)
    without.push_back(std::sqrt(std::max(0.0, sum - squares[r]) / std::max(1.0, count - counts[r])));
  double mean = 0.0, spread = 0.0;
  const double n = static_cast<double>(without.size());
  for (const double v : without) mean += v / n;
  for (const double v : without) spread += (v - mean) * (v - mean) * (n - 1.0) / n;
  return spread;
}

/// A standard deviation, whose interval is that of chi-square.
void append_sd(Estimate& estimate, Parameter parameter, const std::string& source, double variance,
               const SdInterval& interval) {
  parameter.lower = interval.lower;
  parameter.upper = interval.upper;
  append_parameter(estimate, std::move(parameter), source, variance);
}

/// Standard deviations before and after, with their uncertainty by the jackknife over the runs.
void append_scores(Estimate& estimate, const Answer& answer) {
  std::vector<double> counts;
  for (const auto& s : scores_of(answer, counts)) {
    double sum = 0.0, count = 0.0;
    for (std::size_t r = 0; r < counts.size(); ++r) {
      sum += s.squares[r];
      count += counts[r];
    }
    const double sd = std::sqrt(sum / count), runs = static_cast<double>(counts.size());
    const double variance = counts.size() > 1 ? jackknife(s.squares, counts, sum, count)
                                              : std::pow(uncertainty_of_sd(sd, std::max(1.0, count)), 2);
    const double freedom = std::clamp(sd * sd / (2.0 * variance), 1.0, std::max(1.0, count));
    append_sd(estimate, {s.name, s.symbol, Unit::parse("deg/h"), sd, s.description, std::max(1.0, runs - 1.0)},
              noise_source, variance, interval_of_sd(sd, freedom));
  }
}

/// The scatter of the levels about their polynomial, or a finding with its limit.
void append_turn_on(Estimate& estimate, const LevelFit& levels) {
  const double own = levels.turn_on_variance, noise = levels.noise_variance, total = own + noise,
               freedom = levels.total_freedom;
  const double infinity = std::numeric_limits<double>::infinity();
  if (!(own > 0.0)) {
    const double limit = interval_of_excess_sd(total, freedom, 0.0, infinity, 0.9).upper;
    estimate.findings.push_back({Finding::Severity::info,
                                 "not_significant",
                                 {{"parameter", "turn_on_repeatability"}, {"limit", limit, "deg/h"}}});
    estimate.findings.back().hidden = {{"turn_on_repeatability"}};
    return;
  }
  SdInterval interval = interval_of_excess_sd(total, freedom, noise, infinity);
  interval.lower = std::fmin(interval.lower, levels.least_turn_on);
  append_sd(estimate,
            {"turn_on_repeatability", "s_on", Unit::parse("deg/h"), std::sqrt(own),
             "standard deviation of a run's level about the polynomial in the start temperature", freedom},
            scatter_source, total * total / (2.0 * freedom * own), interval);
}

/// Coefficients and, where there is one, the polynomial of the levels, whose errors share those of the coefficients.
std::vector<ErrorLine> lines_of(const Evidence& evidence, const std::vector<Term>& terms, const Answer& answer) {
  const LevelFit& levels = answer.levels;
  const std::size_t q = answer.columns.size(), p = levels.bias.size();
  Matrix noise(q + p, q + p), scatter(q + p, q + p);
  set_block(noise, 0, 0, answer.fit.covariance);
  if (p > 0) {
    const Matrix between = levels.of_coefficients * answer.fit.covariance;
    set_block(noise, q, 0, between);
    set_block(noise, 0, q, transposed(between));
    set_block(noise, q, q, levels.noise);
    set_block(scatter, q, q, levels.scatter);
  }
  std::vector<ErrorLine> lines{from_covariance(noise_source, noise)};
  if (p > 0) lines.push_back(from_covariance(scatter_source, scatter));
  const Settings& settings = evidence.plan.settings;
  if (settings.number("sensor_lag_sd") > 0.0) {
    const auto shift =
        shift_by_lag(evidence, terms, answer, settings.number("sensor_lag") + settings.number("sensor_lag_sd"));
    lines.push_back(from_shifts("temperature sensor lag", as_column(shift)));
  }
  return lines;
}

}  // namespace

Estimate describe(const Evidence& evidence, const std::vector<Term>& terms, const Answer& answer) {
  Estimate estimate;
  const auto add = [&](const Term& term, double value, double freedom) {
    estimate.parameters.push_back({term.name, term.symbol, Unit::parse(term.unit), value, term.description, freedom});
  };
  for (std::size_t k = 0; k < answer.columns.size(); ++k)
    add(terms[answer.columns[k]], answer.fit.parameters[k], answer.degrees_of_freedom[k]);
  for (std::size_t j = 0; j < answer.levels.bias.size(); ++j)
    add(*std::ranges::find(terms, fmt::format("bias_{}", j), &Term::name), answer.levels.bias[j],
        answer.levels.degrees_of_freedom[j]);
  settle(estimate, lines_of(evidence, terms, answer));
  append_scores(estimate, answer);
  if (!answer.levels.bias.empty()) append_turn_on(estimate, answer.levels);
  double averages = 0.0;
  for (const auto& run : answer.runs)
    if (!run.held_out) averages += residual_of(run, {}, {}).count;
  estimate.fit = {static_cast<std::size_t>(averages), answer.fit.degrees_of_freedom, answer.fit.chi_square,
                  answer.fit.condition};
  return estimate;
}

}  // namespace tumble::fog_thermal_bias
