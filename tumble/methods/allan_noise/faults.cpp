#include "tumble/methods/allan_noise/faults.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/bisection.hpp"
#include "tumble/math/square.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::allan_noise {
namespace {

using Severity = Finding::Severity;

/// Ratio of the least step of an output to its rms difference, and to its sd within a block. Rounding to steps of 2.3
/// sd gives differences of 1/1.33 of the step, two levels that alternate at random 1/1.41.
constexpr double step_to_difference = 1.3, step_to_sd = 1.75;
constexpr double step_rounding = 1e-9;  ///< [1] of a value: a smaller step comes from the arithmetic of the file

/// Octaves of white noise between the slow terms and a filter, below which flicker among them cannot be separated from the
/// filter: of four, flicker that is a quarter of the white noise in their middle is half of it at their lower end and an eighth
/// at the upper one, as the edge of a filter of unknown shape is.
constexpr double least_octaves = 4.0;

/// Density [u^2 samples] of the terms that are slower than white noise at w [rad/sample].
double slow_density(const NoiseFit& fit, double w) {
  double sum = 0.0;
  for (const FittedTerm& term : fit.terms) {
    if (!term.kept) continue;
    const double time = term.unit.markov_time;
    if (term.unit.term == NoiseTerm::flicker) sum += term.squared / w;
    if (term.unit.term == NoiseTerm::random_walk) sum += term.squared / (w * w);
    if (term.unit.term == NoiseTerm::markov) sum += 2.0 * term.squared * time / (1.0 + square(w * time));
  }
  return sum;
}

}  // namespace

Findings filter_near_slow_terms(const ChannelNoise& channel) {
  const NoiseFit& fit = channel.fit;
  const auto white = std::ranges::find(fit.terms, NoiseTerm::white, [](const FittedTerm& t) { return t.unit.term; });
  if (!fit.filter.given() || white == fit.terms.end() || !white->kept) return {};
  constexpr int halvings = 50;
  const double octaves = bisected(0.0, least_octaves, halvings, [&](double below) {
                           return slow_density(fit, two_pi * fit.filter.bandwidth * std::exp2(-below)) < white->squared;
                         }).low;
  if (slow_density(fit, two_pi * fit.filter.bandwidth * std::exp2(-least_octaves)) < white->squared) return {};
  return {{Severity::warning,
           "filter_near_slow_terms",
           {{"bandwidth", fit.filter.bandwidth * channel.rate, "Hz"},
            {"octaves", octaves},
            {"term", words(NoiseTerm::white, channel.kind).name}},
           channel.label}};
}

Findings coarse_output(std::span<const double> values, const std::string& label) {
  constexpr std::size_t block = 32;
  double least = INFINITY, squares = 0.0, count = 0.0, scatter = 0.0, scattered = 0.0, largest = 0.0;
  for (std::size_t first = 0; first + block <= values.size(); first += block) {
    double mean = 0.0, square = 0.0;
    for (std::size_t i = first; i < first + block; ++i) {
      const double off = values[i] - values[first];
      mean += off / block;
      square += off * off / block;
      if (i == first) continue;
      const double step = std::abs(values[i] - values[i - 1]);
      if (std::isnan(step)) continue;
      squares += step * step;
      ++count;
      if (step > step_rounding * std::abs(values[i]) && step < least) least = step;
      largest = std::max(largest, step);
    }
    // Fine output is known by its first values: the mean square of all is at least this.
    if (least * least < step_to_difference * step_to_difference * squares / static_cast<double>(values.size()))
      return {};
    if (std::isnan(mean)) continue;
    scatter += std::max(0.0, square - mean * mean);
    ++scattered;
  }
  if (!(count > 0.0 && scattered > 0.0) || !std::isfinite(least)) return {};
  const double difference = std::sqrt(squares / count), sd = std::sqrt(scatter / scattered);
  if (least < step_to_difference * difference || least < step_to_sd * sd) return {};
  return {{Severity::error, "output_coarser_than_noise", {{"step", least / std::max(sd, 1e-300)}}, label}};
}

Findings times_at_bound(const ChannelNoise& channel) {
  const NoiseFit& fit = channel.fit;
  Findings findings;
  std::size_t process = 0;
  for (const auto& term : fit.terms) {
    if (term.unit.term != NoiseTerm::markov || process >= fit.time_at_bound.size()) continue;
    if (!fit.time_at_bound[process++]) continue;
    const bool slow = term.unit.markov_time > 0.5 * fit.longest_time;
    findings.push_back({Severity::error,
                        slow ? "process_too_slow" : "process_too_fast",
                        {{"time", term.unit.markov_time / channel.rate, "s"}},
                        channel.label});
  }
  return findings;
}

Findings process_like_filter(const ChannelNoise& channel) {
  constexpr double most_white = 0.1, longest = 100.0;  // of the process' variance; samples: slower filters are rare
  if (channel.fit.filter.given()) return {};
  double white = 0.0;
  const FittedTerm* process = nullptr;
  for (const FittedTerm& term : channel.fit.terms) {
    if (!term.kept) continue;
    if (term.unit.term == NoiseTerm::white) white = term.squared;
    if (term.unit.term == NoiseTerm::markov && (!process || term.squared > process->squared)) process = &term;
  }
  if (!process || process->unit.markov_time > longest || white > most_white * process->squared) return {};
  const double time = process->unit.markov_time, density = 2.0 * process->squared * time;
  const TermWords said = words(NoiseTerm::white, channel.kind);
  return {{Severity::warning,
           "process_like_filter",
           {{"time", time / channel.rate, "s"},
            {"bandwidth", channel.rate / (two_pi * time), "Hz"},
            {"term", said.name},
            {"density", coefficient(NoiseTerm::white, density, channel.rate), said.unit}},
           channel.label}};
}

}  // namespace tumble::allan_noise
