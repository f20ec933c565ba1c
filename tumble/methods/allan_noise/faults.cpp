#include "tumble/methods/allan_noise/faults.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/units/constants.hpp"

namespace tumble::allan_noise {
namespace {

using Severity = Finding::Severity;

/// Ratio of the least step of an output to its rms difference, and to its sd within a block. Rounding to steps of 2.3
/// sd gives differences of 1/1.33 of the step, two levels that alternate at random 1/1.41.
constexpr double step_to_difference = 1.3, step_to_sd = 1.75;
constexpr double step_rounding = 1e-9;  ///< [1] of a value: a smaller step comes from the arithmetic of the file

}  // namespace

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
