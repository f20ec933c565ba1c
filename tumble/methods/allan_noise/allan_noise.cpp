#include <fmt/format.h>

#include <cmath>

#include "tumble/math/noise_model.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/methods/allan_noise/all_taus.hpp"
#include "tumble/methods/allan_noise/describe.hpp"
#include "tumble/methods/allan_noise/disturbed.hpp"
#include "tumble/methods/allan_noise/family.hpp"
#include "tumble/methods/allan_noise/faults.hpp"
#include "tumble/methods/allan_noise/fit.hpp"
#include "tumble/methods/allan_noise/input.hpp"
#include "tumble/methods/allan_noise/lines.hpp"
#include "tumble/methods/allan_noise/outliers.hpp"
#include "tumble/methods/allan_noise/periodic.hpp"
#include "tumble/methods/allan_noise/rounding.hpp"
#include "tumble/methods/allan_noise/settling.hpp"
#include "tumble/methods/allan_noise/slow_courses.hpp"
#include "tumble/methods/allan_noise/spectrum.hpp"
#include "tumble/methods/allan_noise/stream.hpp"
#include "tumble/methods/allan_noise/temperature.hpp"
#include "tumble/methods/allan_noise/together.hpp"
#include "tumble/methods/allan_noise/windows.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/reduce/even_signal.hpp"
#include "tumble/reduce/held_samples.hpp"
#include "tumble/reduce/lost_by_value.hpp"
#include "tumble/reduce/zeros.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::allan_noise {
namespace {

std::vector<Role> roles() {
  return {{"signal", "", false,
           "the one channel to analyse, angular rate or specific force; without it all such channels are"}};
}

std::vector<Option> data_options() {
  return {
      word("data", {"rate", "angle", "phase", "frequency", "increment", "count"})
          .otherwise("rate")
          .says("what the samples are: an angular rate or a specific force; its integral, an angle or a velocity; "
                "the time error of a clock, or its fractional frequency; the angle or velocity since the sample "
                "before; pulses since then"),
      text("pulse").says("with data = count: angle or velocity of one pulse, as in 0.5 arcsec"),
      quantity("rate", "Hz")
          .above(0)
          .at_most(1e9)
          .bare()
          .says("sampling rate, where the file does not state it or is wrong"),
      quantity("from", "s")
          .at_least(0)
          .says("time from the begin of the record that is not used, as in 30 min, while the instrument becomes warm"),
      word("timing", {"auto", "even", "stamps"})
          .otherwise("auto")
          .says("even: evenly spaced at the mean rate; stamps: averaged onto an even grid; auto: even where only "
                "the stamps are late")};
}

std::vector<Option> curve_options() {
  return {
      word("estimator", {"likelihood", "allan"})
          .otherwise("likelihood")
          .says("likelihood: maximum likelihood of the record itself; allan: least squares on the Allan variances"),
      quantity("confidence")
          .above(0)
          .at_most(0.9999)
          .otherwise("0.95")
          .says("two-sided confidence of the band about the deviation"),
      quantity("points_per_decade")
          .between(0, 1000)
          .otherwise("10")
          .says("averaging times on the curve, 1 or more in a decade; 0: octaves; estimator allan fits octaves of "
                "them"),
      text("taus").otherwise("log").says(
          "averaging times: log: points_per_decade of them; octave: 1, 2, 4, 8 ... sampling intervals; decade: 1, 2, "
          "4, 10, 20, 40 ...; a list, as in \"1 s, 10 s, 2 min\"; all: as log, and in addition every multiple of "
          "the sampling interval (of ohdev too)"),
      word("total_bias", {"remove", "keep"})
          .otherwise("remove")
          .says("expected departure of the total deviations from the deviations whose names they bear"),
      word("mean_rate", {"subtract", "keep"}).otherwise("subtract").says("mean rate of the record in mtie and tierms"),
      text("deviations").says("other measures of stability, with limits: any of " + family_names()),
      quantity("longest_fraction")
          .above(0)
          .at_most(0.5)
          .otherwise("0.25")
          .says("longest averaging time over the length of the record")};
}

std::vector<Option> fit_options() {
  return {
      quantity("fit_from", "s")
          .at_least(0)
          .says("shortest averaging time of the fit, frequencies up to 1/(2 tau): longer than filters in the "
                "instrument; absent: the sampling interval"),
      quantity("fit_to", "s").at_least(0).says("longest averaging time of the fit; absent: the longest on the curve"),
      quantity("significance")
          .above(0)
          .at_most(1)
          .otherwise("0.01")
          .says("keep a noise term if its p-value is below this"),
      word("disturbed", {"cut", "keep"})
          .otherwise("cut")
          .says("parts that scatter more than 4 times as much as usual, up to a tenth of the record: cut: treat as "
                "missing; keep: treat as noise"),
      word("lines", {"fit", "avoid"})
          .otherwise("fit")
          .says("sines in the record: fit: amplitude and frequency of each, with the noise; avoid: do not use the "
                "frequencies that they reach"),
      quantity("wanted_sd", "%")
          .above(0)
          .at_most(100)
          .otherwise("5 %")
          .says("relative uncertainty for which table advice gives the length of the record")};
}

std::vector<Option> further_options() {
  return {word("spectrum", {"none", "welch", "multitaper"})
              .otherwise("none")
              .says("power spectral density: by overlapping Hann windows, or by Slepian tapers"),
          integer("windows").between(0, 1000).otherwise("0").says(
              "number of windows along the record, 3 or more, whose deviations are compared; 0: none"),
          flag("correlation")
              .otherwise("false")
              .says("correlation of channels that are sampled together, over the averaging time"),
          flag("hat").otherwise("false").says(
              "three or more channels of one kind measure the same input: the noise of each by itself "
              "(three-cornered hat)")};
}

std::vector<Option> options() {
  std::vector<Option> all = data_options();
  for (const auto& some : {curve_options(), fit_options(), further_options()})
    all.insert(all.end(), some.begin(), some.end());
  return all;
}

/// Where gaps leave no run that is long enough for half of the averaging times asked for (on a logarithmic scale).
void warn_where_curve_ends(const Settings& settings, ChannelNoise& result) {
  const double wanted = settings.number("longest_fraction") * static_cast<double>(result.samples);
  if (result.curve.empty() || std::pow(static_cast<double>(result.curve.back().factor), 2) > wanted) return;
  result.findings.push_back(
      {Finding::Severity::info, "deviation_ends_at_gaps", {{"tau", result.curve.back().tau, "s"}}, result.label});
}

/// The fit is of the logarithmic points, whatever `taus` asks for.
void fit_allan(const EvenSignal& signal, const Settings& settings, ChannelNoise& result) {
  AllanOptions options = curve_options_of(settings, signal);
  if (options.factors.empty()) {
    result.fit = fit_allan_curve(signal, result.curve, options, settings);
    return;
  }
  options.factors.clear();
  result.fit = fit_allan_curve(signal, overlapping_allan(signal.values, signal.rate, options), options, settings);
}

/// The terms of a record by the estimator that is asked for.
void fit_terms(const EvenSignal& signal, const Settings& settings, ChannelNoise& result) {
  if (result.likelihood && settings.word("lines") == "fit")
    fit_likelihood_and_lines(signal, settings, result);
  else if (result.likelihood)
    fit_likelihood(
        NoiseBands(signal.values), [&] { return spectral_lines(signal.values); }, signal.begin, settings, result);
  else
    fit_allan(signal, settings, result);
}

/// The temperature of the samples of a signal; empty: no thermometer beside it, or of another length.
std::vector<double> warmth_beside(const ChannelRun& stretch, const Channel* thermometer, const Settings& settings,
                                  const EvenSignal& signal) {
  if (thermometer == nullptr) return {};
  ChannelRun beside = stretch;
  beside.channel = thermometer;
  const EvenSignal warmth = from_start(
      even_signal(beside, settings.has("rate") ? settings.number("rate") : 0.0, settings.word("timing")), settings);
  if (warmth.values.size() < signal.values.size()) return {};
  const auto same = warmth.values.first(signal.values.size());
  return {same.begin(), same.end()};
}

/// Where the record follows the temperature beside it: the record without that, and the terms of this. before: the
/// result as it was before its terms were fitted.
std::optional<EvenSignal> without_temperature(const std::vector<double>& warmth, const Settings& settings,
                                              const ChannelNoise& before, const EvenSignal& signal,
                                              ChannelNoise& result) {
  const auto found = temperature_course(signal.values, warmth, result);
  if (!found) return {};
  result.temperature = found->effect;
  if (found->effect.chance > course_chance) return {};
  EvenSignal level = signal;
  level.made.assign(signal.values.begin(), signal.values.end());
  for (std::size_t i = 0; i < level.made.size(); ++i) level.made[i] -= found->of_bias[i];
  level.values = level.made;
  ChannelNoise rest = before;
  fit_terms(level, settings, rest);
  rest.temperature = result.temperature;
  rest.thermometer = result.thermometer;
  rest.findings.push_back(follows_temperature(rest));
  add_course_variance(found->of_bias, 1.0, rest);
  result = std::move(rest);
  std::optional<EvenSignal> without(std::move(level));
  without->values = without->made;
  return without;
}

/// Deviation curve and fit of one stretch; `failure` says why there is none.
ChannelNoise analyse(const ChannelRun& stretch, const Channel* thermometer, const Settings& settings) {
  ChannelNoise result;
  result.label = stretch.label;
  result.kind = kind_of_rate(*stretch.channel, settings);
  result.confidence = settings.number("confidence");
  try {
    EvenSignal signal = rate_signal(stretch, settings);
    result.findings = signal.findings;
    if (settings.word("data") == "rate")
      for (const auto take_out : {take_zeros_out, take_repeats_out})
        for (Finding& one : take_out(signal, result.label)) result.findings.push_back(std::move(one));
    result.rate = signal.rate;
    result.samples = signal.values.size();
    result.failure = unusable(signal);
    if (!result.failure.empty()) return result;
    result.begin = signal.begin;
    find_outliers(settings, signal, result);
    for (const Findings& some :
         {coarse_output(signal.values, result.label), lost_by_value(signal.values, result.label)})
      result.findings.insert(result.findings.end(), some.begin(), some.end());
    set_disturbed_aside(settings, signal, result);
    settle_outliers(result);
    const AllanOptions curve = curve_options_of(settings, signal);
    result.curve = overlapping_allan(signal.values, signal.rate, curve);
    warn_where_curve_ends(settings, result);
    result.likelihood = settings.word("estimator") == "likelihood";
    if (thermometer != nullptr) result.thermometer = thermometer->name;
    const ChannelNoise before = result;
    fit_terms(signal, settings, result);
    const auto level =
        without_temperature(warmth_beside(stretch, thermometer, settings, signal), settings, before, signal, result);
    if (settings.word("data") == "rate") take_rounding_out(signal.values, result);
    if (result.likelihood && !result.outliers.empty()) add_robust_terms(level ? *level : signal, settings, result);
    add_family(signal, settings, result);
    add_all_taus(signal, settings, result);
    add_spectrum(signal, settings, result);
    add_windows(signal, settings, result);
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_data) throw;
    result.failure = reason_of(error);
  }
  return result;
}

