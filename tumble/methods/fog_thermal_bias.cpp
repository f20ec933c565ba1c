#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "tumble/math/least_squares.hpp"
#include "tumble/methods/fog_thermal_bias/compensate.hpp"
#include "tumble/methods/fog_thermal_bias/findings.hpp"
#include "tumble/methods/fog_thermal_bias/fit.hpp"
#include "tumble/methods/fog_thermal_bias/range.hpp"
#include "tumble/methods/fog_thermal_bias/trial.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/error.hpp"

// Symbols of the source (spec 5.4): L output, L_0 its mean over the first two minutes, T temperature, DT gradient
// (top minus side sensor), T_0 start temperature; A_i, B_j, C_k coefficients of T, DT and dT/dt, each a cubic in T_0:
//   L - L_0 = sum A_i (T - T_0)^i + sum B_j DT^j + sum C_k (dT/dt)^k                 (5.1)
//   a_i(T_0) = A_i0 + A_i1 T_0 + A_i2 T_0^2 + A_i3 T_0^3                             (5.3)
// Every run has a free level instead of L_0, whose noise would else go into the coefficients (spec 5.5).

namespace tumble::methods {
namespace {

using namespace fog;

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
  return {std::stoi(word), std::stoi(word)};
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
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "fog_thermal_bias needs at least one recording");
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
    if (start - last > 2.0) {
      ++count;
      last = start;
    }
  return count;
}

void refuse_too_few(const std::vector<RunData>& runs, const Settings& settings) {
  const auto powers = static_cast<std::size_t>(settings.integer("start_temperature_power") + 1);
  const std::size_t starts = distinct_starts(runs);
  std::size_t averages = 0;
  for (const auto& run : runs)
    averages += static_cast<std::size_t>(std::ranges::count_if(run.share, [](double s) { return s > 0.0; }));
  if (starts < powers)
    throw Error(
        Error::Kind::bad_data,
        fmt::format("{} start temperature{} (more than 2 K apart) cannot determine a polynomial of {} terms in the "
                    "start temperature: add runs, or set start_temperature_power = {}",
                    starts, starts == 1 ? "" : "s", powers, starts ? starts - 1 : 0));
  const bool constant = std::ranges::all_of(runs, [](const RunData& run) {
    const auto spread = std::ranges::minmax(run.output);
    return run.output.empty() || spread.min == spread.max;
  });
  if (averages < 10 || constant)
    throw Error(Error::Kind::bad_data,
                constant
                    ? std::string("the gyro's output is constant: nothing can be identified from it")
                    : fmt::format("{} averages of {:.6g} s are too few: the recordings are shorter than the method "
                                  "can use",
                                  averages, settings.number("averaging")));
}

/// Everything identified at one assumed sensor lag.
struct Answer {
  std::vector<RunData> runs;
  std::vector<Candidate> candidates;
  std::size_t chosen = 0;
  NoiseModel noise;
  LinearFit fit;
  std::vector<double> degrees_of_freedom;  ///< of each parameter's variance
  std::vector<std::size_t> not_used;       ///< two_stage: runs that say nothing by themselves
};

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

LinearFit fit_chosen(Answer& answer, const Factors& factors, const std::vector<std::size_t>& factorised,
                     const Settings& settings, const std::vector<Term>& terms) {
  std::vector<std::size_t> positions;
  std::vector<std::string> names;
  for (const auto column : answer.candidates[answer.chosen].columns) {
    positions.push_back(static_cast<std::size_t>(std::ranges::find(factorised, column) - factorised.begin()));
    names.push_back(terms[column].name);
  }
  if (settings.word("estimator") == "joint") return joint(factors, positions, names);
  std::vector<double> starts;
  for (const auto& run : answer.runs)
    if (!run.held_out) starts.push_back(run.start_temperature - settings.number("start_temperature_reference"));
  return two_stage(factors, positions, settings.integer("start_temperature_power") + 1, starts, answer.not_used);
}

Answer solve(const Evidence& evidence, const std::vector<Term>& terms, double lag, const Progress& progress) {
  const Settings& settings = evidence.plan.settings;
  Answer answer;
  answer.runs = run_data(evidence, terms, lag);
  refuse_too_few(answer.runs, settings);
  report(progress, 0.3, "fitting the noise");
  const bool gradient_seen = std::ranges::any_of(answer.runs, [](const RunData& run) {
    return std::ranges::any_of(run.felt, [](const Felt& f) { return f.temperature_gradient != 0.0; });
  });
  answer.candidates = candidates_of(settings, terms, gradient_seen);
  const auto factorised = union_of(answer.candidates);
  const double interval = settings.number("averaging");
  const Likelihood likelihood(answer.runs, factorised, interval);
  const auto most_likely = likelihood.most_likely();
  answer.noise = likelihood.noise(most_likely);
  const Factors factors = factorise(answer.runs, factorised, answer.noise, interval);
  report(progress, 0.7, "choosing the orders on held-out runs");
  const auto names = names_of(terms);
  for (auto& candidate : answer.candidates) score(candidate, factors, factorised, answer.runs, names);
  answer.chosen = choose(answer.candidates);
  answer.fit = fit_chosen(answer, factors, factorised, settings, terms);
  const auto& columns = answer.candidates[answer.chosen].columns;
  answer.degrees_of_freedom = degrees_of_freedom(likelihood, most_likely, [&](const NoiseModel& noise) {
    Answer other = answer;
    const auto fit = fit_chosen(other, factorise(answer.runs, columns, noise, interval), columns, settings, terms);
    std::vector<double> variances(columns.size());
    for (std::size_t k = 0; k < columns.size(); ++k) variances[k] = fit.covariance(k, k) / fit.inflation;
    return variances;
  });
  return answer;
}

