#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/core/columns.hpp"
#include "tumble/language/say.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/stability/allan_covariance.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/static_bias/averages.hpp"
#include "tumble/methods/static_bias/common_course.hpp"
#include "tumble/methods/static_bias/power_on.hpp"
#include "tumble/methods/static_bias/reference.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/reduce/even_signal.hpp"
#include "tumble/reduce/lost_by_value.hpp"
#include "tumble/reduce/output_model.hpp"
#include "tumble/reduce/power_ups.hpp"
#include "tumble/reduce/uneven_bias.hpp"
#include "tumble/reduce/zeros.hpp"
#include "tumble/units/error.hpp"

namespace tumble::static_bias {
namespace {

using Severity = Finding::Severity;

constexpr double shorter_time = 10.0;  ///< [s]
constexpr std::size_t ratio = 10;      ///< of the longer averages to the shorter

const std::vector<UnitTerm> terms{{NoiseTerm::white}, {NoiseTerm::flicker}, {NoiseTerm::random_walk}};

std::vector<Role> roles() {
  return {{"signal", "", false, "angular rate or specific force at rest; absent: the only such channel"}};
}

std::vector<Option> options() {
  return {quantity("rate", "Hz").above(0).bare().says("sampling rate, if the file does not state it or is wrong"),
          word("timing", {"auto", "even", "stamps"}).otherwise("auto").says("clock of the samples, as in allan_noise"),
          word("axis", {"none", "up", "down", "north", "south", "east", "west"})
              .otherwise("none")
              .says("direction of the input axis: the Earth's rate or gravity along it is subtracted (needs [site])")};
}

/// One power-up.
struct RunBias {
  std::string label, file;
  Sentence failure;
  Findings findings;
  double rate = 0.0;
  std::size_t samples = 0;
  double mean = 0.0;
  double rounding = 0.0;  ///< [u] sd of the mean by the steps of the output
  AverageScatter shorter, longer;
  Blocks blocks;
};

double mean_of(std::span<const double> values) {
  const double origin = *std::find_if(values.begin(), values.end(), [](double v) { return !std::isnan(v); });
  double sum = 0.0, count = 0.0;
  for (const double value : values) {
    if (std::isnan(value)) continue;
    sum += value - origin;
    ++count;
  }
  return origin + sum / count;
}

RunBias analyse(const ChannelRun& stretch, const Settings& settings) {
  RunBias run;
  run.label = stretch.label;
  try {
    EvenSignal signal =
        even_signal(stretch, settings.has("rate") ? settings.number("rate") : 0.0, settings.word("timing"));
    run.findings = signal.findings;
    for (Finding& one : take_zeros_out(signal, stretch.label)) run.findings.push_back(std::move(one));
    run.failure = unusable(signal);
    if (!run.failure.empty()) return run;
    const std::string unit = stretch.channel->kind == QuantityKind::angular_rate ? "deg/h" : "ug";
    for (const Findings& some :
         {disturbances(signal, stretch.label), lost_by_value(signal.values, stretch.label),
          uneven_bias(NoiseBands(signal.values), signal.begin, signal.rate, unit, stretch.label)})
      run.findings.insert(run.findings.end(), some.begin(), some.end());
    run.rate = signal.rate;
    run.samples = signal.values.size();
    run.mean = mean_of(signal.values);
    run.rounding = steps_move_mean(signal.values);
    run.blocks = blocks_of(signal.values, signal.rate);
    const auto size = static_cast<std::size_t>(std::max(1.0, std::round(shorter_time * signal.rate)));
    run.shorter = scatter_of_averages(signal.values, size);
    run.longer = scatter_of_averages(signal.values, size * ratio);
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_data) throw;
    run.failure = reason_of(error);
  }
  return run;
}

/// Variance of the means of the runs about the constants at power-on, on average over the runs and over what their
/// noise may be.
struct WithinRuns {
  double variance = 0.0;                          ///< [u^2]
  double freedom = 0.0;                           ///< of it (Satterthwaite: 2 v^2/Var v)
  double half_width = 0.0;                        ///< [u] 95 % interval of the mean of the first run
  double white = 0.0, flicker = 0.0, walk = 0.0;  ///< N^2 [u^2 s], B^2 [u^2], K^2 [u^2/s] on average
};

WithinRuns within_runs(const std::vector<RunBias>& runs) {
  std::vector<Blocks> blocks;
  double freedom = 0.0;
  for (const auto& run : runs) {
    blocks.push_back(run.blocks);
    freedom += static_cast<double>(run.blocks.means.size()) - 1.0;
  }
  const auto hypotheses = noise_hypotheses(blocks);
  WithinRuns out;
  double mean = 0.0, squares = 0.0;
  for (const auto& hypothesis : hypotheses) {
    double of_means = 0.0;
    for (const double variance : hypothesis.variances) of_means += variance / static_cast<double>(runs.size());
    mean += hypothesis.weight * of_means;
    squares += hypothesis.weight * of_means * of_means;
    out.white += hypothesis.weight * hypothesis.white;
    out.flicker += hypothesis.weight * hypothesis.flicker;
    out.walk += hypothesis.weight * hypothesis.walk;
  }
  const double spread = std::max(squares - mean * mean, 2.0 * mean * mean / freedom);
  out.variance = mean;
  out.freedom = std::max(1.0, 2.0 * mean * mean / spread);
  out.half_width = half_width(hypotheses, 0, freedom);
  return out;
}

struct Builder {
  Estimate estimate;
  Unit unit;