/// The channels that could be analysed; an error where none could.
Estimate described(const std::vector<ChannelNoise>& results, const Plan& plan) {
  Problems failures;
  for (const auto& result : results)
    if (!result.failure.empty()) failures.push_back(within(say("{}", Name{result.label}), result.failure));
  if (failures.size() == results.size()) throw Error(Error::Kind::bad_data, failures);
  Estimate estimate = describe_noise(results, plan.settings.number("wanted_sd"));
  return estimate;
}

Estimate stream(const StreamedEvidence& evidence, const Progress&) {
  check_settings(evidence.plan.settings);
  return described_stream(noise_of_stream(evidence), evidence.plan);
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  const Settings& settings = evidence.plan.settings;
  check_settings(settings);
  const auto runs = channel_runs(evidence, channels_of_data(settings));
  std::vector<ChannelNoise> results(runs.size());
  report(progress, 0.0, "Allan deviation");
  parallel_for(runs.size(), [&](std::size_t i) {
    const Recording& recording = evidence.recordings[runs[i].recording];
    results[i] = analyse(runs[i], temperature_of(recording, *runs[i].channel), settings);
  });
  report(progress, 1.0, "Allan deviation");
  Estimate estimate = described(results, evidence.plan);
  describe_lines(results, estimate);
  describe_set_aside(results, estimate);
  describe_outliers(results, estimate);
  describe_family(results, estimate);
  describe_all_taus(results, estimate);
  describe_spectra(results, estimate);
  describe_windows(results, estimate);
  describe_together(runs, results, settings, estimate);
  describe_warm_up(results, estimate);
  describe_temperature(results, estimate);
  return estimate;
}

}  // namespace

