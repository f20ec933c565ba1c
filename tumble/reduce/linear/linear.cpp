#include "tumble/reduce/linear/linear.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/reduce/coarse_output.hpp"
#include "tumble/reduce/linear/missing.hpp"
#include "tumble/reduce/linear/rest_noise.hpp"
#include "tumble/reduce/linear/rounding.hpp"
#include "tumble/reduce/linear/rows.hpp"
#include "tumble/reduce/linear/slow.hpp"
#include "tumble/reduce/linear/words.hpp"
#include "tumble/reduce/linear/work.hpp"
#include "tumble/reduce/output_model.hpp"
#include "tumble/units/error.hpp"

namespace tumble::linear {
namespace {

constexpr double least_rounding = 1e-3;  ///< [steps] of a mean: with more noise than 0.52 steps it is less

/// Which columns the evidence shows, as indices of Problem::columns; the others are put into the solution's `dropped`.
std::vector<std::size_t> observable(const Problem& problem, const Rows& rows, Solution& solution) {
  std::vector<std::size_t> preference, used;
  for (const auto& name : problem.leave_out_first)
    for (std::size_t j = 0; j < problem.columns.size(); ++j)
      if (problem.columns[j].name == name) preference.push_back(j);
  solution.dropped = unobservable_columns(rows.design, rows.weights, rows.natural, preference, problem.condition_limit);
  for (std::size_t j = 0; j < problem.columns.size(); ++j)
    if (std::ranges::none_of(solution.dropped, [j](const Dropped& dropped) { return dropped.column == j; })) {
      used.push_back(j);
      solution.columns.push_back(problem.columns[j]), solution.channels.push_back(problem.role);
      const auto [least, greatest] = std::ranges::minmax(column(rows.design, j));
      solution.least.push_back(least);
      solution.greatest.push_back(greatest);
    }
  return used;
}

/// The columns that the schedule would not show if every segment of it were recorded; none where the plan cannot be
/// asked, since it lacks a rate.
std::vector<std::size_t> hidden_by_schedule(const Plan& plan, const Problem& problem) try {
  Solution planned;
  observable(problem, rows_of(evidence_of(plan, problem), problem), planned);
  std::vector<std::size_t> columns;
  for (const auto& dropped : planned.dropped) columns.push_back(dropped.column);
  return columns;
} catch (const Error&) {
  return {};
}

/// Every stretch is one segment of the mixed model. Power-ups of different plans are different ones.
std::vector<Interval> intervals_of(const ConductedTest& test) {
  std::vector<Interval> intervals;
  for (const auto& stretch : test.stretches)
    intervals.push_back({stretch.start, test.power_ups[stretch.power_up].offset + stretch.first, stretch.duration()});
  return intervals;
}

/// Mean prediction of each segment and what white noise and rounding do to its mean.
void fill_segments(Work& work, const std::vector<double>& predicted) {
  std::vector<SegmentSummary>& segments = work.solution.segments;
  segments = work.rows.segments;
  const double white = work.solution.fit.white_variance;
  for (std::size_t g = 0; g < segments.size(); ++g) {
    const double rounding = !work.rounded.empty() && work.rounded[g] ? work.rounding_sd : 0.0;
    segments[g].predicted = 0.0;
    segments[g].rounding = rounding;
    segments[g].sd = std::hypot(std::sqrt(white / segments[g].duration), rounding);
  }
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    auto& segment = segments[work.rows.segment[i]];
    segment.predicted += predicted[i] * work.rows.weights[i] / segment.duration;
  }
}

void refuse_too_few(std::size_t rows, std::size_t columns) {
  if (columns == 0) throw Error(Error::Kind::bad_data, "the schedule shows none of the parameters");
  if (rows < columns + 1)
    throw Error(Error::Kind::bad_data,
                say("{} averages are too few for {} parameters and the noise: shorten averaging or settling, or "
                    "add segments",
                    rows, columns));
}

/// Coefficients of all columns from those of the columns used; 0 for the others.
std::vector<double> spread(const std::vector<std::size_t>& used, const std::vector<double>& b, std::size_t columns) {
  std::vector<double> all(columns, 0.0);
  for (std::size_t k = 0; k < used.size(); ++k) all[used[k]] = b[k];
  return all;
}

/// Coefficients by least squares: the effects of the rig's errors depend on them.
///
/// Given     weights  [N] of the rows
std::vector<double> first_look(const Matrix& design, const std::vector<double>& y, std::vector<double> weights) {
  for (double& weight : weights) weight = std::sqrt(weight);
  Matrix x = scaled_rows(weights, design);
  const auto scale = inverses(column_norms(x));
  x = scaled_columns(std::move(x), scale);
  return scaled(scale, solve(householder_qr(x), scaled(weights, y)));
}

std::vector<double> coefficients_for(const Problem& problem, const Truth& truth) {
  std::vector<double> all;
  for (const auto& column : problem.columns) {
    const auto value = truth.coefficients.find(column.name);
    all.push_back(value == truth.coefficients.end() ? 0.0 : value->second);
  }
  return all;
}

/// The bias instability stated, as the output shows it.
double stated_for(const Problem& problem, const std::vector<std::size_t>& used,
                  const std::vector<double>& coefficients) {
  double per = problem.stated_per.empty() ? 1.0 : 0.0;
  for (const std::size_t column : used)
    if (problem.columns[column].name == problem.stated_per) per = std::abs(coefficients[column]);
  return per * problem.bias_instability;
}

/// Standard deviation of a segment's shift by the slow noise of this source [SI], as estimated or as stated.
double shift_sd(const std::string& source, const std::vector<SlowNoise>& slow, const std::vector<double>& variance) {
  double sum = 0.0;
  for (std::size_t c = 0; c < slow.size(); ++c) {
    if (slow[c].source != source) continue;
    const Matrix& kernel = slow[c].kernel;
    for (std::size_t g = 0; g < kernel.rows; ++g) sum += variance[c] * kernel(g, g) / static_cast<double>(kernel.rows);
  }
  return std::sqrt(sum);
}

/// What the intervals rest on where the terms explain every difference between the segments.
void say_origin(const Problem& problem, const std::vector<SlowNoise>& slow, Solution& solution) {
  using Severity = Finding::Severity;
  for (std::size_t c = 0; c < slow.size(); ++c)
    if (const SlowOrigin origin = solution.fit.slow_origin[c]; origin == SlowOrigin::within)
      solution.findings.push_back(
          {Severity::info, "drift_from_within_segments", {{"setting", problem.stated_by}}, problem.role});
    else if (origin == SlowOrigin::nothing_shows)
      solution.findings.push_back({Severity::warning,
                                   "slow_noise_not_included",
                                   {{"source", slow[c].source}, {"setting", problem.stated_by}},
                                   problem.role});
}

/// Whether samples of the output are rounded one by one: a counter passes the rest on to the next.
bool rounds_samples(const Evidence& evidence, const Problem& problem) {
  const Channel* channel = channel_for(evidence, evidence.recordings.front(), problem.role);
  return !(problem.pulse > 0.0) && channel && channel->kind != QuantityKind::count &&
         channel->kind != QuantityKind::angle;
}

/// Whether the output counts pulses of a size that is not known before: rounding to whole ones is one noise where the rig
/// rests and another where it moves.
bool counts_unknown_pulses(const Evidence& evidence, const Problem& problem) {
  const Channel* channel = channel_for(evidence, evidence.recordings.front(), problem.role);
  return !(problem.pulse > 0.0) && channel && channel->kind == QuantityKind::count;
}

/// The rounding of a coarse output moves the mean of each segment.
void add_rounding(const Evidence& evidence, const Problem& problem, Work& work) {
  if (!rounds_samples(evidence, problem)) return;
  const auto coarse = coarse_output(work.evidence.test);
  if (!coarse || coarse->rounding_sd < least_rounding * coarse->step) return;
  work.rounded = rounded_alike(work, coarse->step);
  for (KnownEffect& effect : rounding_effects(work, *coarse)) work.data.effects.push_back(std::move(effect));
  work.rounding_sd = coarse->rounding_sd;
  work.solution.findings.push_back({Finding::Severity::info,
                                    "rounding_moves_means",
                                    {{"times", coarse->step / std::max(coarse->noise, least_rounding * coarse->step)},
                                     {"share", coarse->rounding_sd / coarse->step}},
                                    problem.role});
}

double white_variance(const NoiseModel& noise) { return noise.angle_random_walk * noise.angle_random_walk; }

}  // namespace