/// The same columns at another lag: what the lag's uncertainty does to the coefficients.
std::vector<double> shift_by_lag(const Evidence& evidence, const std::vector<Term>& terms, const Answer& answer,
                                 double lag) {
  const double interval = evidence.plan.settings.number("averaging");
  Answer other = answer;
  other.runs = run_data(evidence, terms, lag);
  const auto& columns = answer.candidates[answer.chosen].columns;
  const Factors factors = factorise(other.runs, columns, answer.noise, interval);
  const auto fit = fit_chosen(other, factors, columns, evidence.plan.settings, terms);
  std::vector<double> shift(columns.size());
  for (std::size_t k = 0; k < columns.size(); ++k) shift[k] = fit.parameters[k] - answer.fit.parameters[k];
  return shift;
}

/// Enlarges covariance and budget by one row and column for a parameter that is uncorrelated with the others.
void append_parameter(Estimate& estimate, Parameter parameter, double variance) {
  const std::size_t n = estimate.parameters.size();
  Matrix covariance(n + 1, n + 1);
  for (std::size_t r = 0; r < n; ++r)
    for (std::size_t c = 0; c < n; ++c) covariance(r, c) = estimate.covariance(r, c);
  covariance(n, n) = variance;
  estimate.covariance = std::move(covariance);
  for (std::size_t b = 0; b < estimate.budget.size(); ++b)
    estimate.budget[b].variance.push_back(b == 0 ? variance : 0.0);
  estimate.parameters.push_back(std::move(parameter));
}

/// Standard deviations before and after, with their uncertainty from leaving each run out (jackknife).
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
    append_parameter(estimate, {s.name, s.symbol, unit, std::sqrt(sum / count), s.description, std::max(1.0, n - 1.0)},
                     spread);
  }
}

/// L_0 over start temperature by least squares on the runs' levels; the scatter is the turn-on repeatability.
void append_levels(Estimate& estimate, const Answer& answer, const Settings& settings, const std::vector<Term>& terms) {
  const Candidate& chosen = answer.candidates[answer.chosen];
  const auto powers = static_cast<std::size_t>(settings.integer("start_temperature_power") + 1);
  std::vector<double> levels, starts;
  for (const auto& run : answer.runs) {
    if (run.held_out) continue;
    double sum = 0.0, count = 0.0;
    for (std::size_t k = 0; k < run.time.size(); ++k) {
      if (run.share[k] <= 0.0) continue;
      double left = run.output[k];
      for (std::size_t c = 0; c < chosen.columns.size(); ++c)
        left -= answer.fit.parameters[c] * run.regressors(k, chosen.columns[c]);
      sum += left;
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
  const std::size_t first = estimate.parameters.size();
  for (std::size_t j = 0; j < powers; ++j) {
    const auto term = std::ranges::find(terms, fmt::format("bias_{}", j), &Term::name);
    append_parameter(estimate,
                     {term->name, term->symbol, Unit::parse(term->unit), fit.parameters[j], term->description,
                      fit.degrees_of_freedom},
                     fit.covariance(j, j));
  }
  for (std::size_t j = 0; j < powers; ++j)
    for (std::size_t k = 0; k < powers; ++k) estimate.covariance(first + j, first + k) = fit.covariance(j, k);
  append_parameter(
      estimate,
      {"turn_on_repeatability", "s_on", Unit::parse("deg/h"), fit.sigma,
       "standard deviation of a run's level about the polynomial in the start temperature", fit.degrees_of_freedom},
      std::pow(uncertainty_of_sd(fit.sigma, fit.degrees_of_freedom), 2));
}

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
  estimate.covariance = answer.fit.covariance;
  estimate.budget.push_back({"output noise", {}});
  for (std::size_t k = 0; k < columns.size(); ++k) estimate.budget[0].variance.push_back(answer.fit.covariance(k, k));
  if (settings.number("sensor_lag_sd") > 0.0) {
    const auto shift =
        shift_by_lag(evidence, terms, answer, settings.number("sensor_lag") + settings.number("sensor_lag_sd"));
    estimate.budget.push_back({"temperature sensor lag", {}});
    for (std::size_t r = 0; r < shift.size(); ++r) {
      estimate.budget[1].variance.push_back(shift[r] * shift[r]);
      for (std::size_t c = 0; c < shift.size(); ++c) estimate.covariance(r, c) += shift[r] * shift[c];
    }
  }
  append_scores(estimate, answer);
  append_levels(estimate, answer, settings, terms);
  double averages = 0.0;
  for (const auto& run : answer.runs)
    if (!run.held_out) averages += residual_of(run, {}, {}).count;
  estimate.fit = {static_cast<std::size_t>(averages), answer.fit.degrees_of_freedom, answer.fit.chi_square,
                  answer.fit.condition};
  return estimate;
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  refuse_impossible(evidence);
  const Settings& settings = evidence.plan.settings;
  const Model& model = find_model("fiber_optic_gyro");
  const auto terms = model.terms(constants_of(settings));
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
  Evidence evidence{plan, {simulate(plan, 1, {})}};
  return identify(evidence, {});
}

}  // namespace

extern const Method fog_thermal_bias;
const Method fog_thermal_bias{
    .name = "fog_thermal_bias",
    .summary = "bias of a fibre-optic gyro over temperature, its gradient and its rate, with start temperature",
    .source =
        "Zhou Haiyuan et al., bias stability of a FOG by polynomial fitting, published 2018-04-04, eq. (5.1)-(5.4)",
    .needs_plan = false,
    .roles = roles,
    .options = options,
    .identify = identify,
    .trial = trial,
    .compensate = compensate,
    .predict = predict};

}  // namespace tumble::methods