void check_settings(const Settings& settings) {
  Problems problems;
  if (const double points = settings.number("points_per_decade"); points > 0.0 && points < 1.0)
    problems.push_back(say("points_per_decade = {:g} must be 0, or 1 to 1000", points));
  if (const int windows = settings.integer("windows"); windows == 1 || windows == 2)
    problems.push_back(say("windows = {} must be 0, or 3 to 1000", windows));
  for (auto& problem : input_problems(settings)) problems.push_back(std::move(problem));
  if (settings.has("deviations"))
    for (auto& problem : family_problems(settings.word("deviations"))) problems.push_back(std::move(problem));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

Estimate described_stream(const std::vector<ChannelNoise>& results, const Plan& plan) {
  Estimate estimate = described(results, plan);
  describe_outliers(results, estimate);
  describe_warm_up(results, estimate);
  return estimate;
}

extern const Method allan_noise{
    .name = "allan_noise",
    .summary = "noise terms of angular rate or specific force by maximum likelihood, beside the Allan deviation",
    .source = "IEEE Std 528 terms; NIST SP 1065 (2008), eq. (11); Greenhall and Riley, PTTI 2003",
    .needs_plan = false,
    .roles = roles,
    .options = options,
    .identify = identify,
    .stream = stream};

}  // namespace tumble::allan_noise
