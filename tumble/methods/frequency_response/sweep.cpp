#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "tumble/clocks/clock.hpp"
#include "tumble/math/regression/local_polynomial.hpp"
#include "tumble/math/regression/sine_fit.hpp"
#include "tumble/methods/frequency_response/point.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::frequency_response {
namespace {

using Severity = Finding::Severity;

constexpr double inside_range = 1.02;  ///< ratio of the ends to the frequencies that are evaluated

constexpr int most_decades = 20;
/// Multiples of a sample of the output that are tried for a whole number of samples of the reference, and [1] of that
/// number, within which it is whole.
constexpr std::size_t most_multiples = 1000;
constexpr double whole_within = 1e-7, whole_floor = 1e-6;
constexpr double least_used = 0.98;  ///< [1] of the samples that a length for the Fourier transform must keep
/// [1] of the sampling rates: below the half by the slope of an anti-aliasing filter; [1] of the window's first null.
constexpr double highest_of_rate = 0.45, highest_of_null = 0.95;
constexpr std::size_t fewest_of_sweep = 64;  ///< samples
constexpr double low_coherence = 0.99;       ///< 1 % of the output's power is not explained: 10 % of its amplitude

/// Frequencies at which a sweep is evaluated: the preferred numbers R10 for ten in a decade.
std::vector<double> frequencies_between(double low, double high, int per_decade) {
  static const double r10[]{1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0};
  std::vector<double> frequencies;
  const int first = static_cast<int>(std::floor(std::log10(low))) * per_decade;
  for (int k = first; k < first + most_decades * per_decade; ++k) {
    const int within = ((k % per_decade) + per_decade) % per_decade;
    double f = rounded_to_digits(std::pow(10.0, static_cast<double>(k) / per_decade), 3);
    if (per_decade == 10) f = rounded_to_digits(r10[within] * std::pow(10.0, (k - within) / per_decade), 3);
    if (f > high) break;
    if (f >= low) frequencies.push_back(f);
  }
  return frequencies;
}

/// Why a channel cannot be transformed; none: it can.
std::optional<Finding> fault_of(const Signal& signal, const Samples& samples, const std::string& where) {
  const Channel& channel = *signal.channel;
  if (samples.missing > 0)
    return Finding{
        Severity::error, "sweep_incomplete", {{"channel", channel.name}, {"missing", samples.missing}}, where};
  if (channel.timeline.uniform() || clock_of(channel).even) return {};
  return Finding{Severity::error, "sweep_not_even", {{"channel", channel.name}}, where};
}

/// Numbers of samples that span one time and suit a Fourier transform; zeros where there are none.
std::pair<std::size_t, std::size_t> lengths(std::size_t output, double output_rate, std::size_t reference,
                                            double reference_rate) {
  const double ratio = reference_rate / output_rate;
  for (std::size_t multiple = 1; multiple <= most_multiples; ++multiple) {
    const double other = static_cast<double>(multiple) * ratio;
    if (std::round(other) < 1.0 || std::abs(other - std::round(other)) > whole_within * other) continue;
    const auto most = std::min(output, static_cast<std::size_t>(static_cast<double>(reference) / ratio + whole_floor));
    std::size_t n = smooth_length(most, multiple);
    if (static_cast<double>(n) < least_used * static_cast<double>(most)) n = most / multiple * multiple;
    if (n == 0) break;
    return {n, static_cast<std::size_t>(std::llround(static_cast<double>(n) * ratio))};
  }
  return {0, 0};
}

/// Removes the samples that one channel has before the other begins.
void begin_together(Samples& a, Samples& b) {
  const double begin = std::max(a.time.front(), b.time.front());
  for (Samples* s : {&a, &b}) {
    const auto ahead = static_cast<std::ptrdiff_t>(std::max(0.0, std::round((begin - s->time.front()) * s->rate)));
    s->time.erase(s->time.begin(), s->time.begin() + std::min(ahead, std::ssize(s->time)));
    s->value.erase(s->value.begin(), s->value.begin() + std::min(ahead, std::ssize(s->value)));
  }
}

struct Range {
  double low = 0.0, high = 0.0;
};

Range range_of(const Part& part, const Samples& reference, double output_rate, const Scaling& scaling,
               const Settings& settings, Points& points) {
  const auto [low, high] = occupied_band(reference.value, reference.rate);
  Range range{low, high};
  if (part.motion && part.motion->kind == Motion::Kind::sweep) {
    range.low = std::max(low, std::min(part.motion->frequency, part.motion->to_frequency));
    range.high = std::min(high, std::max(part.motion->frequency, part.motion->to_frequency));
  }
  const auto limit = [&](double to, const Phrase& reason) {
    if (range.high <= to) return;
    points.findings.push_back({Severity::warning,
                               "sweep_limited",
                               {{"highest", range.high, "Hz"}, {"limit", to, "Hz"}, {"reason", reason}},
                               part.label});
    range.high = to;
  };
  limit(highest_of_rate * output_rate, Phrase{"sweep_is_aliased"});
  limit(highest_of_rate * reference.rate, Phrase{"sweep_exceeds_reference_rate"});
  if (settings.has("reference_maximum")) limit(settings.number("reference_maximum"), Phrase{"sweep_exceeds_reference"});
  if (scaling.output_window > 0.0) limit(highest_of_null / scaling.output_window, Phrase{"sweep_exceeds_null"});
  return range;
}

Point point_of(const BandResponse& band, double late, const Scaling& scaling, const std::string& where) {
  Point p;
  p.frequency = p.nominal = band.frequency;
  p.response = corrected(band.response * std::polar(1.0, -two_pi * band.frequency * late), band.frequency, scaling);
  p.output_gain_variance = p.output_phase_variance = band.variance;
  p.output_dof = band.degrees_of_freedom;
  p.coherence = band.coherence;
  p.amplitude = band.input_amplitude;
  p.where = where;
  return p;
}

/// Output and reference over one time, ready for a Fourier transform; none, with a finding, where they are not.
bool prepare(const Part& part, Samples& output, Samples& reference, Findings& findings) {
  for (const auto& fault : {fault_of(part.output, output, part.label), fault_of(part.reference, reference, part.label)})
    if (fault) {
      findings.push_back(*fault);
      return false;
    }
  if (output.time.size() < fewest_of_sweep || reference.time.size() < fewest_of_sweep) {
    findings.push_back({Severity::error, "too_few_samples_for_sweep", {}, part.label});
    return false;
  }
  begin_together(output, reference);
  const auto [n, m] = lengths(output.value.size(), output.rate, reference.value.size(), reference.rate);
  if (n == 0) {
    findings.push_back({Severity::error,
                        "sweep_rates_do_not_match",
                        {{"output", output.rate, "Hz"}, {"reference", reference.rate, "Hz"}},
                        part.label});
    return false;
  }
  output.value.resize(n);
  reference.value.resize(m);
  return true;
}

void measure(const Part& part, const Scaling& scaling, const Settings& settings, Points& points) {
  Samples output = samples_of(part.output, part.begin, part.end, scaling.output_shift);
  Samples reference = samples_of(part.reference, part.begin, part.end, scaling.reference_shift);
  if (!prepare(part, output, reference, points.findings)) return;
  const Range range = range_of(part, reference, output.rate, scaling, settings, points);
  const int per_decade = settings.integer("points_per_decade");
  const auto frequencies = frequencies_between(range.low * inside_range, range.high / inside_range, per_decade);
  const double late = output.time.front() - reference.time.front();
  std::vector<double> weak;
  double least = 1.0;
  for (const BandResponse& band :
       local_polynomial_response(reference.value, reference.rate, output.value, output.rate, frequencies, range.low,
                                 range.high, 0.5 * std::log(10.0) / per_decade)) {
    if (!band.found || !(band.variance < tone_below_noise)) {
      weak.push_back(band.frequency);
      continue;
    }
    least = std::min(least, band.coherence);
    points.usable.push_back(point_of(band, late, scaling, part.label));
  }
  if (!weak.empty())
    points.findings.push_back(
        {Severity::warning,
         "sweep_frequencies_skipped",
         {{"skipped", weak.size()}, {"frequencies", frequencies.size()}, {"lowest", weak.front(), "Hz"}},
         part.label});
  if (least < low_coherence)
    points.findings.push_back(
        {Severity::warning, "low_coherence", {{"coherence", least}, {"loss", 1.0 - least, "%"}}, part.label});
}

}  // namespace

void add_sweep(const Part& part, const Scaling& scaling, const Settings& settings, Points& points) {
  try {
    measure(part, scaling, settings, points);
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_data) throw;
    points.findings.push_back({Severity::error, "segment_not_measurable", {{"reason", reason_of(error)}}, part.label});
  }
}

}  // namespace tumble::frequency_response
