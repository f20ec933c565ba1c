#include <algorithm>
#include <cmath>

#include "tumble/clocks/sampling_rate.hpp"
#include "tumble/core/marks.hpp"
#include "tumble/methods/rlg_north_finder/faults.hpp"
#include "tumble/reduce/stretches.hpp"
#include "tumble/units/constants.hpp"

// How the rotations went, by specific force and rate on the way: about a level axis gravity goes round in the
// accelerometers, about the vertical the horizontal part of the Earth's rate does in the gyro. The totals alone show
// neither the sense of a turn about y or z nor, but for x, whether it was made.

namespace tumble::rlg_north_finder {
namespace {

using Severity = Finding::Severity;
using Segments = std::span<const linear::SegmentSummary>;

constexpr double stamp_rounding = 1e-6;  ///< [s] of the ends of a segment
constexpr double level_axis = 0.3;       ///< sine of its elevation, 17 deg: from level on the output begins as the sine
constexpr double turns_off = 0.9;        ///< [turns] a swing may be missed at either end
constexpr std::size_t fewest_of_turn = 16;  ///< samples
/// Correlations of the gyro's output with the mirrored turn, and how much it must exceed that with the planned one.
constexpr double mirrored_correlation = 0.7, mirrored_by = 0.4;
constexpr double least_turns = 0.9, whole_turns = 0.1;  ///< [turns] of a rotation that is judged: whole ones
constexpr double upright_axis = 0.95;                   ///< cosine: 18 deg off the vertical
/// Samples are short enough where at this many times the mean speed the angle between two stays at a quarter turn.
constexpr double over_mean_speed = 3.0, longest_step = 1.6;  ///< [1] and [rad]

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
  const double half = 0.5 / sampling_rate(channel);
  Series series;
  for (std::size_t i = index_at(channel, samples.begin - stamp_rounding); i < channel.values.size(); ++i) {
    if (channel.time(i) >= samples.end - stamp_rounding) break;
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
  for (const auto& stay : segments[output]) low = std::min(low, stay.measured), high = std::max(high, stay.measured);
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

/// The stay before a rotation, or null.
const linear::SegmentSummary* stay_before(Segments segments, std::size_t rotation) {
  for (std::size_t s = rotation; s-- > 0;)
    if (segments[s].steady && segments[s].run == segments[rotation].run) return &segments[s];
  return nullptr;
}

/// Axis about which the body turned, by the accelerometers in which gravity went round.
Phrase turned_about(const Swings& x, const Swings& y) {
  if (x.count > 1 && y.count > 1) return Phrase{"neither_x_nor_y"};
  if (x.count > 1) return Phrase{"axis_y"};
  return y.count > 1 ? Phrase{"axis_x"} : Phrase{"vertical_axis_alone"};
}

/// A turn about a level axis: which axis, which sense, how many turns. Given: direction of gravity before it.
void judge_level(const Turning& turning, const linear::SegmentSummary& segment, Vector3 up, const Swings (&swings)[2],
                 Findings& findings) {
  const auto about = static_cast<std::size_t>(turning.axis);
  for (std::size_t i = 0; i < 2; ++i)
    if ((i != about) != (swings[i].count > 1)) {
      findings.push_back({Severity::error,
                          "rotation_about_other_axis",
                          {{"planned", axis_names[about]}, {"axis", turned_about(swings[0], swings[1])}},
                          segment.label});
      return;
    }
  for (std::size_t i = 0; i < 2; ++i) {
    if (i == about || std::abs(up[i]) > level_axis) continue;  // from level on it begins as the sine of the angle
    const std::size_t other = 3 - i - about;
    const double turned = (i + 1) % 3 == about ? -1.0 : 1.0;  // d f_i/d angle = -(axis x f)_i
    const int sense = turned * up[other] * turning.turns > 0.0 ? 1 : -1;
    const FindingValue channel{"channel", std::string("accelerometer_") + axis_names[i]};
    if (swings[i].first != sense)
      findings.push_back({Severity::error,
                          "rotation_reversed_by_gravity",
                          {channel, {"force", standard_gravity * swings[i].first, "g"}},
                          segment.label});
    const double turns = 0.5 * swings[i].count;
    if (std::abs(turns - std::abs(turning.turns)) > turns_off)
      findings.push_back({Severity::error,
                          "turns_do_not_fit_gravity",
                          {{"turns", turns}, channel, {"planned", std::abs(turning.turns)}},
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
    const auto planned = std::ranges::find_if(
        segments, [&](const Segment& some) { return some.label == segment.label && some.run == segment.run; });
    if (planned == segments.end()) continue;
    const double begin = power_up.begins[static_cast<std::size_t>(planned - segments.begin())];
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

/// A turn about the vertical. A turn by hand may differ from the plan: only a clear reversal is a finding.
void judge_upright(const Evidence& evidence, const linear::SegmentSummary& segment, const Samples& samples,
                   double scale, Findings& findings) {
  const Series series = series_of(evidence, samples, gyro);
  const Profiles profiles = profiles_of(evidence.plan, segment, samples, series.times);
  if (series.values.size() < fewest_of_turn || profiles.planned.size() != series.values.size()) return;
  const double sign = scale < 0.0 ? -1.0 : 1.0;
  const double planned = sign * correlation(series.values, profiles.planned);
  const double mirrored = sign * correlation(series.values, profiles.mirrored);
  if (mirrored > mirrored_correlation && mirrored > planned + mirrored_by)
    findings.push_back({Severity::error, "rotation_reversed_by_earth_rate", {}, segment.label});
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
    const double turns = std::abs(turning.turns);
    if (before == nullptr || samples.recording == nullptr || turns < least_turns ||
        std::abs(turns - std::round(turns)) > whole_turns)
      continue;
    const double step = 1.0 / sampling_rate(require_channel(evidence, *samples.recording, role_of(accelerometer_x)));
    const Vector3 up = (1.0 / norm(before->felt.specific_force)) * before->felt.specific_force;
    const double upright = std::abs(up[static_cast<std::size_t>(turning.axis)]);
    if (upright > upright_axis) judge_upright(evidence, segment, samples, scale, findings);
    // the turn may take a part of the time only: samples short enough for three times its mean speed
    if (upright > level_axis || step * over_mean_speed * turns * two_pi / turning.seconds > longest_step) continue;
    const Swings swings[2] = {swings_of(evidence, samples, segments, accelerometer_x),
                              swings_of(evidence, samples, segments, accelerometer_y)};
    judge_level(turning, segment, up, swings, findings);
  }
  return findings;
}

}  // namespace tumble::rlg_north_finder
