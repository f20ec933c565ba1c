#include "tumble/methods/fog_thermal_bias/solve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/fog_thermal_bias/beside_model.hpp"
#include "tumble/methods/fog_thermal_bias/uneven_runs.hpp"
#include "tumble/reduce/power_ups.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::fog_thermal_bias {
namespace {

constexpr double most_coarse = 5000.0;  ///< averages for the search of the noise; the solution uses all

constexpr double other_start = 2.0;  ///< [K] from which on two runs start at two temperatures

constexpr double least_temperature_change = 1e-3;   ///< [K] less is the rounding of readings
constexpr std::size_t fewest_averages_of_run = 10;  ///< of all runs: terms and noise are estimated from them

/// All columns any candidate may use, in groups of one power of the start temperature after the other.
std::vector<std::size_t> columns_of(const std::vector<Term>& terms, int temperature, int gradient, int rate, int powers,
                                    bool startup) {
  std::vector<std::size_t> columns;
  const auto add = [&](const std::string& name) {
    columns.push_back(static_cast<std::size_t>(std::ranges::find(terms, name, &Term::name) - terms.begin()));
  };
  const auto add_series = [&](char letter, int highest) {
    for (int i = 1; i <= highest; ++i)
      for (int j = 0; j < powers; ++j) add(fmt::format("{}{}_{}", letter, i, j));
  };
  add_series('A', temperature);
  add_series('B', gradient);
  add_series('C', rate);
  if (startup) add("startup_transient");
  return columns;
}

struct Choice {
  int lowest, highest;
};

Choice choice_of(const std::string& word, int lowest, int highest) {
  if (word == "auto") return {lowest, highest};
  const int order = as_number<int>(word).value_or(lowest);
  return {order, order};
}

std::vector<Candidate> candidates_of(const Settings& settings, const std::vector<Term>& terms, bool gradient_seen) {
  const int powers = settings.integer("start_temperature_power") + 1;
  const Choice temperature = choice_of(settings.word("order"), 1, 4);
  Choice gradient = choice_of(settings.word("gradient_order"), 0, 1);
  const Choice rate = choice_of(settings.word("rate_order"), 0, 1);
  if (!gradient_seen) gradient = {0, 0};
  std::vector<Candidate> out;
  for (int r = rate.lowest; r <= rate.highest; ++r)
    for (int g = gradient.lowest; g <= gradient.highest; ++g)
      for (int t = temperature.lowest; t <= temperature.highest; ++t) {
        Candidate candidate;
        candidate.temperature = t;
        candidate.gradient = g;
        candidate.rate = r;
        candidate.columns = columns_of(terms, t, g, r, powers, settings.has("startup_time"));
        out.push_back(std::move(candidate));
      }
  return out;
}

double averages_in(const std::vector<RunData>& runs) {
  double count = 0.0;
  for (const auto& run : runs) count += static_cast<double>(run.time.size());
  return count;
}

/// Whether T changes within a run by more than 1 mK, which no sensor resolves.
bool temperature_varies(const std::vector<RunData>& runs) {
  return std::ranges::any_of(runs, [](const RunData& run) {
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
    for (std::size_t k = 0; k < run.time.size(); ++k) {
      if (run.share[k] <= 0.0) continue;
      lowest = std::min(lowest, run.felt[k].temperature);
      highest = std::max(highest, run.felt[k].temperature);
    }
    return highest - lowest > least_temperature_change;
  });
}

/// Start temperatures that differ by more than 2 K count as different.
std::size_t distinct_starts(const std::vector<RunData>& runs) {
  std::vector<double> starts;
  for (const auto& run : runs)
    if (!run.held_out) starts.push_back(run.start_temperature);
  std::ranges::sort(starts);
  std::size_t count = 0;
  double last = -std::numeric_limits<double>::infinity();
  for (const double start : starts)
    if (start - last > other_start) {
      ++count;
      last = start;
    }
  return count;
}

void refuse_too_few(const std::vector<RunData>& runs, const Settings& settings) {
  const auto powers = static_cast<std::size_t>(settings.integer("start_temperature_power")) + 1;
  const std::size_t starts = distinct_starts(runs);
  std::size_t averages = 0;
  for (const auto& run : runs)
    averages += static_cast<std::size_t>(std::ranges::count_if(run.share, [](double s) { return s > 0.0; }));
  if (starts < powers)
    throw Error(Error::Kind::bad_data,
                starts == 1
                    ? say("{} start temperature (more than 2 K apart) cannot determine a polynomial of {} terms in the "
                          "start temperature: add runs, or set start_temperature_power = {}",
                          starts, powers, 0)
                    : say("{} start temperatures (more than 2 K apart) cannot determine a polynomial of {} terms in "
                          "the start temperature: add runs, or set start_temperature_power = {}",
                          starts, powers, starts ? starts - 1 : 0));
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  for (const auto& run : runs)
    for (std::size_t k = 0; k < run.time.size(); ++k)
      if (run.share[k] > 0.0) {
        lowest = std::min(lowest, run.output[k]);
        highest = std::max(highest, run.output[k]);
      }
  if (averages < fewest_averages_of_run)
    throw Error(Error::Kind::bad_data, say("{} averages of {:.6g} s are too few: the recordings are too short, or "
                                           "averaging is too long",
                                           averages, settings.number("averaging")));
  if (!(highest > lowest))
    throw Error(Error::Kind::bad_data, "the gyro's output is constant: nothing can be identified from it");
  if (!temperature_varies(runs))
    throw Error(
        Error::Kind::bad_data,
        "the temperature does not vary within any run: no coefficient can be determined; add runs that change the "
        "temperature, or use static_bias");
}

std::vector<std::string> names_of(const std::vector<Term>& terms) {
  std::vector<std::string> names;
  for (const auto& term : terms) names.push_back(term.name);
  return names;
}

std::vector<std::size_t> union_of(const std::vector<Candidate>& candidates) {
  std::vector<std::size_t> all;
  for (const auto& candidate : candidates)
    for (const auto column : candidate.columns)
      if (std::ranges::find(all, column) == all.end()) all.push_back(column);
  return all;
}

std::vector<double> start_differences(const std::vector<RunData>& runs, const Settings& settings) {
  std::vector<double> starts;
  for (const auto& run : runs)
    if (!run.held_out) starts.push_back(run.start_temperature - settings.number("start_temperature_reference"));
  return starts;
}

LinearFit fit_columns(const std::vector<std::size_t>& columns, Answer& answer, const Factors& factors,
                      const std::vector<std::size_t>& factorised, const Settings& settings,
                      const std::vector<std::string>& term_names) {
  std::vector<std::size_t> positions;
  std::vector<std::string> names;
  for (const auto column : columns) {
    positions.push_back(static_cast<std::size_t>(std::ranges::find(factorised, column) - factorised.begin()));
    names.push_back(term_names[column]);
  }
  if (settings.word("estimator") == "joint") return joint(factors, positions, names);
  answer.not_used.clear();
  return two_stage(factors, positions, static_cast<std::size_t>(settings.integer("start_temperature_power")) + 1,
                   start_differences(answer.runs, settings), answer.not_used);
}

/// Parameters of the columns `from` in the order of `to`, zero where `from` lacks one.
std::vector<double> placed(const std::vector<double>& parameters, const std::vector<std::size_t>& from,
                           const std::vector<std::size_t>& to) {
  std::vector<double> out(to.size(), 0.0);
  for (std::size_t k = 0; k < from.size(); ++k)
    out[static_cast<std::size_t>(std::ranges::find(to, from[k]) - to.begin())] = parameters[k];
  return out;
}

/// Values by the chosen candidate, covariance by the largest. Two stages fit the chosen one alone: the runs that
/// determine it by themselves may not determine the largest.
void fit_answer(Answer& answer, const Factors& factors, const std::vector<std::size_t>& factorised,
                const Settings& settings, const std::vector<std::string>& names) {
  if (settings.word("estimator") == "two_stage") answer.largest = answer.chosen;
  const auto& chosen = answer.candidates[answer.chosen].columns;
  answer.columns = answer.candidates[answer.largest].columns;
  const LinearFit fit = fit_columns(chosen, answer, factors, factorised, settings, names);
  answer.fit =
      answer.largest == answer.chosen ? fit : fit_columns(answer.columns, answer, factors, factorised, settings, names);
  answer.fit.parameters = placed(fit.parameters, chosen, answer.columns);
  answer.fit.chi_square = fit.chi_square;
  answer.fit.degrees_of_freedom = fit.degrees_of_freedom;
}

/// Levels of the runs that have data, with their start temperatures less the reference and their places among the fitted
/// runs.
struct LevelsOfRuns {
  std::vector<RunLevel> levels;
  std::vector<double> starts;  ///< [K]
  std::vector<std::size_t> which;
};

/// Given: factors of answer.columns alone or among others, whose places are `positions`.
LevelsOfRuns levels_with_data(const Answer& answer, const Factors& factors, const std::vector<std::size_t>& factorised,
                              const Settings& settings) {
  const auto starts = start_differences(answer.runs, settings);
  LevelsOfRuns out;
  for (std::size_t r = 0; r < factors.levels.size(); ++r) {
    if (!std::isfinite(factors.levels[r].variance)) continue;
    RunLevel level{factors.levels[r].output, {}, factors.levels[r].variance};
    for (const auto column : answer.columns)
      level.regressors.push_back(
          factors.levels[r]
              .regressors[static_cast<std::size_t>(std::ranges::find(factorised, column) - factorised.begin())]);
    out.levels.push_back(std::move(level));
    out.starts.push_back(starts[r]);
    out.which.push_back(r);
  }
  return out;
}

std::size_t powers_of_start(const Settings& settings) {
  return static_cast<std::size_t>(settings.integer("start_temperature_power")) + 1;
}

LevelFit fit_of(const LevelsOfRuns& of, const Answer& answer, const Settings& settings, double known_turn_on = -1.0) {
  const std::size_t powers = powers_of_start(settings);
  if (of.levels.size() < powers + 2) return {};
  return fit_levels(of.levels, answer.fit.parameters, answer.fit.covariance, of.starts, powers, answer.fit.inflation,
                    known_turn_on);
}

/// The levels without what the coefficients explain, and the powers of their start temperatures.
struct PowerUps {
  std::vector<PowerUpValue> values;
  Matrix design;
};

PowerUps power_ups_of(const LevelsOfRuns& of, const Answer& answer, const Settings& settings) {
  const std::size_t powers = powers_of_start(settings);
  std::vector<int> numbers;
  for (const RunData& run : answer.runs)
    if (!run.held_out) numbers.push_back(run.number);
  PowerUps out{{}, Matrix(of.levels.size(), powers)};
  for (std::size_t k = 0; k < of.levels.size(); ++k) {
    const RunLevel& level = of.levels[k];
    const double known = level.variance + quadratic_form(level.regressors, answer.fit.covariance);
    out.values.push_back({fmt::format("run {}", numbers[of.which[k]]),
                          level.output - dot(level.regressors, answer.fit.parameters), known});
    for (std::size_t j = 0; j < powers; ++j) out.design(k, j) = std::pow(of.starts[k], static_cast<double>(j));
  }
  return out;
}

/// See LevelFit::least_turn_on.
double least_turn_on(LevelsOfRuns of, const PowerUps& power_ups, const Answer& answer, const Settings& settings) {
  const auto which = doubtful_power_up(power_ups.values, power_ups.design);
  if (!which) return std::nan("");
  const auto place = static_cast<std::ptrdiff_t>(*which);
  of.levels.erase(of.levels.begin() + place);
  of.starts.erase(of.starts.begin() + place);
  const LevelFit rest = fit_of(of, answer, settings);
  if (rest.bias.empty()) return std::nan("");
  if (!(rest.turn_on_variance > 0.0)) return 0.0;
  return interval_of_excess_sd(rest.turn_on_variance + rest.noise_variance, rest.total_freedom, rest.noise_variance,
                               std::numeric_limits<double>::infinity())
      .lower;
}

/// The fit of the levels, and whether they change from power-up to power-up otherwise than by chance and by their start
/// temperature.
void add_levels(const Factors& factors, const std::vector<std::size_t>& factorised, const Settings& settings,
                Answer& answer) {
  const LevelsOfRuns of = levels_with_data(answer, factors, factorised, settings);
  const PowerUps power_ups = power_ups_of(of, answer, settings);
  answer.levels = fit_of(of, answer, settings);
  answer.levels.least_turn_on = least_turn_on(of, power_ups, answer, settings);
  for (Finding& one : uneven_power_ups(power_ups.values, power_ups.design, Unit::parse("deg/h")))
    answer.uneven.push_back(std::move(one));
}

bool shows_gradient(const std::vector<RunData>& runs) {
  return std::ranges::any_of(runs, [](const RunData& run) {
    return std::ranges::any_of(run.felt, [](const Felt& f) { return f.temperature_gradient != 0.0; });
  });
}

/// What the runs say beyond noise: of those that were fitted, and of each as the others predict it.
Misfit misfits_of(const Factors& factors, const std::vector<std::size_t>& factorised, const Answer& answer,
                  const std::vector<std::size_t>& departures, std::size_t terms) {
  auto misfit = misfit_of(factors, factorised, answer.runs, answer.columns, answer.fit.parameters, departures, terms);
  misfit.predicted = predicted_misfit(factors, factorised, answer.runs, answer.columns,
                                      answer.candidates[answer.chosen].columns, departures);
  return misfit;
}

}  // namespace

