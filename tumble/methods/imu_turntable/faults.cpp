#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/math/median.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/methods/imu_turntable/turntable.hpp"
#include "tumble/reduce/imu/axes_check.hpp"
#include "tumble/reduce/linear/rows.hpp"

namespace tumble::imu_turntable {
namespace {

using SegmentPlace = std::array<std::size_t, 3>;

constexpr std::size_t parts_of_beginning = 10;  ///< the first tenth of a segment is compared with its second half
constexpr double fewest_steps = 3.0;            ///< of the second half, that show noise
constexpr double least_turning_rate = 1.0, least_turning_share = 0.05;  ///< [deg/s]; [1] of the fastest: turning gyros
/// [sd of the beginning], and [1] of the usual change of the segments at rest, beyond which one is not at rest.
constexpr double change_by_noise = 10.0, change_by_others = 10.0;

/// One output in one segment.
struct Summary {
  double mean = 0.0;
  double change = 0.0;  ///< first tenth less the second half
  double noise = 0.0;   ///< of it, by what neighbouring samples differ
};

double mean_of(const EvenValues& values, std::size_t begin, std::size_t end) {
  double sum = 0.0, count = 0.0;
  for (std::size_t i = begin; i < end; ++i)
    if (!std::isnan(values[i])) {
      sum += values[i];
      count += 1.0;
    }
  return count > 0.0 ? sum / count : std::nan("");
}

Summary summary_of(const EvenValues& values) {
  const std::size_t n = values.size(), first = std::max<std::size_t>(1, n / parts_of_beginning), half = n / 2;
  Summary summary{mean_of(values, 0, n), mean_of(values, 0, first) - mean_of(values, half, n), 0.0};
  double sum = 0.0, count = 0.0;
  for (std::size_t i = half + 1; i < n; ++i)
    if (const double d = values[i] - values[i - 1]; !std::isnan(d)) {
      sum += d * d;
      count += 1.0;
    }
  summary.noise = count > fewest_steps ? std::sqrt(0.5 * sum / count / static_cast<double>(first)) : INFINITY;
  return summary;
}

std::map<SegmentPlace, Summary> summaries_of(const Evidence& evidence, const linear::Problem& problem) {
  std::map<SegmentPlace, Summary> out;
  const auto test = linear::evidence_of(evidence, problem).test;
  for (const auto& stretch : test.stretches)
    out[{stretch.recording, stretch.power_up, stretch.segment}] = summary_of(stretch.values);
  return out;
}

using Summaries = std::array<std::map<SegmentPlace, Summary>, 3>;

/// Segments that show the axes: what is felt stays as it is, accelerometers slow enough that levers do not matter,
/// gyros turning.
Findings about_triad(const Evidence& evidence, Kind kind, const Look& look, const Summaries& triad) {
  const bool gyro = kind == Kind::gyro;
  constexpr double slow = 1.0;  // [rad/s]
  double least = 0.0;
  if (gyro) least = std::max(si(least_turning_rate, "deg/s"), least_turning_share * norm(look.fastest));
  std::vector<Vector3> felt, shown;
  std::vector<std::string> labels;
  for (std::size_t g = 0; g < look.labels.size(); ++g) {
    if (gyro ? !look.even_rate[g] : !look.even_force[g] || norm(look.rate[g]) > slow) continue;
    const Vector3 here = gyro ? look.rate[g] : look.force[g];
    const auto &x = triad[0].find(look.places[g]), &y = triad[1].find(look.places[g]),
               &z = triad[2].find(look.places[g]);
    if (norm(here) < least || x == triad[0].end() || y == triad[1].end() || z == triad[2].end()) continue;
    felt.push_back(here);
    shown.push_back({x->second.mean, y->second.mean, z->second.mean});
    labels.push_back(look.labels[g]);
  }
  if (felt.empty()) return {};
  std::array<std::string, 3> names;
  for (std::size_t i = 0; i < 3; ++i)
    names[i] = require_channel(evidence, evidence.recordings.front(), imu::role_of(kind, i)).name;
  return imu::about_triad(kind, felt, imu::without_offsets(felt, shown), labels, names);
}

/// Segments at rest whose beginning differs from their end by more than noise and drift explain, and by more than it
/// does elsewhere, or by more than any instrument drifts.
void add_unsettled(Kind kind, const Look& look, const std::map<SegmentPlace, Summary>& summaries,
                   std::vector<std::string>& labels) {
  const double little = kind == Kind::gyro ? si(0.002, "deg/s") : si(0.1, "mg");
  const double much = kind == Kind::gyro ? si(0.05, "deg/s") : si(2.0, "mg");
  std::vector<double> changes;
  for (std::size_t g = 0; g < look.labels.size(); ++g)
    if (const auto summary = summaries.find(look.places[g]); summary != summaries.end() && look.at_rest[g])
      changes.push_back(std::abs(summary->second.change));
  if (changes.empty()) return;
  const double usual = sd_of_median_size * median(changes);
  for (std::size_t g = 0; g < look.labels.size(); ++g) {
    const auto summary = summaries.find(look.places[g]);
    if (summary == summaries.end() || !look.at_rest[g]) continue;
    const double change = std::abs(summary->second.change);
    if (change > little && change > change_by_noise * summary->second.noise &&
        (change > change_by_others * usual || change > much) &&
        std::ranges::find(labels, look.labels[g]) == labels.end())
      labels.push_back(look.labels[g]);
  }
}

Findings about_rest(const std::vector<std::string>& labels) {
  if (labels.empty()) return {};
  return {{Finding::Severity::warning,
           "table_not_at_rest",
           {{"segments", fmt::format("'{}'", fmt::join(labels, "', '"))}},
           "",
           {labels.size(), labels.front(), {}}}};
}

}  // namespace

Findings faults_of(const Evidence& evidence, const Task& task) {
  Findings findings;
  std::vector<std::string> unsettled;
  for (std::size_t k = 0; k < task.kinds.size(); ++k) {
    Summaries triad;
    for (std::size_t i = 0; i < 3; ++i) {
      triad[i] = summaries_of(evidence, task.problems[3 * k + i]);
      add_unsettled(task.kinds[k], task.look, triad[i], unsettled);
    }
    for (auto& finding : about_triad(evidence, task.kinds[k], task.look, triad)) findings.push_back(std::move(finding));
  }
  for (auto& finding : about_rest(unsettled)) findings.push_back(std::move(finding));
  return findings;
}

}  // namespace tumble::imu_turntable
