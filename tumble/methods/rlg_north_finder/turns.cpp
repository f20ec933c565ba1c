#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/marks.hpp"
#include "tumble/methods/rlg_north_finder/faults.hpp"
#include "tumble/reduce/stretches.hpp"
#include "tumble/units/constants.hpp"

// How the rotations went, by what is felt on the way: about a level axis gravity goes round in the accelerometers,
// about the vertical the horizontal part of the Earth's rate does in the gyro. The totals alone show neither the sense
// of a turn about y or z nor, but for x, whether it was made.

namespace tumble::rlg_north_finder {
namespace {

using Severity = Finding::Severity;
using Segments = std::span<const linear::SegmentSummary>;
constexpr const char* axes[] = {"x", "y", "z"};

std::array<double, 3> parts(Vector3 v) { return {v.x, v.y, v.z}; }

/// The samples of one rotation: which, and its place in the plan.
struct Samples {
  const Recording* recording = nullptr;
  double begin = 0.0, end = 0.0;  ///< [s] of the recording
};

Samples samples_of(const Evidence& evidence, const linear::SegmentSummary& segment) {
  for (const auto& recording : evidence.recordings)
    for (std::size_t m = 0; m < recording.marks.size(); ++m) {
      const Mark& mark = recording.marks[m];
      if (mark.label != segment.label || mark.run != segment.run) continue;
      return {&recording, mark.begin, end_of_mark(recording, m)};
    }
  return {};
}

/// Values of a channel in [begin, end) [per second], and the instants in the middle of the samples.
struct Series {
  std::vector<double> times, values;
};

Series series_of(const Evidence& evidence, const Samples& samples, Which output) {
  const Channel& channel = require_channel(evidence, *samples.recording, role_of(output));
  const double half = 0.5 / mean_rate(channel);
  Series series;
  for (std::size_t i = index_at(channel, samples.begin - 1e-6); i < channel.values.size(); ++i) {
    if (channel.time(i) >= samples.end - 1e-6) break;
    if (std::isnan(channel.values[i])) continue;
    series.times.push_back(channel.time(i) + half);
    series.values.push_back(channel.values[i]);
  }
  return series;
}

/// How often an output went beyond half of gravity to the other side, and to which side at first.
struct Swings {
  int first = 0, count = 0;
};

Swings swings_of(const Evidence& evidence, const Samples& samples, const Summaries& segments, Which output) {
  double low = INFINITY, high = -INFINITY;  // of the stays: -g and g
  for (const auto& one : segments[output]) low = std::min(low, one.measured), high = std::max(high, one.measured);
  Swings swings;
  int last = 0;
  for (const double v : series_of(evidence, samples, output).values) {
    const double force = (2.0 * v - high - low) / (high - low);
    const int side = force > 0.5 ? 1 : force < -0.5 ? -1 : last;
    if (side == last) continue;
    if (last == 0) swings.first = side;
    last = side;
    ++swings.count;
  }
  return swings;
}

/// What was felt at the stay before a rotation.
const linear::SegmentSummary* stay_before(Segments segments, std::size_t rotation) {
  for (std::size_t s = rotation; s-- > 0;)
    if (segments[s].steady && segments[s].run == segments[rotation].run) return &segments[s];
  return nullptr;
}

/// The axis about which the body turned, by the accelerometers in which gravity went round.
const char* seen_about(const Swings& x, const Swings& y) {
  if (x.count > 1 && y.count > 1) return "neither x nor y";
  return x.count > 1 ? "y" : y.count > 1 ? "x" : "none but the vertical";
}

/// A turn about a level axis: which axis, which sense, how many turns.
void judge_level(const Turning& turning, const linear::SegmentSummary& segment, const std::array<double, 3>& force,
                 const Swings (&seen)[2], Findings& findings) {
  const auto about = static_cast<std::size_t>(turning.axis);
  for (std::size_t i = 0; i < 2; ++i)
    if ((i != about) != (seen[i].count > 1)) {
      findings.push_back(
          {Severity::error,
           fmt::format("the plan says a turn about {}, but gravity goes round in the accelerometers as about {}: the "
                       "rotations were taken in another order, or the position before them was another",
                       axes[about], seen_about(seen[0], seen[1])),
           segment.label});
      return;
    }
  for (std::size_t i = 0; i < 2; ++i) {
    if (i == about || std::abs(force[i]) > 0.3) continue;  // from level on it begins as the sine of the angle
    const std::size_t other = 3 - i - about;
    const double turned = (i + 1) % 3 == about ? -1.0 : 1.0;  // d f_i/d angle = -(axis x f)_i
    const int sense = turned * force[other] * turning.turns > 0.0 ? 1 : -1;
    if (seen[i].first != sense)
      findings.push_back({Severity::error,
                          fmt::format("ran in the other sense than the plan says: accelerometer_{} shows {} g first; "
                                      "exchange forward and reverse in the plan",
                                      axes[i], seen[i].first > 0 ? "+1" : "-1"),
                          segment.label});
    const double turns = 0.5 * seen[i].count;
    if (std::abs(turns - std::abs(turning.turns)) > 0.9)
      findings.push_back(
          {Severity::error,
           fmt::format("holds {:.3g} turns by accelerometer_{}, but the plan says {:.4g}: count the turns", turns,
                       axes[i], std::abs(turning.turns)),
           segment.label});
  }
}

/// The Earth's rate that the gyro would show on the way by the plan, and if the body turned the other way.
struct Profiles {
  std::vector<double> planned, mirrored;
};

Profiles profiles_of(const Plan& plan, const linear::SegmentSummary& segment, const Samples& samples,
                     const std::vector<double>& times) {
  Profiles profiles;
  for (const auto& power_up : power_ups_of(plan, 1.0)) {
    const auto& segments = power_up.rig.segments;
    const auto found = std::ranges::find_if(
        segments, [&](const Segment& one) { return one.label == segment.label && one.run == segment.run; });
    if (found == segments.end()) continue;
    const double begin = power_up.begins[static_cast<std::size_t>(found - segments.begin())];
    const Reference& reference = power_up.reference;
    Felt first, felt;
    reference.felt(begin, 1.0, std::span(&first, 1));
    const double x = first.rate.x, y = first.rate.y, all = x * x + y * y;
    for (const double t : times) {
      reference.felt(begin + t - samples.begin, 1.0, std::span(&felt, 1));
      const double c = (x * felt.rate.x + y * felt.rate.y) / all, s = (y * felt.rate.x - x * felt.rate.y) / all;
      profiles.planned.push_back(felt.rate.x);
      profiles.mirrored.push_back(c * x - s * y);
    }
    break;
  }
  return profiles;
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const auto n = static_cast<double>(a.size());
  double ma = 0.0, mb = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) ma += a[i] / n, mb += b[i] / n;
  for (std::size_t i = 0; i < a.size(); ++i) {
    aa += (a[i] - ma) * (a[i] - ma);
    bb += (b[i] - mb) * (b[i] - mb);
    ab += (a[i] - ma) * (b[i] - mb);
  }
  return aa > 0.0 && bb > 0.0 ? ab / std::sqrt(aa * bb) : 0.0;
}

/// A turn about the vertical. By hand it need not follow the plan: only what is clear is said.
void judge_upright(const Evidence& evidence, const linear::SegmentSummary& segment, const Samples& samples,
                   double scale, Findings& findings) {
  const Series series = series_of(evidence, samples, gyro);
  const Profiles profiles = profiles_of(evidence.plan, segment, samples, series.times);
  if (series.values.size() < 16 || profiles.planned.size() != series.values.size()) return;
  const double sign = scale < 0.0 ? -1.0 : 1.0;
  const double planned = sign * correlation(series.values, profiles.planned);
  const double mirrored = sign * correlation(series.values, profiles.mirrored);
  if (mirrored > 0.7 && mirrored > planned + 0.4)
    findings.push_back({Severity::error,
                        "ran in the other sense than the plan says: the Earth's rate goes round the other way in the "
                        "gyro; exchange forward and reverse in the plan",
                        segment.label});
}

}  // namespace

