#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/say.hpp"
#include "tumble/math/regression/sine_fit.hpp"
#include "tumble/methods/frequency_response/point.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::frequency_response {
namespace {

using Severity = Finding::Severity;

/// Samples of both channels over the time they share, without the first `settling` [s].
struct Pair {
  Samples output, reference;
};

void keep_between(Samples& s, double begin, double end) {
  Samples kept;
  kept.rate = s.rate;
  for (std::size_t i = 0; i < s.time.size(); ++i) {
    if (s.time[i] < begin || s.time[i] > end) continue;
    kept.time.push_back(s.time[i]);
    kept.value.push_back(s.value[i]);
    kept.missing += std::isnan(s.value[i]) ? 1 : 0;
  }
  s = std::move(kept);
}

Pair pair_of(const Part& part, double begin, double end, const Scaling& scaling) {
  return {samples_of(*part.output, begin, end, scaling.output_shift),
          samples_of(*part.reference, begin, end, scaling.reference_shift)};
}

void cut(Pair& pair, double frequency, const Settings& settings) {
  const double begin = std::max(pair.output.time.front(), pair.reference.time.front());
  const double end = std::min(pair.output.time.back(), pair.reference.time.back());
  if (!(end > begin))
    throw Error(Error::Kind::bad_data,
                "the averages of output and reference have no time in common in this segment: lengthen the segment, or "
                "shorten averaging or reference_averaging");
  const double wait = settings.has("settling")
                          ? settings.number("settling")
                          : std::min(0.5 * (end - begin), std::max(0.1 * (end - begin), 2.0 / frequency));
  for (Samples* s : {&pair.output, &pair.reference}) keep_between(*s, begin + wait, end);
  if (pair.output.time.size() < 12 || pair.reference.time.size() < 12)
    throw Error(
        Error::Kind::bad_data,
        fmt::format("{} of {} are left behind the settling time of {}: lengthen the segment or set settling",
                    say_seconds(std::max(0.0, end - begin - wait)), say_seconds(end - begin), say_seconds(wait)));
}

/// Harmonics that can be told from the fundamental: those below half of the sampling rate.
int harmonics_of(double frequency, double rate) {
  return 3.0 * frequency < 0.48 * rate ? 3 : 2.0 * frequency < 0.48 * rate ? 2 : 1;
}

/// Where the search for the reference's frequency begins: its own strongest line, unfolded to the plan's frequency.
double start_frequency(const Part& part, const Samples& reference, Findings& findings) {
  const double seen = strongest_frequency(reference.value, reference.rate);
  if (!part.motion || part.motion->kind != Motion::Kind::sine) return seen;
  const double planned = part.motion->frequency, span = reference.time.back() - reference.time.front();
  double best = seen;
  if (planned > 0.5 * reference.rate) {
    const double k = std::round(planned / reference.rate) * reference.rate;
    best = planned < k ? k - seen : k + seen;
    findings.push_back({Severity::warning,
                        fmt::format("the reference is sampled at {:.6g} Hz: {:.6g} Hz is aliased in it and taken from "
                                    "the plan",
                                    reference.rate, planned),
                        part.label});
  }
  if (std::abs(best - planned) > std::max(0.02 * planned, 2.0 / span))
    findings.push_back({Severity::warning,
                        fmt::format("the plan says {:.6g} Hz, the reference oscillates at {:.6g} Hz", planned, best),
                        part.label});
  return best;
}

/// Flat tops: the same extreme three times running, again and again, and a third harmonic to match.
bool clipped(const Samples& s, const SineFit& fit) {
  if (fit.line.size() < 3 || std::abs(fit.line[2]) < 0.005 * std::abs(fit.line[0])) return false;
  double low = INFINITY, high = -INFINITY;
  for (const double v : s.value) {
    if (std::isnan(v)) continue;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  std::size_t flat = 0;
  for (std::size_t i = 2; i < s.value.size(); ++i)
    flat += (s.value[i] == high || s.value[i] == low) && s.value[i] == s.value[i - 1] && s.value[i] == s.value[i - 2];
  return flat >= 3;
}

SineFit fit_reference(const Part& part, const Pair& pair, double start, Findings& findings) {
  const Samples& s = pair.reference;
  SineFit fit = fit_sine(s.time, s.value, start,
                         {.harmonics = harmonics_of(start, s.rate), .fit_frequency = true, .rate = s.rate});
  if (fit.residual_rms > 0.35 * std::abs(fit.line[0]))
    throw Error(Error::Kind::bad_data,
                fmt::format("the reference is not one tone: beside {:.6g} Hz there is {:.0f} % of its amplitude",
                            fit.frequency, 100.0 * fit.residual_rms / std::abs(fit.line[0])));
  if (fit.log_gain_variance() > 0.01) throw Error(Error::Kind::bad_data, "the reference does not rise above its noise");
  if (fit.frequency_sd * fit.span > 0.02)
    findings.push_back({Severity::warning,
                        fmt::format("the frequency is uncertain by {:.2g} of a cycle over the time measured: the gain "
                                    "may be low by {:.2g} %",
                                    fit.frequency_sd * fit.span, 100.0 * (1.0 - sinc(fit.frequency_sd * fit.span))),
                        part.label});
  return fit;
}

/// The output at the frequency of the reference; at its own where its clock runs at another speed.
SineFit fit_output(const Part& part, const Samples& s, const SineFit& reference, Findings& findings) {
  const double f = reference.frequency;
  SineFitOptions how{.harmonics = f < 0.5 * s.rate ? harmonics_of(f, s.rate) : 1, .rate = s.rate};
  SineFit fit = fit_sine(s.time, s.value, f, how);
  if (fit.log_gain_variance() > 0.0025) return fit;
  how.fit_frequency = true;
  const SineFit free = fit_sine(s.time, s.value, f, how);
  const double off = free.frequency - f;
  if (std::abs(off) * fit.span < 0.02 || std::abs(off) < 5.0 * std::hypot(free.frequency_sd, reference.frequency_sd))
    return fit;
  findings.push_back({Severity::warning,
                      fmt::format("output and reference differ in frequency by {:.3g} ppm, {:.2g} of a cycle over the "
                                  "time measured: their clocks disagree; each is fitted at its own, the phase is that "
                                  "in the middle",
                                  1e6 * off / f, std::abs(off) * fit.span),
                      part.label});
  return free;
}

double three_digits(double f) { return std::stod(fmt::format("{:.2e}", f)); }

double distortion_of(const SineFit& fit) {
  if (fit.line.size() < 2) return std::nan("");
  double power = 0.0;
  for (std::size_t k = 1; k < fit.line.size(); ++k) power += std::norm(fit.line[k]);
  return std::sqrt(power / std::norm(fit.line[0]));
}

/// Samples after which a tone meets the sampling instants again, to less than one spacing of them over the record.
double raster(double frequency, double rate, double samples) {
  for (double p = 1.0; p < 0.25 * samples; ++p) {
    const double turns = p * frequency / rate;
    if (std::abs(turns - std::round(turns)) * samples < 1.0) return p;
  }
  return samples;
}

/// Rounding to whole pulses is that of the running total, 1/12 pulse^2, differenced: 4 sin^2(pi f/f_s) of it at f. On a
/// raster of P instants it repeats with the tone, does not show in the residuals, and only P of it are independent:
///   var = (2/P) (1/12) 4 sin^2(pi f/f_s)                    (3.14)
double counting_variance(const Part& part, const SineFit& output, double rate) {
  if (part.output->kind != QuantityKind::count) return 0.0;
  const double p = raster(output.frequency, rate, static_cast<double>(output.samples));
  if (p >= 0.25 * static_cast<double>(output.samples)) return 0.0;
  return 2.0 / (3.0 * p) * std::pow(std::sin(pi * output.frequency / rate), 2) / std::norm(output.line[0]);
}

Point point_of(const Part& part, const SineFit& output, const SineFit& reference, const Scaling& scaling, double rate) {
  Point p;
  p.frequency = reference.frequency;
  p.nominal = part.motion && part.motion->kind == Motion::Kind::sine ? part.motion->frequency
                                                                     : three_digits(reference.frequency);
  const double turns = reference.frequency * (output.centre - reference.centre);
  p.response = corrected(output.line[0] / (reference.line[0] * std::polar(1.0, two_pi * std::fmod(turns, 1.0))),
                         p.frequency, scaling);
  p.output_gain_variance = output.log_gain_variance();
  p.output_phase_variance = output.phase_variance();
  p.output_dof = output.degrees_of_freedom;
  p.counting_variance = counting_variance(part, output, rate);
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

void measure(const Part& part, double begin, double end, const Scaling& scaling, const Settings& settings,
             Points& points) {
  Pair pair = pair_of(part, begin, end, scaling);
  if (pair.output.time.size() < 16 || pair.reference.time.size() < 16)
    throw Error(Error::Kind::bad_data, "fewer than 16 samples of output and reference");
  const double start = start_frequency(part, pair.reference, points.findings);
  cut(pair, start, settings);
  const SineFit reference = fit_reference(part, pair, start, points.findings);
  const std::string why = objection(reference.frequency, pair.output.time.back() - pair.output.time.front(),
                                    pair.output.rate, scaling, settings);
  if (!why.empty()) throw Error(Error::Kind::bad_data, why);
  const SineFit output = fit_output(part, pair.output, reference, points.findings);
  if (!(std::abs(output.line[0]) > 0.0) || output.log_gain_variance() > 0.04)
    throw Error(Error::Kind::bad_data,
                fmt::format("at {:.6g} Hz the output does not rise above its noise: measure longer or with more "
                            "amplitude",
                            reference.frequency));
  if (clipped(pair.output, output))
    throw Error(Error::Kind::bad_data,
                fmt::format("at {:.6g} Hz the output is clipped: its extremes repeat and the "
                            "third harmonic is {:.2g} %; use less amplitude",
                            reference.frequency, 100.0 * std::abs(output.line[2] / output.line[0])));
  points.found.push_back(point_of(part, output, reference, scaling, pair.output.rate));
  const Point& p = points.found.back();
  if (p.aliased_to > 0.0)
    points.findings.push_back({Severity::info,
                               fmt::format("{:.6g} Hz is above half of the sampling rate {:.6g} Hz and shows at {:.6g} "
                                           "Hz: fitted at its true frequency",
                                           p.frequency, pair.output.rate, p.aliased_to),
                               part.label});
}

}  // namespace

double sinc(double x) { return x == 0.0 ? 1.0 : std::sin(pi * x) / (pi * x); }

std::complex<double> corrected(std::complex<double> ratio, double frequency, const Scaling& scaling) {
  ratio *= scaling.output * sinc(frequency * scaling.reference_window) / sinc(frequency * scaling.output_window);
  if (scaling.differentiate) ratio /= std::complex<double>(0.0, two_pi * frequency);
  return ratio;
}

std::string objection(double frequency, double time, double output_rate, const Scaling& scaling,
                      const Settings& settings) {
  const double turns = frequency * scaling.output_window;
  if (std::round(turns) > 0.0 && std::abs(turns - std::round(turns)) < 0.05)
    return fmt::format(
        "{:.6g} Hz lies within 5 % of a null of the mean over {}: move it by a tenth, or shorten the "
        "averaging",
        frequency, say_seconds(scaling.output_window));
  const double half = 0.5 * output_rate, off = frequency - half * std::round(frequency / half);
  if (std::round(frequency / half) > 0.0 && std::abs(off) * time < 1.5)
    return fmt::format(
        "{:.6g} Hz is a multiple of half of the sampling rate {:.6g} Hz to within {:.2g} Hz: sine and "
        "cosine cannot be told apart; move it by more than {:.2g} Hz, for example to {:.6g} Hz",
        frequency, output_rate, std::abs(off), 1.5 / time, frequency - 3.0 / time - off);
  if (settings.has("reference_maximum") && frequency > settings.number("reference_maximum"))
    return fmt::format("{:.6g} Hz is above the range of the reference (reference_maximum = {:.6g} Hz)", frequency,
                       settings.number("reference_maximum"));
  return "";
}

void add_tone(const Part& part, double begin, double end, const Scaling& scaling, const Settings& settings,
              Points& points) {
  try {
    measure(part, begin, end, scaling, settings, points);
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_data) throw;
    points.findings.push_back({Severity::error, fmt::format("left out: {}", error.what()), part.label});
  }
}

}  // namespace tumble::frequency_response