  void add(const std::string& name, const std::string& symbol, double value, double dof, double variance,
           const std::string& description) {
    estimate.parameters.push_back({name, symbol, unit, value, description, dof});
    variances.push_back(variance);
  }
  /// A standard deviation: its interval is not symmetric.
  void add_sd(const std::string& name, const std::string& symbol, double value, double dof, double variance,
              const SdInterval& interval, const std::string& description) {
    add(name, symbol, value, dof, variance, description);
    estimate.parameters.back().lower = interval.lower;
    estimate.parameters.back().upper = interval.upper;
  }
  std::vector<double> variances;
  double scatter_covariance = 0.0;  ///< between the two from `scatter_at` on
  std::size_t scatter_at = 0;
};

/// sd of the 10 s and 100 s averages about the mean of their run, over all runs.
void add_scatter(const std::vector<RunBias>& runs, const WithinRuns& noise, Builder& builder) {
  double sum[2]{}, weight[2]{}, variance[2]{}, covariance = 0.0;
  for (const auto& run : runs) {
    const auto size = static_cast<std::size_t>(std::max(1.0, std::round(shorter_time * run.rate)));
    const auto expected = expected_scatter(terms, {noise.white * run.rate, noise.flicker, noise.walk / run.rate},
                                           run.samples, size, ratio);
    const AverageScatter* scatter[2]{&run.shorter, &run.longer};
    const double each[2]{expected.shorter_variance, expected.longer_variance};
    double own[2]{};
    for (int k = 0; k < 2; ++k) {
      if (scatter[k]->averages < 2) continue;
      own[k] = static_cast<double>(scatter[k]->averages) - 1.0;
      weight[k] += own[k];
      sum[k] += own[k] * scatter[k]->variance;
      variance[k] += own[k] * own[k] * each[k];
    }
    covariance += own[0] * own[1] * expected.covariance;
  }
  const char* names[2]{"bias_sd_10s", "bias_sd_100s"};
  double gain[2]{};
  builder.scatter_at = builder.estimate.parameters.size();
  for (int k = 0; k < 2; ++k) {
    const double seconds = k == 0 ? shorter_time : shorter_time * static_cast<double>(ratio);
    if (weight[k] < 1.0 || !(sum[k] > 0.0)) {
      builder.estimate.findings.push_back(
          {Severity::warning, "too_short_for_averages", {{"parameter", names[k]}, {"length", seconds, "s"}}});
      continue;
    }
    const double squared = sum[k] / weight[k], sd = std::sqrt(squared);
    const double of_squared = variance[k] / (weight[k] * weight[k]);
    gain[k] = 0.5 / sd / weight[k];
    const double freedom = std::max(1.0, 2.0 * squared * squared / of_squared);
    builder.add_sd(names[k], k == 0 ? "s_10" : "s_100", sd, freedom, of_squared / (4.0 * squared),
                   interval_of_sd(sd, freedom),
                   fmt::format("standard deviation of averages over {} about their mean", say_seconds(seconds)));
  }
  builder.scatter_covariance = gain[0] * gain[1] * covariance;
}

/// Scatter of the bias between power-ups.
///
/// Given     between  variance of the run means [u^2]
///           within   the part of it that the noise within runs explains
void add_repeatability(const std::vector<RunBias>& runs, double between, const WithinRuns& within, Builder& builder) {
  const double dof = static_cast<double>(runs.size()) - 1.0;
  const double variance = between - within.variance;
  if (variance <= 0.0) {
    // The noise within the runs may be less than it seems: the scatter of the means limits what is beyond it.
    builder.estimate.findings.push_back(
        {Severity::info,
         "not_significant",
         {{"parameter", "turn_on_repeatability"},
          {"limit", interval_of_sd(std::sqrt(between), dof, 0.9).upper, builder.unit}}});
    builder.estimate.findings.back().hidden = {{"turn_on_repeatability"}};
    return;
  }
  const double of_between = 2.0 * between * between / dof,
               of_within = 2.0 * within.variance * within.variance / within.freedom;
  builder.add_sd("turn_on_repeatability", "s_b", std::sqrt(variance), dof, (of_between + of_within) / (4.0 * variance),
                 interval_of_excess_sd(between, dof, within.variance, within.freedom),
                 "standard deviation of the bias from power-up to power-up; the noise within runs is subtracted");
}

std::vector<RunBias> analyse_runs(const Evidence& evidence, const std::vector<ChannelRun>& stretches,
                                  Findings& findings) {
  for (const auto& stretch : stretches)
    if (stretch.channel->name != stretches.front().channel->name)
      throw Error(Error::Kind::bad_data,
                  say("several channels are possible, {} and {} among them: name one with channels.signal=...",
                      Name{stretches.front().channel->name}, Name{stretch.channel->name}));
  std::vector<RunBias> all(stretches.size()), usable;
  parallel_for(stretches.size(), [&](std::size_t i) {
    all[i] = analyse(stretches[i], evidence.plan.settings);
    all[i].file = evidence.recordings[stretches[i].recording].origin.file;
  });
  Problems failures;
  for (auto& run : all) {
    findings.insert(findings.end(), run.findings.begin(), run.findings.end());
    if (run.failure.empty()) {
      usable.push_back(std::move(run));
    } else {
      failures.push_back(within(say("{}", Name{run.label}), run.failure));
      findings.push_back({Severity::error, "run_not_used", {{"reason", run.failure}}, run.label});
    }
  }
  if (usable.empty()) throw Error(Error::Kind::bad_data, failures);
  return usable;
}

/// What differs from power-up to power-up otherwise than by chance.
Findings between_runs(const std::vector<RunBias>& runs, const WithinRuns& within, const Unit& unit) {
  std::vector<PowerUpValue> powers;
  Matrix constant(runs.size(), 1);
  for (std::size_t k = 0; k < runs.size(); ++k) {
    powers.push_back({runs[k].label, runs[k].mean, within.variance});
    constant(k, 0) = 1.0;
  }
  return uneven_power_ups(powers, constant, unit);
}

/// The bias with its variance: of a single run from its noise since power-on, of several from their scatter. Their
/// scatter is by chance less than the noise within each of them; the variance of the bias is not.
void add_bias(const std::vector<RunBias>& runs, const WithinRuns& within, double along, Builder& builder) {
  const auto count = static_cast<double>(runs.size());
  double mean = 0.0, between = 0.0;
  for (const auto& run : runs) mean += run.mean / count;
  for (const auto& run : runs) between += (run.mean - mean) * (run.mean - mean) / std::max(1.0, count - 1.0);
  if (runs.size() > 1) {
    builder.add("bias", "b", mean - along, count - 1.0, std::max(between, within.variance) / count,
                "mean of the power-ups");
    add_repeatability(runs, between, within, builder);
    std::vector<Blocks> blocks;
    for (const RunBias& run : runs) blocks.push_back(run.blocks);
    for (const Findings& some : {between_runs(runs, within, builder.unit), common_course(blocks, builder.unit)})
      builder.estimate.findings.insert(builder.estimate.findings.end(), some.begin(), some.end());
    return;
  }
  const double infinity = std::numeric_limits<double>::infinity();
  const double sd = within.half_width / student_quantile(two_sided_95, infinity);
  builder.add("bias", "b", mean - along, infinity, sd * sd, "constant output at power-on");
  builder.estimate.findings.push_back({Severity::info, "single_power_up", {}});
}

/// Degrees of freedom of each parameter, as a line of the budget states them.
std::vector<double> freedoms_of(const Estimate& estimate) {
  std::vector<double> out;
  for (const auto& parameter : estimate.parameters) out.push_back(parameter.degrees_of_freedom);
  return out;
}

/// Given: reference, which shifts the bias alone.
std::vector<ErrorLine> lines_of(const std::vector<RunBias>& runs, const Reference& reference, const Builder& builder) {
  const std::size_t n = builder.variances.size();
  Matrix noise(n, n);
  std::vector<double> repeat(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    const bool between = runs.size() > 1 && i < builder.scatter_at;
    (between ? repeat[i] : noise(i, i)) = builder.variances[i];
  }
  if (const std::size_t k = builder.scatter_at; k + 1 < n)
    noise(k, k + 1) = noise(k + 1, k) = builder.scatter_covariance;
  std::vector<ErrorLine> lines{from_covariance("output noise", noise),
                               from_variances("scatter between power-ups", repeat)};
  for (auto& line : lines) line.degrees_of_freedom = freedoms_of(builder.estimate);
  std::vector<double> shift(n, 0.0);
  // Power-ups at one level are off by the same part of a step.
  for (const RunBias& run : runs) shift.front() += run.rounding / static_cast<double>(runs.size());
  if (shift.front() > 0.0) lines.push_back(from_shifts("steps of the output", as_column(shift)));
  if (reference.source.empty()) return lines;
  shift.front() = reference.shift;
  lines.push_back(from_shifts(reference.source, as_column(shift), reference.key));
  return lines;
}

/// Averages of each power-up less their mean over the time since power-on: a drift or a step is seen here.
std::vector<Curve> averages_of(const std::vector<RunBias>& runs, const Unit& unit) {
  std::vector<Curve> curves;
  for (const auto& run : runs) {
    Curve curve{.name = run.label,
                .figure = "residuals of the averages",
                .x = {"time since power-on", Unit::parse("min")},
                .y = {fmt::format("average of {:.3g} s less the mean", run.blocks.length), unit}};
    double sum = 0.0, weight = 0.0;
    for (std::size_t i = 0; i < run.blocks.means.size(); ++i) {
      sum += run.blocks.shares[i] * run.blocks.means[i];
      weight += run.blocks.shares[i];
    }
    for (std::size_t i = 0; i < run.blocks.means.size(); ++i)
      if (run.blocks.shares[i] > 0.0)
        add_point(curve, (static_cast<double>(i) + 0.5) * run.blocks.length, run.blocks.means[i] - sum / weight);
    curves.push_back(std::move(curve));
  }
  return curves;
}

void finish(const std::vector<RunBias>& runs, const Reference& reference, Builder& builder) {
  Estimate& estimate = builder.estimate;
  settle(estimate, lines_of(runs, reference, builder));
  estimate.fit = {0, 0.0, std::numeric_limits<double>::quiet_NaN(), 1.0};
  for (const auto& run : runs) {
    estimate.fit.observations += run.blocks.means.size();
    estimate.fit.degrees_of_freedom += static_cast<double>(run.blocks.means.size()) - 1.0;
  }
  const auto duration = [](const RunBias& run) { return static_cast<double>(run.samples) / run.rate; };
  estimate.tables.push_back(tabulate("runs", "mean output of each power-up", runs,
                                     {{"run", &RunBias::label},
                                      {"duration", "s", duration},
                                      {"mean", builder.unit, &RunBias::mean},
                                      {"file", &RunBias::file}}));
  estimate.curves = averages_of(runs, builder.unit);
}

/// The bias of one attitude, or where the test changed it that of all; without its change from power-up to power-up
/// where there was one.
OutputModel model_of(const Estimate& estimate, QuantityKind kind, std::size_t runs, const Settings& settings) {
  const bool rate = kind == QuantityKind::angular_rate;
  const std::vector<Term> terms{{"bias", "b", "", "constant output", 1.0}};
  OutputModel model = output_model(estimate, "signal", rate ? Input::rate_x : Input::specific_force_x,
                                   rate ? "deg/h" : "ug", {terms, {1.0}, {1.0}});
  model.spread = parameter_index(estimate, "turn_on_repeatability");
  if (runs == 1) model.caveats.emplace_back("turn_on_change_not_included");
  if (!settings.has("axis") || settings.word("axis") == "none") model.caveats.emplace_back("bias_of_one_attitude");
  return model;
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  report(progress, 0.0, "bias");
  const auto stretches = channel_runs(evidence);
  Builder builder;
  const QuantityKind kind = stretches.front().channel->kind;
  builder.unit = Unit::parse(kind == QuantityKind::angular_rate ? "deg/h" : "ug");
  const auto runs = analyse_runs(evidence, stretches, builder.estimate.findings);
  const WithinRuns noise = within_runs(runs);
  const Reference subtracted = reference_of(evidence, kind, builder.estimate.findings);
  add_bias(runs, noise, subtracted.along, builder);
  add_scatter(runs, noise, builder);
  finish(runs, subtracted, builder);
  builder.estimate.models = {model_of(builder.estimate, kind, runs.size(), evidence.plan.settings)};
  report(progress, 1.0, "bias");
  return std::move(builder.estimate);
}

}  // namespace

extern const Method static_bias{
    .name = "static_bias",
    .summary = "bias at rest, its stability over 10 s and 100 s, and its repeatability from power-up to power-up",
    .source = "IEEE Std 528 terms; averages of 10 s and 100 s as usual for bias stability; noise by the Allan fit",
    .needs_plan = false,
    .roles = roles,
    .options = options,
    .identify = identify,
    .compensates = true,
    .takes_prior = true};

}  // namespace tumble::static_bias