void prepare(const Evidence& evidence, const Problem& problem, Work& work) {
  Solution& solution = work.solution;
  solution.findings = work.evidence.test.findings;
  solution.output.role = problem.role;
  if (const auto& input = problem.input.products(); input.size() == 1 && input[0].factors.size() == 1)
    solution.output.shows = input[0].factors[0].input;
  if (const Channel* channel =
          evidence.recordings.empty() ? nullptr : channel_for(evidence, evidence.recordings.front(), problem.role))
    set_reading(*channel, problem.scale, solution.output);
  work.used = observable(problem, work.rows, solution);
  if (!solution.dropped.empty()) solution.hidden_by_schedule = hidden_by_schedule(evidence.plan, problem);
  refuse_too_few(work.rows.weights.size(), work.used.size());
  work.counting = take_out_counting(work.evidence, problem, work.rows);

  MixedData& data = work.data;
  data = {.design = chosen_columns(work.rows.design, work.used),
          .weights = work.rows.weights,
          .segment = work.rows.segment};
  data.observations = work.rows.output;
  for (std::size_t i = 0; i < work.rows.input.size(); ++i) data.observations[i] -= work.rows.input[i];
  const auto look = first_look(data.design, data.observations, data.weights);
  work.coefficients = spread(work.used, look, problem.columns.size());
}

