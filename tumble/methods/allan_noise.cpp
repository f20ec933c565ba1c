#include <fmt/format.h>

#include <cmath>

#include "tumble/math/noise_model.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/methods/allan_noise/describe.hpp"
#include "tumble/methods/allan_noise/even_signal.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/units/error.hpp"

namespace tumble::methods {
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
      {"confidence", Type::quantity, "1", "0.95", {}, "of the band about the deviation, two-sided"},
      {"points_per_decade",
       Type::quantity,
       "1",
       "10",
       {},
       "averaging times on the curve; the fit uses octaves of them"},
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
       "shortest averaging time the terms are fitted to: beyond filters in the instrument"},
      {"fit_to", Type::quantity, "s", "", {}, "longest averaging time the terms are fitted to"},
      {"significance",
       Type::quantity,
       "1",
       "0.01",
       {},
       "a term stays if chance gives it with less than this probability"},
  };
}

/// Points of the curve that are fitted.
std::vector<AllanObservation> observations(const std::vector<DeviationPoint>& curve, const Settings& settings) {
  std::vector<AllanObservation> within;
  for (const auto& point : curve)
    if (!(settings.has("fit_from") && point.tau < settings.number("fit_from")) &&
        !(settings.has("fit_to") && point.tau > settings.number("fit_to")))
      within.push_back({point.factor, point.deviation * point.deviation, point.count});
  return thinned(within);
}

/// A trend and the noise about it, where the trend stands out of that noise; else the noise of the record as it is.
/// The noise about a line looks smaller than it is until what the line took is put back: if the trend does not stand
/// out even so, it never will.
void fit(const EvenSignal& signal, const AllanOptions& curve, const Settings& settings, ChannelNoise& result) {
  AllanFitOptions how;
  how.significance = settings.number("significance");
  result.used = observations(result.curve, settings);
  result.fit = fit_allan_and_markov(result.used, result.samples, how);
  constexpr double chance = 0.0027;  // 3 sigma
  AllanFit about = result.fit;
  std::vector<AllanObservation> used;
  result.ramp = estimate_ramp(signal.values, signal.rate, about);
  for (int round = 0; round < 3; ++round) {
    const auto level = levelled(signal.values, signal.rate, result.ramp.slope);
    used = observations(overlapping_allan(level, signal.rate, curve), settings);
    if (round > 0) used = without_ramp(used, signal.rate, result.ramp);
    about = fit_allan_and_markov(used, result.samples, how);
    result.ramp = estimate_ramp(signal.values, signal.rate, about);
    if (result.ramp.chance > chance) return;
  }
  result.ramp.kept = true;
  result.used = used;
  result.fit = about;
}

/// Deviation curve and fit of one stretch. What stands in its way is said in `failure`.
ChannelNoise analyse(const Stretch& stretch, const Settings& settings) {
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
    const Findings disturbed = disturbances(signal, stretch.label);
    result.findings.insert(result.findings.end(), disturbed.begin(), disturbed.end());
    const AllanOptions curve{settings.number("points_per_decade"), result.confidence,
                             settings.number("longest_fraction")};
    result.curve = overlapping_allan(signal.values, signal.rate, curve);
    fit(signal, curve, settings, result);
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
  if (settings.number("points_per_decade") != 0.0) within("points_per_decade", 0.99, 1000.0);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  const Settings& settings = evidence.plan.settings;
  check(settings);
  const auto found = stretches(evidence);
  std::vector<ChannelNoise> results(found.size());
  report(progress, 0.0, "Allan deviation");
  parallel_for(found.size(), [&](std::size_t i) { results[i] = analyse(found[i], settings); });
  report(progress, 1.0, "Allan deviation");
  std::vector<std::string> failures;
  for (const auto& result : results)
    if (!result.failure.empty()) failures.push_back(result.label + ": " + result.failure);
  if (failures.size() == results.size()) throw Error(Error::Kind::bad_data, failures);
  Estimate estimate = describe_noise(results);
  estimate.method = "allan_noise";
  estimate.title = evidence.plan.title;
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
    .summary = "noise terms of angular rate or specific force from the overlapping Allan deviation",
    .source = "IEEE Std 528 terms; NIST SP 1065 (2008), eq. (11); Greenhall and Riley, PTTI 2003",
    .needs_plan = false,
    .roles = roles,
    .options = options,
    .identify = identify,
    .trial = trial,
    .compensate = nullptr,
    .predict = nullptr};

}  // namespace tumble::methods
