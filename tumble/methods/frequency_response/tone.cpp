#include <algorithm>
#include <cmath>

#include "tumble/math/regression/sine_fit.hpp"
#include "tumble/methods/frequency_response/clipping.hpp"
#include "tumble/methods/frequency_response/extent.hpp"
#include "tumble/methods/frequency_response/point.hpp"
#include "tumble/reduce/vibration/vibration.hpp"
#include "tumble/reduce/vibration/windows.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::frequency_response {
namespace {

using Severity = Finding::Severity;
using vibration::sinc;

/// Settling where none is stated: a tenth of the tone or two cycles, at most half of the tone.
constexpr double settling_share = 0.1, settling_cycles = 2.0, most_settling = 0.5;
/// Samples, more than the coefficients of a fit.
constexpr std::size_t fewest_after_settling = 12, fewest_of_tone = 16;
constexpr double highest_harmonic = 0.48;  ///< [1] of the sampling rate: below the half, where sine and cosine are one
/// [1] of the planned frequency, and [1/span], by which the frequency differs from the plan.
constexpr double other_frequency = 0.02, other_frequency_bins = 2.0;
constexpr double least_third = 0.005;  ///< [1] of the fundamental: of a tone that is cut by 2.6 %
/// [1] of the time that a crest takes in a coarse output: half more, where the output ends a step below it.
constexpr double crest_share = 1.5;
/// [1] by which a difference may be off a whole multiple of the step, and of the differences that are such multiples.
constexpr double whole_step = 1e-6, share_of_steps = 0.99;
/// [1] sum of the squares of all J_1(2 pi k A/q)/k over that of the first: zeta(3).
constexpr double lines_of_staircase = 1.202;
/// [1] of the fundamental, from which on a third harmonic of the output's own tells of a gain that depends on the amplitude, by
/// three times as much; and its sd.
constexpr double distorted = 0.01, distorted_sd = 5.0;
constexpr double reference_residual = 0.35;  ///< [1] of the amplitude: two equal tones leave 0.7
constexpr double reference_noise = 0.01;     ///< variance of the logarithm of its amplitude: sd 10 %
constexpr double most_cycles_sd = 0.02;      ///< [cycles] over the tone, 0.06 rad at the ends
/// Variance of the logarithm of the output's amplitude, above which its own frequency is not looked for: sd 5 %.
constexpr double noise_for_frequency = 0.0025;
/// [cycles] over the tone, and [sd] that clocks differ by.
constexpr double least_cycles_apart = 0.02, frequency_apart_sd = 5.0;
/// [1] of the amplitude by flat tops; and its sd, below which noise hides it.
constexpr double least_loss = 1e-3, loss_sd = 3.0;

/// Samples of both channels over the time that they share.
struct Pair {
  Samples output, reference;
};

void cut(Samples& s, double begin, double end) {
  Samples inner;
  inner.rate = s.rate;
  for (std::size_t i = 0; i < s.time.size(); ++i) {
    if (s.time[i] < begin || s.time[i] > end) continue;
    inner.time.push_back(s.time[i]);
    inner.value.push_back(s.value[i]);
    inner.missing += std::isnan(s.value[i]) ? 1 : 0;
  }
  s = std::move(inner);
}

Pair pair_of(const Part& part, double begin, double end, const Scaling& scaling) {
  return {samples_of(part.output, begin, end, scaling.output_shift),
          samples_of(part.reference, begin, end, scaling.reference_shift)};
}

/// The step of a converter [SI]: the least difference of neighbouring samples, of which nearly all others are whole multiples; 0: they
/// are not.
double step_of(const Samples& s) {
  double least = INFINITY, steps = 0.0, whole = 0.0, several = 0.0;
  const auto each = [&](const auto& use) {
    for (std::size_t i = 1; i < s.value.size(); ++i)
      if (const double step = std::abs(s.value[i] - s.value[i - 1]); step > 0.0) use(step);
  };
  each([&](double step) { least = std::min(least, step); });
  each([&](double step) {
    const double multiple = std::round(step / least);
    ++steps;
    whole += std::abs(step / least - multiple) < whole_step * multiple ? 1.0 : 0.0;
    several += multiple > 1.5 ? 1.0 : 0.0;
  });
  return whole > share_of_steps * steps && several > 0.0 ? least : 0.0;
}

/// Variance of ln amplitude by the steps q of a converter: the lines of the staircase, J_1(2 pi k A/q), add (2/pi^2) (q/A)^1.5 of A
/// with an unknown phase, less what noise of a sample hides of them. A step as large as the amplitude can give any amplitude.
double rounding_variance(const Samples& s, const SineFit& fit) {
  const double step = step_of(s), steps = std::min(1.0, step / std::abs(fit.line[0]));
  const double noise = step > 0.0 ? std::sqrt(fit.noise_variance) / step : 1.0;
  const double shift = 2.0 / (pi * pi) * std::pow(steps, 1.5) * std::exp(-2.0 * pi * pi * noise * noise);
  return 0.5 * lines_of_staircase * shift * shift;
}

/// Cuts both channels to the time that they share, without settling. A finding where too little remains.
std::optional<Finding> settle(Pair& pair, double frequency, const Settings& settings, const std::string& where) {
  const double begin = std::max(pair.output.time.front(), pair.reference.time.front());
  const double end = std::min(pair.output.time.back(), pair.reference.time.back());
  if (!(end > begin)) return Finding{Severity::error, "no_time_in_common", {}, where};
  const double wait = settings.has("settling")
                          ? settings.number("settling")
                          : std::min(most_settling * (end - begin),
                                     std::max(settling_share * (end - begin), settling_cycles / frequency));
  for (Samples* s : {&pair.output, &pair.reference}) cut(*s, begin + wait, end);
  if (pair.output.time.size() >= fewest_after_settling && pair.reference.time.size() >= fewest_after_settling)
    return {};
  return Finding{
      Severity::error,
      "too_short_after_settling",
      {{"remaining", std::max(0.0, end - begin - wait), "s"}, {"length", end - begin, "s"}, {"settling", wait, "s"}},
      where};
}

/// Harmonics that are distinct from the fundamental: those below half of the sampling rate.
int harmonics_of(double frequency, double rate) {
  return 3.0 * frequency < highest_harmonic * rate ? 3 : 2.0 * frequency < highest_harmonic * rate ? 2 : 1;
}

/// Where the search for the reference's frequency begins: its own strongest line, unfolded to the plan's frequency.
double start_frequency(const Part& part, const Samples& reference, Findings& findings) {
  const double strongest = strongest_frequency(reference.value, reference.rate);
  if (!part.motion || part.motion->kind != Motion::Kind::sine) return strongest;
  const double planned = part.motion->frequency, span = reference.time.back() - reference.time.front();
  double best = strongest;
  if (planned > 0.5 * reference.rate) {
    const double k = std::round(planned / reference.rate) * reference.rate;
    best = planned < k ? k - strongest : k + strongest;
    findings.push_back({Severity::warning,
                        "reference_aliased",
                        {{"rate", reference.rate, "Hz"}, {"planned", planned, "Hz"}},
                        part.label});
  }
  if (std::abs(best - planned) > std::max(other_frequency * planned, other_frequency_bins / span))
    findings.push_back({Severity::warning,
                        "frequency_differs_from_plan",
                        {{"planned", planned, "Hz"}, {"measured", best, "Hz"}, {"rate", reference.rate, "Hz"}},
                        part.label});
  return best;
}

/// The third harmonic of the output over its tone, less what the reference has of it [1]; 0: none is distinguished.
double own_third(const SineFit& output, const SineFit& reference) {
  if (output.line.size() < 3) return 0.0;
  const double shown = std::abs(output.line[2] / output.line[0]);
  return shown - (reference.line.size() < 3 ? 0.0 : std::abs(reference.line[2] / reference.line[0]));
}

/// Flat tops: one extreme in three samples in succession, again and again, for longer than the crest of the tone stays in the
/// last step of a coarse output, and a third harmonic to match.
bool clipped(const Samples& s, const SineFit& fit, const SineFit& reference) {
  if (own_third(fit, reference) < least_third) return false;
  double low = INFINITY, high = -INFINITY;
  for (const double v : s.value)
    if (!std::isnan(v)) low = std::min(low, v), high = std::max(high, v);
  std::size_t flat = 0, three = 0, run = 1;
  for (std::size_t i = 1; i < s.value.size(); ++i) {
    run = s.value[i] == s.value[i - 1] && (s.value[i] == high || s.value[i] == low) ? run + 1 : 1;
    flat += run == 3 ? 3 : run > 3 ? 1 : 0;
    three += run == 3 ? 1 : 0;
  }
  const double crest = std::acos(std::max(-1.0, 1.0 - step_of(s) / std::abs(fit.line[0]))) / pi;
  return three >= 3 && static_cast<double>(flat) > crest_share * crest * static_cast<double>(s.value.size());
}

/// Flat tops beneath the noise: the values by the phase of the fitted tone.
FlatTops flat_tops_of(const Samples& s, const SineFit& fit) {
  std::vector<double> phase, values;
  for (std::size_t i = 0; i < s.time.size(); ++i) {
    const double t = s.time[i] - fit.centre, u = 2.0 * t / fit.span;
    phase.push_back(two_pi * std::fmod(fit.frequency * t, 1.0) + std::arg(fit.line[0]));
    values.push_back(s.value[i] - (fit.polynomial.size() > 1 ? fit.polynomial[1] * u : 0.0));
  }
  return flat_tops(phase, values);
}

/// The tone of the reference; none, with a finding, where it cannot be used.
std::optional<SineFit> fit_reference(const Part& part, const Pair& pair, double start, Findings& findings) {
  const Samples& s = pair.reference;
  SineFit fit = fit_sine(s.time, s.value, start,
                         {.harmonics = harmonics_of(start, s.rate), .fit_frequency = true, .rate = s.rate});
  const double amplitude = std::abs(fit.line[0]);
  if (fit.residual_rms > reference_residual * amplitude) {
    findings.push_back({Severity::error,
                        "reference_not_one_tone",
                        {{"frequency", fit.frequency, "Hz"}, {"residual", fit.residual_rms / amplitude, "%"}},
                        part.label});
    return {};
  }
  if (fit.log_gain_variance() > reference_noise) {
    findings.push_back({Severity::error, "reference_below_noise", {}, part.label});
    return {};
  }
  const double cycles = fit.frequency_sd * fit.span;
  if (cycles > most_cycles_sd)
    findings.push_back({Severity::warning,
                        "frequency_uncertain",
                        {{"cycles", cycles}, {"loss", 1.0 - sinc(cycles), "%"}},
                        part.label});
  return fit;
}

/// The output at the frequency of the reference; at its own where its clock runs at another speed.
SineFit fit_output(const Part& part, const Samples& s, const SineFit& reference, Findings& findings) {
  const double f = reference.frequency;
  SineFitOptions how{.harmonics = f < 0.5 * s.rate ? harmonics_of(f, s.rate) : 1, .rate = s.rate};
  SineFit fit = fit_sine(s.time, s.value, f, how);
  if (fit.log_gain_variance() > noise_for_frequency) return fit;
  how.fit_frequency = true;
  const SineFit free = fit_sine(s.time, s.value, f, how);
  const double difference = std::abs(free.frequency - f);
  if (difference * fit.span < least_cycles_apart ||
      difference < frequency_apart_sd * std::hypot(free.frequency_sd, reference.frequency_sd))
    return fit;
  findings.push_back({Severity::warning,
                      "clocks_disagree",
                      {{"difference", (free.frequency - f) / f, "ppm"}, {"cycles", difference * fit.span}},
                      part.label});
  return free;
}

double distortion_of(const SineFit& fit) {
  if (fit.line.size() < 2) return std::nan("");
  double power = 0.0;
  for (std::size_t k = 1; k < fit.line.size(); ++k) power += std::norm(fit.line[k]);
  return std::sqrt(power / std::norm(fit.line[0]));
}

/// Variance of ln gain by the rounding to whole pulses, (3.14).
double counting_variance(const Part& part, const Samples& samples, const SineFit& output, double rate) {
  if (part.output.channel->kind != QuantityKind::count) return rounding_variance(samples, output);
  return vibration::rounding_log_variance(std::abs(output.line[0]), output.frequency / rate, 0.0,
                                          static_cast<double>(output.samples));
}

Point point_of(const Part& part, const Samples& samples, const SineFit& output, const SineFit& reference,
               const Scaling& scaling, double rate) {
  Point p;
  p.frequency = reference.frequency;
  p.nominal = part.motion && part.motion->kind == Motion::Kind::sine ? part.motion->frequency
                                                                     : vibration::three_digits(reference.frequency);
  const double turns = reference.frequency * (output.centre - reference.centre);
  p.response = corrected(output.line[0] / (reference.line[0] * std::polar(1.0, two_pi * std::fmod(turns, 1.0))),
                         p.frequency, scaling);
  p.output_gain_variance = output.log_gain_variance();
  p.output_phase_variance = output.phase_variance();
  p.output_dof = output.degrees_of_freedom;
  p.counting_variance = counting_variance(part, samples, output, rate);
  p.reference_gain_variance = reference.log_gain_variance();
  p.reference_phase_variance = reference.phase_variance();
  p.reference_dof = reference.degrees_of_freedom;
  const double power = 0.5 * std::norm(output.line[0]);
  p.coherence = power / (power + output.residual_rms * output.residual_rms);
  p.amplitude = std::abs(reference.line[0]);
  p.cycles = p.frequency * output.span;
  p.distortion = distortion_of(output);
  p.aliased_to = p.frequency > 0.5 * rate ? aliased_frequency(p.frequency, rate) : 0.0;
  p.where = part.label;
  return p;
}

/// Why the fitted output cannot be used; none: it can.
std::optional<Finding> fault_of(const Part& part, const Samples& samples, const SineFit& output,
                                const SineFit& reference) {
  const double frequency = reference.frequency;
  const double amplitude = std::abs(output.line[0]);
  if (!(amplitude > 0.0) || output.log_gain_variance() > tone_below_noise)
    return Finding{Severity::error, "tone_below_noise", {{"frequency", frequency, "Hz"}}, part.label};
  if (clipped(samples, output, reference))
    return Finding{Severity::error,
                   "tone_clipped",
                   {{"frequency", frequency, "Hz"}, {"harmonics", std::abs(output.line[2]) / amplitude, "%"}},
                   part.label};
  const FlatTops tops = flat_tops_of(samples, output);
  if (tops.found && tops.loss > std::max(least_loss, loss_sd * std::sqrt(output.log_gain_variance())))
    return Finding{Severity::error,
                   "tone_clipped_in_noise",
                   {{"frequency", frequency, "Hz"}, {"loss", tops.loss, "%"}},
                   part.label};
  return {};
}

/// Why the fitted reference cannot be used: flat tops, also beneath its noise; none: it can.
std::optional<Finding> fault_of_reference(const Part& part, const Samples& samples, const SineFit& reference) {
  const FlatTops tops = flat_tops_of(samples, reference);
  if (!tops.found || tops.loss < std::max(least_loss, loss_sd * std::sqrt(reference.log_gain_variance()))) return {};
  return Finding{Severity::error,
                 "reference_clipped",
                 {{"frequency", reference.frequency, "Hz"}, {"loss", tops.loss, "%"}},
                 part.label};
}

void measure(const Part& part, double begin, double end, const Scaling& scaling, const Settings& settings,
             Points& points) {
  Findings& findings = points.findings;
  const auto unusable = [&](std::optional<Finding> fault) {
    if (fault) findings.push_back(*fault);
    return fault.has_value();
  };
  Pair pair = pair_of(part, begin, end, scaling);
  if (pair.output.time.size() < fewest_of_tone || pair.reference.time.size() < fewest_of_tone) {
    findings.push_back({Severity::error, "too_few_samples_for_tone", {}, part.label});
    return;
  }
  const double start = start_frequency(part, pair.reference, findings);
  if (unusable(settle(pair, start, settings, part.label))) return;
  if (const Extent tone = extent_of(pair.reference, start); tone.cut) {
    findings.push_back({Severity::warning,
                        "tone_not_throughout",
                        {{"begin", tone.begin - pair.reference.time.front(), "s"},
                         {"end", pair.reference.time.back() - tone.end, "s"}},
                        part.label});
    for (Samples* s : {&pair.output, &pair.reference}) cut(*s, tone.begin, tone.end);
  }
  const auto reference = fit_reference(part, pair, start, findings);
  if (!reference) return;
  if (unusable(fault_of_reference(part, pair.reference, *reference))) return;
  const double f = reference->frequency, rate = pair.output.rate;
  if (unusable(objection(f, pair.output.time.back() - pair.output.time.front(), rate, scaling, settings, part.label)))
    return;
  const SineFit output = fit_output(part, pair.output, *reference, findings);
  if (unusable(fault_of(part, pair.output, output, *reference))) return;
  if (const double third = own_third(output, *reference);
      third > std::max({distorted, distorted_sd * std::sqrt(output.log_gain_variance()),
                        distorted_sd * std::sqrt(rounding_variance(pair.output, output))}))
    findings.push_back({Severity::warning,
                        "tone_distorted",
                        {{"frequency", f, "Hz"}, {"third", third, "%"}, {"gain", 3.0 * third, "%"}},
                        part.label});
  points.usable.push_back(point_of(part, pair.output, output, *reference, scaling, rate));
  if (const double image = points.usable.back().aliased_to; image > 0.0)
    findings.push_back({Severity::info,
                        "tone_aliased",
                        {{"frequency", f, "Hz"}, {"rate", rate, "Hz"}, {"image", image, "Hz"}},
                        part.label});
}

}  // namespace

