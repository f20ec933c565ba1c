#include "tumble/methods/dtg_centrifuge/data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "tumble/core/clock.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/sim/power_up.hpp"
#include "tumble/units/error.hpp"

namespace tumble::dtg_centrifuge {
namespace {

using Severity = Finding::Severity;

constexpr const char* roles[] = {"gyro", "gyro_y", "reference_gyro"};

bool usable(const Channel& channel) {
  return channel.values.size() > 1 && std::ranges::any_of(channel.values, [](double v) { return std::isfinite(v); });
}

/// What is wrong with a channel as a whole.
void complain_of(const Channel& channel, const std::string& file, std::vector<std::string>& problems) {
  const std::string name = fmt::format("{}channel '{}'", file.empty() ? "" : file + ": ", channel.name);
  if (!usable(channel) || !(mean_rate(channel) > 0.0) || !std::isfinite(mean_rate(channel))) {
    problems.push_back(name + " holds no samples with times");
    return;
  }
  double least = std::numeric_limits<double>::infinity(), most = -least;
  bool infinite = false;
  for (const double v : channel.values) {
    infinite = infinite || std::isinf(v);
    least = v < least ? v : least;
    most = v > most ? v : most;
  }
  if (infinite) problems.push_back(name + " holds an infinite value");
  if (least == most) problems.push_back(name + " holds the same value throughout");
  if (!channel.timeline.uniform() && clock_of(channel).backward > 0)
    problems.push_back(name + " has time stamps that run backwards");
}

Channels channels_of(const Evidence& evidence, std::size_t r, std::vector<std::string>& problems) {
  const Recording& recording = evidence.recordings[r];
  Channels out;
  for (const Signal s : {gyro, gyro_y, reference})
    out.signal[s] =
        s == gyro_y ? channel_for(evidence, recording, roles[s]) : &require_channel(evidence, recording, roles[s]);
  out.arm = channel_for(evidence, recording, "arm_angle");
  out.table = channel_for(evidence, recording, "table_angle");
  const std::array all{out.signal[gyro], out.signal[gyro_y], out.signal[reference], out.arm, out.table};
  std::array<std::vector<std::string>, all.size()> found;
  parallel_for(all.size(), [&](std::size_t k) {
    if (all[k] != nullptr) complain_of(*all[k], recording.origin.file, found[k]);
  });
  for (const auto& some : found) problems.insert(problems.end(), some.begin(), some.end());
  return out;
}

void require(const Plan& plan, std::vector<std::string>& problems) {
  const std::string where = plan.file.empty() ? "" : plan.file + ": ";
  const auto axes = plan.rig_kind.empty() ? std::vector<Axis>{} : find_rig(plan.rig_kind).axes();
  const auto has = [&](const char* name) { return std::ranges::any_of(axes, [&](auto& a) { return a.name == name; }); };
  if (!has("arm") || !has("table") || !plan.rig.has("radius"))
    problems.push_back(where + "the plan needs [rig] kind = \"counter_rotating_centrifuge\" with its radius");
  if (plan.schedule.empty()) problems.push_back(where + "the plan needs [[schedule]] segments that turn arm and table");
  if (!plan.site)
    problems.push_back(where +
                       "the plan needs [site] latitude = \"34.25 deg\" or the like: gravity is part of what "
                       "the instruments feel");
}

std::size_t add_rigs(const Plan& plan, double rate, Test& test) {
  const std::size_t first = test.rigs.size();
  for (auto& one : power_ups(plan.schedule, rate)) {
    RigPowerUp rig{&plan, {std::move(one.segments), plan.rig, plan.site, rate, {}, RandomStream(0)}, {}, {0.0}};
    for (const auto& segment : rig.run.segments) rig.begins.push_back(rig.begins.back() + segment.duration);
    rig.reference = find_rig(plan.rig_kind).reference(rig.run);
    test.rigs.push_back(std::move(rig));
  }
  return first;
}

double rate_of(const Segment& segment, const char* axis) {
  const auto found = segment.axes.find(axis);
  return found != segment.axes.end() && found->second.kind == Motion::Kind::rate ? found->second.value : 0.0;
}

/// The segment of the schedule that a mark stands for: of that run, else of any that names it so; a label that occurs
/// several times in a power-up is taken in order.
bool place(const Test& test, std::size_t first, const Mark& mark, std::set<std::pair<std::size_t, std::size_t>>& taken,
           Stretch& stretch) {
  for (const bool same_run : {true, false})
    for (std::size_t u = first; u < test.rigs.size(); ++u) {
      const auto& segments = test.rigs[u].run.segments;
      for (std::size_t s = 0; s < segments.size(); ++s) {
        if (segments[s].label != mark.label || (same_run && segments[s].run != mark.run)) continue;
        if (same_run && !taken.insert({u, s}).second) continue;
        stretch.rig = u;
        stretch.segment = s;
        return true;
      }
    }
  return false;
}

Felt felt_at(const Reference& reference, double time) {
  Felt felt;
  reference.felt(time, 0.0, std::span(&felt, 1));
  return felt;
}

/// The net rate is along the vertical: the spin axis has to be so as well.
void require_upright(const Stretch& stretch, const Felt& felt) {
  const double along = std::abs(felt.rate.z) / std::max(norm(felt.rate), si(0.1, "deg/s"));
  if (along > 0.99 || norm(felt.rate) < si(0.1, "deg/s")) return;
  throw Error(
      Error::Kind::bad_input,
      fmt::format("{}: the gyro's Z axis stands {:.3g} deg off the vertical by the plan's mount, but the spin axis "
                  "has to lie along the table's: mount_roll = {{hold = \"0 deg\"}} or \"180 deg\"",
                  where_of(stretch), std::acos(along) / si(1.0, "deg")));
}

/// From the end of settling to the end of the segment, as far as there are data.
void set_times(const Recording& recording, std::size_t m, const Channel& channel, const RigPowerUp& rig,
               double settling, Stretch& stretch) {
  const Mark& mark = recording.marks[m];
  const double segment = rig.begins[stretch.segment];
  stretch.power_on = mark.begin - segment;
  const auto& settled = rig.reference.settled;
  const double from = stretch.segment < settled.size() ? std::max(segment, settled[stretch.segment]) : segment;
  const double step = 1.0 / mean_rate(channel);
  stretch.begin = std::max(stretch.power_on + from + settling, channel.time(0));
  stretch.end =
      std::min(stretch.power_on + rig.begins[stretch.segment + 1], channel.time(channel.values.size() - 1) + step);
  if (m + 1 < recording.marks.size()) stretch.end = std::min(stretch.end, recording.marks[m + 1].begin);
}

/// One power-up may lie in several files, a segment each; but the same segment of the same run in another file is
/// another power-up.
class PowerUps {
 public:
  std::size_t number(const Plan& plan, const Recording& recording, int run) {
    std::set<std::string> labels;
    for (const auto& mark : recording.marks)
      if (mark.run == run) labels.insert(mark.label);
    auto& known = of_[{&plan, run}];
    auto one = std::ranges::find_if(known, [&](const Known& k) {
      return std::ranges::none_of(labels, [&](const std::string& label) { return k.labels.contains(label); });
    });
    if (one == known.end()) one = known.insert(known.end(), {count_++, {}});
    one->labels.merge(labels);
    return one->number;
  }
  std::size_t count() const { return count_; }

