#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/clock.hpp"
#include "tumble/core/say.hpp"
#include "tumble/math/regression/local_polynomial.hpp"
#include "tumble/methods/frequency_response/point.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::frequency_response {
namespace {

using Severity = Finding::Severity;

/// Frequencies at which a sweep is looked at: the preferred numbers R10 for ten a decade.
std::vector<double> frequencies_between(double low, double high, int per_decade) {
  static const double r10[]{1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0};
  std::vector<double> found;
  const int first = static_cast<int>(std::floor(std::log10(low))) * per_decade;
  for (int k = first; k < first + 20 * per_decade; ++k) {
    const int within = ((k % per_decade) + per_decade) % per_decade;
    double f = std::stod(fmt::format("{:.2e}", std::pow(10.0, static_cast<double>(k) / per_decade)));
    if (per_decade == 10) f = std::stod(fmt::format("{}e{}", r10[within], (k - within) / per_decade));
    if (f > high) break;
    if (f >= low) found.push_back(f);
  }
  return found;
}

void require_even(const Channel& channel, const Samples& samples) {
  if (samples.missing > 0)
    throw Error(Error::Kind::bad_data,
                fmt::format("'{}' lacks {}: a sweep must be whole; record it again, or use tones", channel.name,
                            say_count(samples.missing, "sample")));
  if (channel.timeline.uniform()) return;
  const Clock clock = clock_of(channel);
  if (!clock.even)
    throw Error(Error::Kind::bad_data,
                fmt::format("'{}' is not evenly sampled ({}): a sweep must be; use tones", channel.name, clock.reason));
}

/// Numbers of samples that span the same time and that a Fourier transform likes.
std::pair<std::size_t, std::size_t> lengths(std::size_t output, double output_rate, std::size_t reference,
                                            double reference_rate) {
  const double ratio = reference_rate / output_rate;
  for (std::size_t multiple = 1; multiple <= 1000; ++multiple) {
    const double other = static_cast<double>(multiple) * ratio;
    if (std::round(other) < 1.0 || std::abs(other - std::round(other)) > 1e-7 * other) continue;
    const auto most = std::min(output, static_cast<std::size_t>(static_cast<double>(reference) / ratio + 1e-6));
    std::size_t n = smooth_length(most, multiple);
    if (static_cast<double>(n) < 0.98 * static_cast<double>(most)) n = most / multiple * multiple;
    if (n == 0) break;
    return {n, static_cast<std::size_t>(std::llround(static_cast<double>(n) * ratio))};
  }
  throw Error(Error::Kind::bad_data,
              fmt::format("a sweep sampled at {:.9g} Hz and {:.9g} Hz has no time that is a whole number of both "
                          "samples: record both at one rate",
                          output_rate, reference_rate));
}

/// Drops what one channel has before the other begins.
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
  const auto limit = [&](double to, const std::string& why) {
    if (range.high <= to) return;
    points.findings.push_back({Severity::warning,
                               fmt::format("the sweep goes to {:.4g} Hz, used to {:.4g} Hz: {}", range.high, to, why),
                               part.label});
    range.high = to;
  };
  limit(0.45 * output_rate, fmt::format("what lies above half of the sampling rate {:.6g} Hz is aliased onto the rest; "
                                        "use tones there",
                                        output_rate));
  limit(0.45 * reference.rate, "the sampling rate of the reference");
  if (settings.has("reference_maximum"))
    limit(settings.number("reference_maximum"), "the range of the reference (reference_maximum)");
  if (scaling.output_window > 0.0) limit(0.95 / scaling.output_window, "the first null of the averaging");
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

void measure(const Part& part, const Scaling& scaling, const Settings& settings, Points& points) {
  Samples output = samples_of(*part.output, part.begin, part.end, scaling.output_shift);
  Samples reference = samples_of(*part.reference, part.begin, part.end, scaling.reference_shift);
  require_even(*part.output, output);
  require_even(*part.reference, reference);
  if (output.time.size() < 64 || reference.time.size() < 64)
    throw Error(Error::Kind::bad_data, "fewer than 64 samples of output and reference: too few for a sweep");
  begin_together(output, reference);
  const auto [n, m] = lengths(output.value.size(), output.rate, reference.value.size(), reference.rate);
  output.value.resize(n);
  reference.value.resize(m);
  const Range range = range_of(part, reference, output.rate, scaling, settings, points);
  const int per_decade = settings.integer("points_per_decade");
  const auto frequencies = frequencies_between(range.low * 1.02, range.high / 1.02, per_decade);
  const double late = output.time.front() - reference.time.front();
  std::vector<double> weak;
  double least = 1.0;
  for (const BandResponse& band :
       local_polynomial_response(reference.value, reference.rate, output.value, output.rate, frequencies, range.low,
                                 range.high, 0.5 * std::log(10.0) / per_decade)) {
    if (!band.found || !(band.variance < 0.04)) {
      weak.push_back(band.frequency);
      continue;
    }
    least = std::min(least, band.coherence);
    points.found.push_back(point_of(band, late, scaling, part.label));
  }
  if (!weak.empty())
    points.findings.push_back(
        {Severity::warning,
         fmt::format("{} of {} frequencies of the sweep left out (first {:.4g} Hz): too few lines "
                     "or the output does not rise above its noise; sweep more slowly",
                     weak.size(), frequencies.size(), weak.front()),
         part.label});
  if (least < 0.99)
    points.findings.push_back({Severity::warning,
                               fmt::format("coherence falls to {:.3f}: as far as this is noise of the reference, gains "
                                           "are low by up to {:.2g} %",
                                           least, 100.0 * (1.0 - least)),
                               part.label});
}

}  // namespace

void add_sweep(const Part& part, const Scaling& scaling, const Settings& settings, Points& points) {
  try {
    measure(part, scaling, settings, points);
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_data) throw;
    points.findings.push_back({Severity::error, fmt::format("left out: {}", error.what()), part.label});
  }
}

}  // namespace tumble::frequency_response