Answer solve(const Evidence& evidence, const std::vector<Term>& terms, double lag, const Progress& progress) {
  const Settings& settings = evidence.plan.settings;
  Answer answer;
  const double interval = settings.number("averaging");
  answer.runs = run_data(evidence, terms, lag, interval);
  refuse_too_few(answer.runs, settings);
  report(progress, 0.3, "fitting the noise");
  answer.candidates = candidates_of(settings, terms, shows_gradient(answer.runs));
  const auto model = union_of(answer.candidates);
  const auto departures = determined_departures(answer.runs, model, terms.size());
  auto factorised = model;
  factorised.insert(factorised.end(), departures.begin(), departures.end());
  // The noise is slow: a few thousand averages determine it as well as all, and its terms hold at any interval.
  const double coarse = interval * std::ceil(averages_in(answer.runs) / most_coarse);
  const auto coarse_runs = coarse > interval ? run_data(evidence, terms, lag, coarse) : std::vector<RunData>{};
  const auto& noise_runs = coarse > interval ? coarse_runs : answer.runs;
  const Likelihood likelihood(noise_runs, factorised, coarse);
  const auto most_likely = likelihood.most_likely();
  answer.noise = likelihood.noise(most_likely);
  const Factors factors = factorise(answer.runs, factorised, answer.noise, interval);
  report(progress, 0.7, "choosing the orders");
  const auto names = names_of(terms);
  for (auto& candidate : answer.candidates) score(candidate, factors, factorised, answer.runs, names);
  answer.chosen = choose(answer.candidates);
  answer.largest = largest_supported(answer.candidates, answer.chosen);
  fit_answer(answer, factors, factorised, settings, names);
  answer.misfit = misfits_of(factors, factorised, answer, departures, terms.size());
  add_levels(factors, factorised, settings, answer);
  for (const Findings& some : {uneven_runs(answer, interval), beside_model(answer, interval)})
    answer.uneven.insert(answer.uneven.end(), some.begin(), some.end());
  const auto& columns = answer.columns;
  answer.degrees_of_freedom = degrees_of_freedom(likelihood, most_likely, [&](const NoiseModel& noise) {
    Answer other = answer;
    const auto fit =
        fit_columns(columns, other, factorise(answer.runs, columns, noise, interval), columns, settings, names);
    std::vector<double> variances(columns.size());
    for (std::size_t k = 0; k < columns.size(); ++k) variances[k] = fit.covariance(k, k) / fit.inflation;
    return variances;
  });
  return answer;
}

std::vector<double> shift_by_lag(const Evidence& evidence, const std::vector<Term>& terms, const Answer& answer,
                                 double lag) {
  const Settings& settings = evidence.plan.settings;
  const double interval = settings.number("averaging");
  Answer other = answer;
  other.runs = run_data(evidence, terms, lag, interval);
  const Factors factors = factorise(other.runs, answer.columns, answer.noise, interval);
  const auto& chosen = answer.candidates[answer.chosen].columns;
  const auto fit = fit_columns(chosen, other, factors, answer.columns, settings, names_of(terms));
  other.fit.parameters = placed(fit.parameters, chosen, answer.columns);
  std::vector<double> shift = difference(other.fit.parameters, answer.fit.parameters);
  if (answer.levels.bias.empty()) return shift;
  const LevelFit levels = fit_of(levels_with_data(other, factors, answer.columns, settings), other, settings,
                                 answer.levels.turn_on_variance);
  for (std::size_t j = 0; j < answer.levels.bias.size(); ++j)
    shift.push_back(levels.bias.empty() ? 0.0 : levels.bias[j] - answer.levels.bias[j]);
  return shift;
}

}  // namespace tumble::fog_thermal_bias