Findings turn_faults(const Evidence& evidence, const Summaries& segments) {
  Findings findings;
  const Segments of_gyro = segments[gyro];
  const Path path = path_of({of_gyro.begin(), of_gyro.end()});
  double scale = 1.0;
  if (const Turning* turning = path.rotation(0, true)) scale = of_gyro[turning->segment].measured;
  for (const auto& turning : path.rotations) {
    const auto& segment = of_gyro[turning.segment];
    const auto* before = stay_before(of_gyro, turning.segment);
    const Samples samples = samples_of(evidence, segment);
    const double whole = std::abs(turning.turns);
    if (before == nullptr || samples.recording == nullptr || whole < 0.9 || std::abs(whole - std::round(whole)) > 0.1)
      continue;
    const double step = 1.0 / mean_rate(require_channel(evidence, *samples.recording, role_of(accelerometer_x)));
    auto force = parts(before->felt.specific_force);
    for (double& f : force) f /= norm(before->felt.specific_force);
    const double upright = std::abs(force[static_cast<std::size_t>(turning.axis)]);
    if (upright > 0.95) judge_upright(evidence, segment, samples, scale, findings);
    // the turn may take a part of the time only: samples short enough for three times its mean speed
    if (upright > 0.3 || step * 3.0 * whole * two_pi / turning.seconds > 1.6) continue;
    const Swings seen[2] = {swings_of(evidence, samples, segments, accelerometer_x),
                            swings_of(evidence, samples, segments, accelerometer_y)};
    judge_level(turning, segment, force, seen, findings);
  }
  return findings;
}

}  // namespace tumble::rlg_north_finder
