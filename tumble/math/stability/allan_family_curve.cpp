#include "tumble/math/stability/allan_family_curve.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/math/stability/allan_phase.hpp"
#include "tumble/math/stability/allan_theoh.hpp"

namespace tumble {
namespace {

constexpr std::size_t fewest_blocks = 16;     ///< to a tau; twice as many of Theo1, whose strides end in it
constexpr std::size_t most_points = 4096;     ///< of the record, for ThêoBR
constexpr std::size_t points_that_tell = 31;  ///< the noise type

constexpr std::size_t most_exact = 10000;  ///< samples

enum class Work { once, phase_means, rate_means, theoh };

Work work_of(Stability measure) {
  switch (measure) {
    case Stability::modified_total:
    case Stability::time_total:
      return Work::phase_means;
    case Stability::hadamard_total:
    case Stability::theo1:
      return Work::rate_means;
    case Stability::theoh:
      return Work::theoh;
    default:
      return Work::once;
  }
}

double longest_fraction(Stability measure, double asked) {
  switch (measure) {
    case Stability::modified_total:
    case Stability::time_total:
    case Stability::hadamard_total:
      return 1.0 / 3.0;
    case Stability::total:
    case Stability::peak_interval_error:
    case Stability::rms_interval_error:
      return 0.5;
    case Stability::theo1:
      return 1.0;  // of its m: tau is 0.75 m
    case Stability::theoh:
      return 0.75;
    default:
      return asked;
  }
}

bool is_interval_measure(Stability measure) {
  return measure == Stability::peak_interval_error || measure == Stability::rms_interval_error;
}

/// The integral of the mean that integrate_rate took off.
void add_mean_rate(std::span<const double> rate, double sample_rate, std::vector<double>& phase) {
  double sum = 0.0, present = 0.0;
  for (const double value : rate) {
    if (std::isnan(value)) continue;
    sum += value;
    ++present;
  }
  for (std::size_t n = 0; n < phase.size(); ++n) phase[n] += sum / present * static_cast<double>(n) / sample_rate;
}

int type_at(std::span<const DeviationPoint> known, double tau) {
  int alpha = known.empty() ? 0 : known.front().alpha;
  for (const auto& point : known)
    if (point.tau <= tau * (1.0 + 1e-9)) alpha = point.alpha;
  return alpha;
}

/// Every `size`-th point of each run, or the means of so many.
struct Thinned {
  std::vector<double> values;
  std::vector<PhaseRun> runs;
};

Thinned thinned(const Phase& phase, std::size_t size, bool means) {
  Thinned result;
  for (const auto& run : phase.runs) {
    const std::size_t count = means ? run.points() / size : (run.points() - 1) / size + 1;
    if (count < 2) continue;
    const std::size_t first = result.values.size();
    for (std::size_t k = 0; k < count; ++k) {
      const double* const from = phase.values.data() + run.first + k * size;
      double sum = from[0];
      for (std::size_t i = 1; means && i < size; ++i) sum += from[i];
      result.values.push_back(means ? sum / static_cast<double>(size) : sum);
    }
    result.runs.push_back({first, result.values.size() - 1});
  }
  return result;
}

struct Job {
  Stability measure;
  const Phase& phase;
  double interval, confidence;
  bool remove_bias;
  std::span<const DeviationPoint> known;
};

std::vector<DeviationPoint> points_at(const Job& job, const Phase& phase, std::size_t block,
                                      const std::vector<std::size_t>& factors, double longest_typed) {
  StabilityOptions options{.confidence = job.confidence, .remove_bias = job.remove_bias};
  const double interval = static_cast<double>(block) * job.interval;
  for (const std::size_t m : factors)
    options.types.push_back(type_at(job.known, std::min(longest_typed, static_cast<double>(m) * interval)));
  auto points = stability_of_runs(job.measure, phase, interval, factors, options);
  for (auto& point : points) point.factor *= block;
  return points;
}

std::vector<DeviationPoint> thinned_points(const Job& job, std::size_t block, bool means,
                                           const std::vector<std::size_t>& factors, double longest_typed) {
  if (block == 1) return points_at(job, job.phase, block, factors, longest_typed);
  const Thinned thin = thinned(job.phase, block, means);
  return thin.runs.empty() ? std::vector<DeviationPoint>{}
                           : points_at(job, {thin.values, thin.runs, nullptr}, block, factors, longest_typed);
}

/// Each factor from blocks of its own size.
std::vector<DeviationPoint> in_blocks(const Job& job, bool means, const std::vector<std::size_t>& factors) {
  std::map<std::size_t, std::vector<std::size_t>> by_block;
  const std::size_t fewest = job.measure == Stability::theo1 ? 2 * fewest_blocks : fewest_blocks;
  for (const std::size_t m : factors) {
    const std::size_t block = std::max<std::size_t>(1, m / fewest);
    std::size_t left = block < 2 ? m : (m + block / 2) / block;
    if (job.measure == Stability::theo1) left += left % 2;
    auto& list = by_block[block < 2 ? 1 : block];
    if (list.empty() || list.back() < left) list.push_back(left);
  }
  std::vector<DeviationPoint> points;
  for (const auto& [block, list] : by_block)
    for (const auto& point : thinned_points(job, block, means, list, INFINITY))
      if (points.empty() || point.factor > points.back().factor) points.push_back(point);
  return points;
}

std::vector<DeviationPoint> of_theoh(const Job& job, const std::vector<std::size_t>& factors) {
  const std::size_t samples = job.phase.values.size() - 1, block = (samples + most_points - 1) / most_points;
  std::vector<std::size_t> direct, far;
  for (const std::size_t m : factors) {
    if (theoh_shortest_ratio * static_cast<double>(m) <= static_cast<double>(samples))
      direct.push_back(m);
    else if (const std::size_t left = (m + 3 * block / 2) / (3 * block) * 3; far.empty() || far.back() < left)
      far.push_back(left);
  }
  const double typed = job.interval * static_cast<double>(std::max<std::size_t>(1, samples / points_that_tell));
  Job allan = job;
  allan.measure = Stability::overlapping_allan;
  auto points = points_at(allan, job.phase, 1, direct, INFINITY);
  const auto beyond = thinned_points(job, block, false, far, typed);
  points.insert(points.end(), beyond.begin(), beyond.end());
  return points;
}

}  // namespace

std::vector<DeviationPoint> stability_curve(Stability measure, std::span<const double> rate, double sample_rate,
                                            const AllanOptions& options, std::span<const DeviationPoint> known) {
  Phase phase = integrate_rate(rate, 3);
  std::vector<double> values(phase.values.begin(), phase.values.end());
  for (double& value : values) value /= sample_rate;
  if (!options.subtract_mean_rate && is_interval_measure(measure)) add_mean_rate(rate, sample_rate, values);
  phase.values = values;
  const double longest = longest_fraction(measure, options.longest_fraction) * static_cast<double>(rate.size());
  const auto factors =
      options.factors.empty()
          ? averaging_factors(std::max<std::size_t>(1, static_cast<std::size_t>(longest)), options.points_per_decade)
          : options.factors;
  const Job job{measure, phase, 1.0 / sample_rate, options.confidence, options.remove_bias, known};
  // Averaging times that were asked for are taken as they are defined, where that does not take long.
  if (!options.factors.empty() && rate.size() <= most_exact) return points_at(job, phase, 1, factors, INFINITY);
  switch (work_of(measure)) {
    case Work::phase_means:
      return in_blocks(job, true, factors);
    case Work::rate_means:
      return in_blocks(job, false, factors);
    case Work::theoh:
      return of_theoh(job, factors);
    case Work::once:
      break;
  }
  return points_at(job, phase, 1, factors, INFINITY);
}

}  // namespace tumble