void prepare(const Problem& problem, const Truth& truth, Work& work) {
  work.solution.findings = work.evidence.test.findings;
  work.used = observable(problem, work.rows, work.solution);
  refuse_too_few(work.rows.weights.size(), work.used.size());
  work.coefficients = coefficients_for(problem, truth);
  work.data = {.design = chosen_columns(work.rows.design, work.used),
               .weights = work.rows.weights,
               .segment = work.rows.segment};
}

void finish(const Evidence& evidence, const Problem& problem, Work& work) {
  Solution& solution = work.solution;
  MixedData& data = work.data;
  if (problem.pulse > 0.0) data.effects.push_back(std::move(work.counting));
  add_rounding(evidence, problem, work);
  const double step = work.evidence.test.stretches.front().step;
  data.slow = unknown_slow_noise(intervals_of(work.evidence.test), work.used.size(), step,
                                 stated_for(problem, work.used, work.coefficients));
  solution.fit = fit_mixed_model(data);
  say_origin(problem, data.slow, solution);
  solution.observations = work.rows.weights.size();
  set_fitted(work, solution.fit.fitted);
  solution.drift_sd = shift_sd(drift_source, data.slow, solution.fit.slow_variance);
  warn_of_excess(problem, work);
  describe_dropped(problem, solution);
  warn_of_lack_of_fit(problem, work);
  warn_of_begins(problem, work);
  if (!counts_unknown_pulses(evidence, problem)) warn_of_motion(problem, work);
  warn_of_missing_terms(problem, work);
}

void finish(const Problem& problem, const Truth& truth, Work& work) {
  Solution& solution = work.solution;
  MixedData& data = work.data;
  const auto& all = work.coefficients;
  if (problem.pulse > 0.0) data.effects.push_back(take_out_counting(work.evidence, problem, work.rows));
  const double step = work.evidence.test.stretches.front().step;
  data.slow = known_slow_noise(intervals_of(work.evidence.test), truth.noise, truth.turn_on_sd, step);
  solution.fit = predict_mixed_model(data, white_variance(truth.noise));
  for (std::size_t k = 0; k < work.used.size(); ++k) solution.fit.parameters[k] = all[work.used[k]];
  for (const auto& dropped : solution.dropped)
    for (std::size_t k = 0; k < work.used.size(); ++k)
      solution.fit.parameters[k] += dropped.weights[work.used[k]] * all[dropped.column];
  solution.observations = work.rows.weights.size();
  set_fitted(work, work.rows.design * all);
  describe_dropped(problem, solution);
}

void set_fitted(Work& work, std::span<const double> fitted) {
  std::vector<double> predicted(fitted.begin(), fitted.end());
  for (std::size_t i = 0; i < predicted.size(); ++i) predicted[i] += work.rows.input[i];
  fill_segments(work, predicted);
}

void add_doubt(const Solution& solution, std::size_t first, MixedFit& fit) {
  if (solution.doubt.empty()) return;
  Matrix covariance(fit.parameters.size(), fit.parameters.size());
  for (const auto& shift : solution.doubt)
    for (std::size_t i = 0; i < shift.size(); ++i)
      for (std::size_t j = 0; j < shift.size(); ++j) covariance(first + i, first + j) += shift[i] * shift[j];
  fit.covariance += covariance;
  fit.sources.push_back({"term that the model may lack", std::move(covariance)});
}

