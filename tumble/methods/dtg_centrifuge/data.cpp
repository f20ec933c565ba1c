#include "tumble/methods/dtg_centrifuge/data.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "tumble/clocks/clock.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/methods/dtg_centrifuge/turning.hpp"
#include "tumble/units/error.hpp"

namespace tumble::dtg_centrifuge {
namespace {

using Severity = Finding::Severity;

/// Least net rate that has a direction [deg/s], and cosine of its angle to the spin axis from which on that is upright:
/// 8 deg, more than any error of a mount.
constexpr double least_net_rate = 0.1, least_upright = 0.99;

constexpr const char* signal_roles[] = {"gyro", "gyro_y", "reference_gyro"};

bool usable(const Channel& channel) {
  return channel.values.size() > 1 && std::ranges::any_of(channel.values, [](double v) { return std::isfinite(v); });
}

/// Sampling interval of a channel [s]: that of its clock, so that lost samples do not change it; and what is wrong with
/// the channel as a whole.
/// An angle may be at rest throughout, in the file of a segment at rest.
double examined(const Channel& channel, const std::string& file, Problems& problems) {
  const std::string name = fmt::format("{}channel '{}'", file.empty() ? "" : file + ": ", channel.name);
  if (!usable(channel) || !(mean_rate(channel) > 0.0) || !std::isfinite(mean_rate(channel))) {
    problems.push_back(say("{} holds no samples with times", Name{name}));
    return 0.0;
  }
  double least = std::numeric_limits<double>::infinity(), most = -least;
  bool infinite = false;
  for (const double v : channel.values) {
    infinite = infinite || std::isinf(v);
    least = v < least ? v : least;
    most = v > most ? v : most;
  }
  if (infinite) problems.push_back(say("{} holds an infinite value", Name{name}));
  if (least == most && channel.kind != QuantityKind::angle)
    problems.push_back(say("{} holds the same value throughout", Name{name}));
  if (channel.timeline.uniform()) return 1.0 / channel.timeline.rate;
  const Clock clock = clock_of(channel);
  if (clock.backward > 0) problems.push_back(say("{} has time stamps that run backwards", Name{name}));
  return 1.0 / (clock.rate > 0.0 ? clock.rate : mean_rate(channel));
}

Channels channels_of(const Evidence& evidence, std::size_t r, Problems& problems) {
  const Recording& recording = evidence.recordings[r];
  Channels out;
  for (const Signal s : {gyro, gyro_y, reference})
    out.signal[s] = s == gyro_y ? channel_for(evidence, recording, signal_roles[s])
                                : &require_channel(evidence, recording, signal_roles[s]);
  out.arm = channel_for(evidence, recording, "arm_angle");
  out.table = channel_for(evidence, recording, "table_angle");
  const std::array all{out.signal[gyro], out.signal[gyro_y], out.signal[reference], out.arm, out.table};
  const std::array steps{&out.step[gyro], &out.step[gyro_y], &out.step[reference], &out.arm_step, &out.table_step};
  std::array<Problems, all.size()> faults;
  parallel_for(all.size(), [&](std::size_t k) {
    if (all[k] != nullptr) *steps[k] = examined(*all[k], recording.origin.file, faults[k]);
  });
  for (const auto& some : faults) problems.insert(problems.end(), some.begin(), some.end());
  return out;
}

void require(const Plan& plan, Problems& problems) {
  const auto complain = [&](const char* what) { problems.push_back(in_file(plan.file, what)); };
  const auto axes = plan.rig_kind.empty() ? std::vector<Axis>{} : find_rig(plan.rig_kind).axes();
  const auto has = [&](const char* name) { return std::ranges::any_of(axes, [&](auto& a) { return a.name == name; }); };
  if (!has("arm") || !has("table") || !plan.rig.has("radius"))
    complain("the plan needs [rig] kind = \"counter_rotating_centrifuge\" with its radius");
  if (plan.schedule.empty()) complain("the plan needs [[schedule]] segments that turn arm and table");
  if (!plan.site) complain("the plan needs [site] latitude = \"34.25 deg\" or the like: the instruments feel gravity");
}

double rate_of(const Segment& segment, const char* axis) {
  const auto motion = segment.axes.find(axis);
  return motion != segment.axes.end() && motion->second.kind == Motion::Kind::rate ? motion->second.value : 0.0;
}

Felt felt_at(const Reference& reference, double time) {
  Felt felt;
  reference.felt(time, 0.0, std::span(&felt, 1));
  return felt;
}

double spin_up_in(const Felt& felt) { return felt.specific_force.z < 0.0 ? -1.0 : 1.0; }

/// The net rate is along the vertical: the spin axis has to be so as well.
void require_upright(const Spin& spin, const Felt& felt) {
  const double along = std::abs(felt.rate.z) / std::max(norm(felt.rate), si(least_net_rate, "deg/s"));
  if (along > least_upright || norm(felt.rate) < si(least_net_rate, "deg/s")) return;
  throw Error(Error::Kind::bad_input,
              say("{}: by the plan's mount the gyro's Z axis is {:.3g} deg off the vertical, but the spin axis "
                  "must lie along the table's: mount_roll = {{hold = \"0 deg\"}} or \"180 deg\"",
                  Name{where_of(spin)}, std::acos(along) / si(1.0, "deg")));
}

/// From the end of settling to the end of the segment, as far as there are data.
void set_times(const MarkedSegment& marked, const Channels& channels, const PowerUp& power_up, double settling,
               Spin& spin) {
  const Channel& channel = *channels.signal[gyro];
  const double step = channels.step[gyro];
  spin.power_on = marked.begin - power_up.begins[spin.segment];
  spin.begin = std::max(spin.power_on + settled_at(power_up, spin.segment) + settling, channel.time(0));
  spin.end = std::min(
      {spin.power_on + power_up.begins[spin.segment + 1], channel.time(channel.values.size() - 1) + step, marked.end});
}

/// The power-ups of a plan among those of the test, and where the segments of its schedule stand in them.
struct PlanPowerUps {
  std::vector<std::pair<std::size_t, std::size_t>> places;  ///< power-up and segment
};

PlanPowerUps add_power_ups(const Plan& plan, double rate, std::size_t number, Test& test) {
  PlanPowerUps out;
  for (auto& power_up : power_ups_of(plan, rate)) {
    power_up.plan_number = number;
    for (std::size_t s = 0; s < power_up.rig.segments.size(); ++s) out.places.emplace_back(test.power_ups.size(), s);
    test.power_ups.push_back(std::move(power_up));
  }
  return out;
}

void add_level(Spin spin, Test& test) {
  if (spin.end <= spin.begin) {
    test.findings.push_back({Severity::warning, "level_without_samples", {}, where_of(spin)});
    return;
  }
  const double middle = 0.5 * (spin.begin + spin.end) - spin.power_on;
  const Felt felt = felt_at(test.power_ups[spin.power_up].reference, middle);
  spin.spin_up = spin_up_in(felt);
  require_upright(spin, felt);
  test.levels.push_back(std::move(spin));
}

void add_marks(const std::vector<MarkedSegment>& marks, const PlanPowerUps& plan, double settling, Test& test) {
  std::map<std::size_t, Spin> rest;
  std::set<std::size_t> begun;
  for (const auto& marked : marks) {
    test.starts = std::max(test.starts, marked.start + 1);
    if (marked.planned == nullptr) {
      test.findings.push_back(unused_segment(marked.label, marked.run, {"not_in_schedule"}));
      continue;
    }
    Spin spin{.recording = marked.recording, .start = marked.start, .run = marked.run, .label = marked.label};
    std::tie(spin.power_up, spin.segment) = plan.places[marked.index];
    spin.arm_rate = rate_of(*marked.planned, "arm");
    spin.table_rate = rate_of(*marked.planned, "table");
    set_times(marked, test.channels[marked.recording], test.power_ups[spin.power_up], settling, spin);
    if (spin.arm_rate == 0.0) {
      if (!begun.contains(spin.start) && spin.table_rate == 0.0 && spin.end > spin.begin) rest[spin.start] = spin;
      continue;
    }
    begun.insert(spin.start);
    add_level(std::move(spin), test);
  }
  for (const auto& [start, one] : rest) test.rests.push_back(one);
}

/// Runs of which something was recorded, by plan, and the segments that were.
struct Recorded {
  std::set<std::pair<const Plan*, int>> runs;
  std::set<const Segment*> segments;