std::complex<double> corrected(std::complex<double> ratio, double frequency, const Scaling& scaling) {
  ratio *= scaling.output * sinc(frequency * scaling.reference_window) / sinc(frequency * scaling.output_window);
  if (scaling.differentiate) ratio /= std::complex<double>(0.0, two_pi * frequency);
  return ratio;
}

std::optional<Finding> objection(double frequency, double span, double output_rate, const Scaling& scaling,
                                 const Settings& settings, const std::string& where) {
  if (auto hidden = vibration::hidden_tone(frequency, scaling.output_window, 1.0 / output_rate, span, where))
    return hidden;
  if (settings.has("reference_maximum") && frequency > settings.number("reference_maximum"))
    return Finding{Severity::error,
                   "tone_beyond_reference",
                   {{"frequency", frequency, "Hz"}, {"maximum", settings.number("reference_maximum"), "Hz"}},
                   where};
  return {};
}

void add_tone(const Part& part, double begin, double end, const Scaling& scaling, const Settings& settings,
              Points& points) {
  try {
    measure(part, begin, end, scaling, settings, points);
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_data) throw;
    points.findings.push_back({Severity::error, "segment_not_measurable", {{"reason", reason_of(error)}}, part.label});
  }
}

}  // namespace tumble::frequency_response