Solution identify(const Evidence& evidence, const Problem& problem) {
  Solution solution = std::move(worked_out(evidence, std::span(&problem, 1)).front().solution);
  add_doubt(solution, 0, solution.fit);
  return solution;
}

Solution predict(const Plan& plan, const Problem& problem, const Truth& truth) {
  return std::move(worked_out(plan, std::span(&problem, 1), std::span(&truth, 1)).front().solution);
}

namespace {

/// A' V^-1 A of the rows of one segment. The rows are whitened; slow noise and the errors of the segment alone enter by
/// V^-1 = W - W U (1 + U' W U)^-1 U' W, with their shifts U.
Matrix information_of(const Matrix& a, const std::vector<const KnownEffect*>& own, const std::vector<double>& weights,
                      const std::vector<std::size_t>& rows, double white, double slow) {
  Matrix shifts(rows.size(), own.size() + 1);
  std::vector<double> root;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    root.push_back(std::sqrt(weights[rows[i]] / white));
    shifts(i, 0) = std::sqrt(slow);
    for (std::size_t e = 0; e < own.size(); ++e) shifts(i, e + 1) = own[e]->column[rows[i]];
  }
  const Matrix whitened = scaled_rows(root, chosen_rows(a, rows));
  shifts = scaled_rows(root, std::move(shifts));
  const Matrix cross = transposed_product(shifts, whitened);
  const Matrix inner = gram(shifts) + identity(shifts.columns);
  return gram(whitened) - transposed_product(cross, solve_symmetric(inner, cross));
}

}  // namespace

Information information(const Plan& plan, const Problem& problem, const Truth& truth) {
  const Evidences evidence = evidence_of(plan, problem);
  const Rows rows = rows_of(evidence, problem);
  const auto effects = effects_of(evidence, problem, rows, coefficients_for(problem, truth));
  if (!(white_variance(truth.noise) > 0.0))
    throw Error(Error::Kind::bad_input, "the plan's [truth] has no white noise: nothing limits the information");
  Information out;
  out.columns = problem.columns.size();
  std::vector<const KnownEffect*> own;
  Matrix a = rows.design;
  for (const auto& effect : effects) {
    if (effect.each_segment) {
      own.push_back(&effect);
      continue;
    }
    out.errors.push_back(effect.source);
    a.values.insert(a.values.end(), effect.column.begin(), effect.column.end());
    ++a.columns;
  }
  std::vector<std::vector<std::size_t>> taken(evidence.test.stretches.size());
  for (std::size_t i = 0; i < rows.segment.size(); ++i) taken[rows.segment[i]].push_back(i);
  std::map<std::pair<std::size_t, std::size_t>, Matrix> by_place;
  for (std::size_t g = 0; g < evidence.test.stretches.size(); ++g) {
    const Stretch& stretch = evidence.test.stretches[g];
    // on its own: as if the segment began with power-on
    const auto slow = known_slow_noise({{0, 0.0, stretch.duration()}}, truth.noise, 0.0, stretch.step);
    by_place[{stretch.power_up, stretch.segment}] =
        information_of(a, own, rows.weights, taken[g], white_variance(truth.noise), slow[0].kernel(0, 0));
  }
  for (std::size_t u = 0; u < evidence.test.power_ups.size(); ++u)
    for (std::size_t s = 0; s < evidence.test.power_ups[u].rig.segments.size(); ++s) {
      const auto place = by_place.find({u, s});
      out.of_segment.push_back(place == by_place.end() ? Matrix(a.columns, a.columns) : place->second);
    }
  return out;
}

Truth truth_of(const Plan& plan, const std::string& channel) {
  Problems problems;
  if (plan.instrument_model.empty()) problems.push_back("a prediction needs [instrument] model = \"...\"");
  if (plan.truth.texts().empty()) problems.push_back("a prediction needs [truth] with the noise that is expected");
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  const Model& model = find_model(plan.instrument_model);
  for (const auto& output : model.outputs(plan.truth)) {
    if (output.channel != channel) continue;
    Truth truth;
    const auto values = coefficients_of(model, output, plan.truth);
    for (std::size_t k = 0; k < values.size(); ++k) truth.coefficients[output.terms[k].name] = values[k];
    truth.noise = noise_of(plan.truth, output.noise_prefix);
    truth.turn_on_sd = plan.truth.number(output.noise_prefix + "turn_on_repeatability");
    return truth;
  }
  throw Error(Error::Kind::bad_input, say("model {} has no output '{}'", Name{plan.instrument_model}, channel));
}

}  // namespace tumble::linear
