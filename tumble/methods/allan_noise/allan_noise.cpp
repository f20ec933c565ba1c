#include <fmt/format.h>

#include <cmath>

#include "tumble/math/noise_model.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/methods/allan_noise/all_taus.hpp"
#include "tumble/methods/allan_noise/describe.hpp"
#include "tumble/methods/allan_noise/disturbed.hpp"
#include "tumble/methods/allan_noise/family.hpp"
#include "tumble/methods/allan_noise/fit.hpp"
#include "tumble/methods/allan_noise/lines.hpp"
#include "tumble/methods/allan_noise/periodic.hpp"
#include "tumble/methods/allan_noise/spectrum.hpp"
#include "tumble/methods/allan_noise/stream.hpp"
#include "tumble/methods/allan_noise/temperature.hpp"
#include "tumble/methods/allan_noise/together.hpp"
#include "tumble/methods/allan_noise/windows.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/reduce/even_signal.hpp"
#include "tumble/units/error.hpp"

namespace tumble::allan_noise {
namespace {

std::vector<Role> roles() {
  return {{"signal", "", false,
           "the one channel to analyse, angular rate or specific force; without it all such channels are"}};
}

std::vector<Option> options() {
  using Type = Option::Type;
  return {
      {"rate", Type::quantity, "Hz", "", {}, "sampling rate, where the file does not say or is wrong", true},
      {"timing",
       Type::word,
       "1",
       "auto",
       {"auto", "even", "stamps"},
       "even: evenly spaced at the mean rate; stamps: averaged onto an even grid; auto: even where only the stamps are "
       "late"},
      {"estimator",
       Type::word,
       "1",
       "likelihood",
       {"likelihood", "allan"},
       "likelihood: maximum likelihood of the record itself; allan: least squares on the Allan variances"},
      {"confidence", Type::quantity, "1", "0.95", {}, "of the band about the deviation, two-sided"},
      {"points_per_decade",
       Type::quantity,
       "1",
       "10",
       {},
       "averaging times on the curve; estimator allan fits octaves of them"},
      {"taus",
       Type::word,
       "1",
       "log",
       {"log", "all"},
       "averaging times: log, points_per_decade of them; all: beside these every multiple of the sampling interval (of "
       "ohdev too)"},
      {"deviations",
       Type::text,
       "1",
       "",
       {},
       "other measures of stability beside it, with limits: any of " + family_names()},
      {"longest_fraction",
       Type::quantity,
       "1",
       "0.25",
       {},
       "longest averaging time over the record's length, up to 0.5"},
      {"fit_from",
       Type::quantity,
       "s",
       "",
       {},
       "shortest averaging time the terms are fitted to, frequencies up to 1/(2 tau): beyond filters in the "
       "instrument"},
      {"fit_to", Type::quantity, "s", "", {}, "longest averaging time the terms are fitted to"},
      {"significance",
       Type::quantity,
       "1",
       "0.01",
       {},
       "a term stays if chance gives it with less than this probability"},
      {"disturbed",
       Type::word,
       "1",
       "cut",
       {"cut", "keep"},
       "parts that scatter more than 4 times as usual, up to a tenth of the record: cut: taken as missing; keep: as "
       "noise"},
      {"lines",
       Type::word,
       "1",
       "fit",
       {"fit", "avoid"},
       "sines in the record: fit: amplitude and frequency of each beside the noise; avoid: frequencies they reach are "
       "left out"},
      {"wanted_sd",
       Type::quantity,
       "%",
       "5 %",
       {},
       "relative uncertainty that table advice gives the length of record for"},
      {"spectrum",
       Type::word,
       "1",
       "none",
       {"none", "welch", "multitaper"},
       "power spectral density beside the deviation: by Hann windows that overlap, or by Slepian tapers"},
      {"windows",
       Type::integer,
       "1",
       "0",
       {},
       "the deviation in so many windows along the record, and whether they differ; 0: none"},
      {"correlation",
       Type::flag,
       "1",
       "false",
       {},
       "how channels that were sampled together fluctuate together, over the averaging time"},
      {"hat",
       Type::flag,
       "1",
       "false",
       {},
       "three or more channels of one kind measure the same input: the noise of each by itself (three-cornered hat)"},
  };
}

/// Deviation curve and fit of one stretch. What stands in its way is said in `failure`.
ChannelNoise analyse(const ChannelRun& stretch, const Settings& settings) {
  ChannelNoise result;
  result.label = stretch.label;
  result.kind = stretch.channel->kind;
  result.confidence = settings.number("confidence");
  try {
    EvenSignal signal =
        even_signal(stretch, settings.has("rate") ? settings.number("rate") : 0.0, settings.word("timing"));
    result.findings = signal.findings;
    result.rate = signal.rate;
    result.samples = signal.values.size();
    result.failure = unusable(signal);
    if (!result.failure.empty()) return result;
    result.begin = signal.begin;
    set_disturbed_aside(settings, signal, result);
    const AllanOptions curve{settings.number("points_per_decade"), result.confidence,
                             settings.number("longest_fraction")};
    result.curve = overlapping_allan(signal.values, signal.rate, curve);
    result.likelihood = settings.word("estimator") == "likelihood";
    if (result.likelihood && settings.word("lines") == "fit")
      fit_likelihood_and_lines(signal, settings, result);
    else if (result.likelihood)
      fit_likelihood(
          NoiseBands(signal.values), [&] { return spectral_lines(signal.values); }, signal.begin, settings, result);
    else
      result.fit = fit_allan_curve(signal, result.curve, curve, settings);
    add_family(signal, settings, result);
    add_all_taus(signal, settings, result);
    add_spectrum(signal, settings, result);
    add_windows(signal, settings, result);
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_data) throw;
    result.failure = error.what();
  }
  return result;
}

void check(const Settings& settings) {
  std::vector<std::string> problems;
  const auto within = [&](const char* name, double low, double high) {
    if (settings.has(name) && !(settings.number(name) > low && settings.number(name) <= high))
      problems.push_back(
          fmt::format("{} = {:g} must be above {:g} and at most {:g}", name, settings.number(name), low, high));
  };
  within("rate", 0.0, 1e9);
  within("confidence", 0.0, 0.9999);
  within("longest_fraction", 0.0, 0.5);
  within("significance", 0.0, 1.0);
  within("wanted_sd", 0.0, 1.0);
  if (settings.number("points_per_decade") != 0.0) within("points_per_decade", 0.99, 1000.0);
  if (const int windows = settings.integer("windows"); windows != 0 && (windows < 3 || windows > 1000))
    problems.push_back(fmt::format("windows = {} must be 0, or 3 to 1000", windows));
  if (settings.has("deviations"))
    for (auto& problem : family_problems(settings.word("deviations"))) problems.push_back(std::move(problem));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

/// The channels that could be analysed; an error where none could.
Estimate described(const std::vector<ChannelNoise>& results, const Plan& plan) {
  std::vector<std::string> failures;
  for (const auto& result : results)
    if (!result.failure.empty()) failures.push_back(result.label + ": " + result.failure);
  if (failures.size() == results.size()) throw Error(Error::Kind::bad_data, failures);
  Estimate estimate = describe_noise(results, plan.settings.number("wanted_sd"));
  estimate.method = "allan_noise";
  estimate.title = plan.title;
  return estimate;
}

Estimate stream(const StreamedEvidence& evidence, const Progress&) {
  check(evidence.plan.settings);
  return described(noise_of_stream(evidence), evidence.plan);
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  const Settings& settings = evidence.plan.settings;
  check(settings);
  const auto found = channel_runs(evidence);
  std::vector<ChannelNoise> results(found.size());
  report(progress, 0.0, "Allan deviation");
  parallel_for(found.size(), [&](std::size_t i) { results[i] = analyse(found[i], settings); });
  report(progress, 1.0, "Allan deviation");
  Estimate estimate = described(results, evidence.plan);
  describe_lines(results, estimate);
  describe_set_aside(results, estimate);
  describe_family(results, estimate);
  describe_all_taus(results, estimate);
  describe_spectra(results, estimate);
  describe_windows(results, estimate);
  describe_together(found, results, settings, estimate);
  describe_temperature(evidence, found, results, estimate);
  return estimate;
}

/// A gyro whose record shows angle random walk, bias instability and rate random walk clearly.
Trial trial(std::uint64_t seed) {
  const double rate = 10.0;
  const NoiseModel truth{.angle_random_walk = si(0.1, "deg/sqrt(h)"),
                         .bias_instability = si(4.75, "deg/h"),
                         .rate_random_walk = si(72.0, "deg/h/sqrt(h)")};
  Channel gyro{"gyro.x", QuantityKind::angular_rate, Unit::parse("deg/h"), {0.0, rate, nullptr}, {}};
  gyro.values.assign(40000, si(3.0, "deg/h"));
  add_noise(truth, rate, RandomStream(seed).split("allan_noise"), gyro.values);
  Trial trial;
  trial.evidence.plan.method = "allan_noise";
  trial.evidence.plan.settings = defaults(options());
  Recording recording;
  recording.channels.push_back(std::move(gyro));
  trial.evidence.recordings.push_back(std::move(recording));
  trial.truth = {{"gyro.x.angle_random_walk", truth.angle_random_walk},
                 {"gyro.x.bias_instability", truth.bias_instability},
                 {"gyro.x.rate_random_walk", truth.rate_random_walk}};
  return trial;
}

}  // namespace

extern const Method allan_noise{
    .name = "allan_noise",
    .summary = "noise terms of angular rate or specific force by maximum likelihood, beside the Allan deviation",
    .source = "IEEE Std 528 terms; NIST SP 1065 (2008), eq. (11); Greenhall and Riley, PTTI 2003",
    .needs_plan = false,
    .roles = roles,
    .options = options,
    .identify = identify,
    .trial = trial,
    .compensate = nullptr,
    .predict = nullptr,
    .stream = stream};

}  // namespace tumble::allan_noise