 private:
  struct Known {
    std::size_t number;
    std::set<std::string> labels;
  };
  std::map<std::pair<const Plan*, int>, std::vector<Known>> of_;
  std::size_t count_ = 0;
};

void add_marks(const Evidence& evidence, std::size_t r, std::size_t first_rig, double settling, PowerUps& power_ups,
               Test& test) {
  const Recording& recording = evidence.recordings[r];
  std::map<int, std::size_t> numbers;
  for (const auto& mark : recording.marks)
    if (!numbers.contains(mark.run)) numbers[mark.run] = power_ups.number(plan_of(evidence, r), recording, mark.run);
  std::set<std::pair<std::size_t, std::size_t>> taken;
  std::map<std::size_t, Stretch> rest;
  std::set<std::size_t> begun;
  for (std::size_t m = 0; m < recording.marks.size(); ++m) {
    const Mark& mark = recording.marks[m];
    Stretch stretch{.recording = r, .run = mark.run, .label = mark.label};
    if (!place(test, first_rig, mark, taken, stretch)) {
      test.findings.push_back(
          {Severity::warning,
           fmt::format("segment '{}' is not used: the schedule has no segment of that name", mark.label),
           fmt::format("run {}", mark.run)});
      continue;
    }
    const RigPowerUp& rig = test.rigs[stretch.rig];
    const Segment& segment = rig.run.segments[stretch.segment];
    stretch.arm_rate = rate_of(segment, "arm");
    stretch.table_rate = rate_of(segment, "table");
    stretch.power_up = numbers[mark.run];
    set_times(recording, m, *test.channels[r].signal[gyro], rig, settling, stretch);
    if (stretch.arm_rate == 0.0) {
      if (!begun.contains(stretch.power_up) && stretch.table_rate == 0.0 && stretch.end > stretch.begin)
        rest[stretch.power_up] = stretch;
      continue;
    }
    begun.insert(stretch.power_up);
    if (stretch.end <= stretch.begin) {
      test.findings.push_back(
          {Severity::warning, "the level is not used: no sample is left after settling", where_of(stretch)});
      continue;
    }
    const double middle = 0.5 * (stretch.begin + stretch.end) - stretch.power_on;
    const Felt felt = felt_at(rig.reference, middle);
    stretch.spin_up = felt.specific_force.z < 0.0 ? -1.0 : 1.0;
    require_upright(stretch, felt);
    test.levels.push_back(stretch);
  }
  for (const auto& [u, one] : rest) test.rests.push_back(one);
}

void check_encoders(const Evidence& evidence, Test& test) {
  std::size_t with = 0, some = 0;
  for (auto& channels : test.channels) {
    with += channels.arm != nullptr && channels.table != nullptr;
    some += channels.arm != nullptr || channels.table != nullptr;
  }
  test.encoders = with == test.channels.size();
  if (test.encoders) return;
  for (auto& channels : test.channels) channels.arm = channels.table = nullptr;
  test.findings.push_back(
      {Severity::warning,
       std::string(some == 0 ? "no angles of arm and table are recorded" : "not every recording has both angles") +
           (evidence.recordings.empty() ? ""
                                        : ": the rates are taken from the lines in the data, and the direction "
                                          "of the sensitive term is unknown: record arm_angle and table_angle"),
       ""});
}

}  // namespace

std::string where_of(const Stretch& stretch) { return fmt::format("run {}, {}", stretch.run, stretch.label); }

Test test_of(const Evidence& evidence) {
  Test test;
  std::vector<std::string> problems;
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
  check_encoders(evidence, test);
  std::map<const Plan*, std::size_t> first;
  PowerUps power_ups;
  for (std::size_t r = 0; r < evidence.recordings.size(); ++r) {
    const Plan& plan = plan_of(evidence, r);
    if (!first.contains(&plan)) first[&plan] = add_rigs(plan, mean_rate(*test.channels[r].signal[gyro]), test);
    add_marks(evidence, r, first[&plan], evidence.plan.settings.number("settling"), power_ups, test);
  }
  test.power_ups = power_ups.count();
  if (!test.levels.empty()) return test;
  for (const auto& finding : test.findings) problems.push_back(finding.message);
  problems.push_back(
      "no segment of the recordings turns the arm: levels are segments with arm = {rate = \"...\"} and table = "
      "{rate = \"-...\"} in the schedule");
  throw Error(Error::Kind::bad_data, problems);
}

}  // namespace tumble::dtg_centrifuge