  Recorded(const Evidence& evidence, const std::vector<std::vector<MarkedSegment>>& marks) {
    for (std::size_t r = 0; r < marks.size(); ++r)
      for (const auto& marked : marks[r]) {
        if (marked.planned == nullptr) continue;
        runs.emplace(&plan_of(evidence, r), marked.planned->run);
        segments.insert(marked.planned);
      }
  }
};

/// A warning for each run of which levels are missing.
void warn_of_missing(const Recorded& recorded, Findings& findings) {
  for (const auto& [plan, run] : recorded.runs) {
    std::vector<std::string> labels;
    for (const Segment& segment : plan->schedule)
      if (segment.run == run && rate_of(segment, "arm") != 0.0 && !recorded.segments.contains(&segment))
        labels.push_back(segment.label);
    if (labels.empty()) continue;
    findings.push_back(segments_not_recorded(run, labels));
  }
}

/// The levels that the plans have in the runs of which something was recorded: they count the levels.
void add_planned(const Recorded& recorded, Test& test) {
  for (std::size_t p = 0; p < test.power_ups.size(); ++p) {
    const PowerUp& power_up = test.power_ups[p];
    for (std::size_t s = 0; s < power_up.rig.segments.size(); ++s) {
      const Segment& segment = power_up.rig.segments[s];
      Spin spin{.run = segment.run, .label = segment.label, .power_up = p, .segment = s};
      spin.arm_rate = rate_of(segment, "arm");
      spin.table_rate = rate_of(segment, "table");
      if (spin.arm_rate == 0.0 || !recorded.runs.contains({power_up.plan, segment.run})) continue;
      spin.spin_up = spin_up_in(felt_at(power_up.reference, power_up.begins[s] + 0.5 * segment.duration));
      test.planned.push_back(std::move(spin));
    }
  }
}

void check_encoders(Test& test) {
  std::size_t with = 0, some = 0;
  for (auto& channels : test.channels) {
    with += channels.arm != nullptr && channels.table != nullptr;
    some += channels.arm != nullptr || channels.table != nullptr;
  }
  test.encoders = with == test.channels.size();
  if (test.encoders) return;
  for (auto& channels : test.channels) channels.arm = channels.table = nullptr;
  test.findings.push_back({Severity::warning, some == 0 ? "angles_not_recorded" : "angles_partly_recorded", {}});
}

}  // namespace

bool one_clock(const Channel& a, const Channel& b) {
  if (a.values.size() != b.values.size()) return false;
  if (a.timeline.uniform() && b.timeline.uniform())
    return a.timeline.start == b.timeline.start && a.timeline.rate == b.timeline.rate;
  return a.timeline.stamps == b.timeline.stamps;
}

std::string where_of(const Spin& spin) { return fmt::format("run {}, {}", spin.run, spin.label); }

Test test_of(const Evidence& evidence) {
  Test test;
  Problems problems;
  std::set<const Plan*> plans{&evidence.plan};
  for (std::size_t r = 0; r < evidence.recordings.size(); ++r) plans.insert(&plan_of(evidence, r));
  for (std::size_t r = 0; r < evidence.recordings.size(); ++r)
    if (plans.erase(&plan_of(evidence, r)) > 0) require(plan_of(evidence, r), problems);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "there is no recording");
  for (std::size_t r = 0; r < evidence.recordings.size(); ++r) {
    test.channels.push_back(channels_of(evidence, r, problems));
    if (evidence.recordings[r].marks.empty())
      problems.push_back("the recording does not say when its segments begin, and the plan has no schedule");
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
  check_encoders(test);
  std::map<const Plan*, PlanPowerUps> power_ups;
  const auto marks = marked_segments(evidence);
  for (std::size_t r = 0; r < evidence.recordings.size(); ++r) {
    const Plan& plan = plan_of(evidence, r);
    if (!power_ups.contains(&plan)) {
      const std::size_t number = power_ups.size();
      power_ups[&plan] = add_power_ups(plan, 1.0 / test.channels[r].step[gyro], number, test);
    }
    add_marks(marks[r], power_ups[&plan], evidence.plan.settings.number("settling"), test);
  }
  const Recorded recorded(evidence, marks);
  add_planned(recorded, test);
  warn_of_missing(recorded, test.findings);
  if (test.encoders) cut_to_even_turning(test);
  if (!test.levels.empty()) return test;
  for (const auto& finding : test.findings) problems.push_back(said_of(finding));
  problems.push_back(
      "no segment of the recordings turns the arm: levels are segments with arm = {rate = \"...\"} and table = "
      "{rate = \"-...\"} in the schedule");
  throw Error(Error::Kind::bad_data, problems);
}

}  // namespace tumble::dtg_centrifuge
