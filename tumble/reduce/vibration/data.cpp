#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <span>
#include <tuple>

#include "tumble/clocks/clock.hpp"
#include "tumble/clocks/stamp_slack.hpp"
#include "tumble/core/attempt.hpp"
#include "tumble/reduce/stretches.hpp"
#include "tumble/reduce/vibration/faults.hpp"
#include "tumble/reduce/vibration/scale.hpp"
#include "tumble/reduce/vibration/vibration.hpp"
#include "tumble/reduce/vibration/windows.hpp"
#include "tumble/units/error.hpp"

namespace tumble::vibration {
namespace {

using Severity = Finding::Severity;
constexpr double end_slack = 0.01;       ///< [windows] by which the last window may end after the segment
constexpr double even_scatter = 1e-4;    ///< [windows] of the stamps: even windows
constexpr double integrated_from = 3.5;  ///< samples of the reference in a window, from which on they are integrated
constexpr double same_rate = 1e-3;       ///< [1] within which one sample of the reference belongs to each window

const std::string role = "accelerometer";
constexpr int least_windows = 16;  ///< of a segment

std::string unit_name(const std::string& channel) {
  const std::string tail = "." + role;
  if (channel.size() > tail.size() && channel.ends_with(tail)) return channel.substr(0, channel.size() - tail.size());
  return channel;
}

/// The accelerometers of a recording; Error::bad_data where there is none.
std::vector<const Channel*> units_in(const Evidence& evidence, const Recording& recording) {
  auto channels = channels_for(evidence, recording, role);
  if (channels.empty()) require_channel(evidence, recording, role);
  return channels;
}

bool vibrates(const Motion& motion) {
  return motion.kind == Motion::Kind::sine || motion.kind == Motion::Kind::sweep || motion.kind == Motion::Kind::random;
}

/// Motion of the fixture in a segment: of its first axis that vibrates.
Motion shake_of(const Segment& segment) {
  for (const auto& [axis, motion] : segment.axes)
    if (vibrates(motion)) return motion;
  return {};
}

/// The power-ups of a plan with nothing vibrating.
class StillPowerUps {
 public:
  explicit StillPowerUps(const Evidence& evidence) : evidence_(evidence) {}

  /// Specific force along the input axis in the middle of a segment; NaN: the plan has no rig.
  double rest(const MarkedSegment& marked, double window) {
    const Plan& plan = plan_of(evidence_, marked.recording);
    if (plan.rig_kind.empty()) return std::nan("");
    auto& forces = of_[{&plan, window}];
    if (forces.empty()) forces = forces_of(plan, window);
    return forces[marked.index];
  }

 private:
  static std::vector<double> forces_of(Plan plan, double window) {
    for (Segment& segment : plan.schedule)
      std::erase_if(segment.axes, [](const auto& axis) { return vibrates(axis.second); });
    std::vector<double> forces;
    Felt felt;
    for (const PowerUp& power_up : power_ups_of(plan, 1.0 / window))
      for (std::size_t s = 0; s < power_up.rig.segments.size(); ++s) {
        power_up.reference.felt(power_up.begins[s] + 0.5 * power_up.rig.segments[s].duration, window,
                                std::span(&felt, 1));
        forces.push_back(felt.specific_force.x);
      }
    return forces;
  }

  const Evidence& evidence_;
  std::map<std::pair<const Plan*, double>, std::vector<double>> of_;
};

/// When a segment begins in its run, by the schedule [s].
double planned_begin(const Plan& plan, const MarkedSegment& marked) {
  double begin = 0.0;
  for (std::size_t s = 0; s < marked.index; ++s)
    if (plan.schedule[s].run == marked.planned->run) begin += plan.schedule[s].duration;
  return begin;
}

std::size_t unit_index(const std::string& channel, Data& data) {
  const auto unit = std::ranges::find(data.units, channel, &UnitUnderTest::channel);
  if (unit != data.units.end()) return static_cast<std::size_t>(unit - data.units.begin());
  data.units.push_back({.name = unit_name(channel), .prefix = "", .channel = channel});
  return data.units.size() - 1;
}

/// Part of the channel between two marks, in values of the channel.
void cut(const Draft& draft, double begin, double end, const Settings& settings, Series& series, std::size_t& first) {
  const Windows& w = draft.windows;
  const double cycles = series.at_rest() || !(series.shake.frequency > 0.0) ? 0.0 : 2.0 / series.shake.frequency;
  const double from = begin + std::max(settings.number("settling"), cycles), slack = stamp_slack(from, w.window);
  const auto lower = std::ranges::lower_bound(w.begin, from - slack);
  first = static_cast<std::size_t>(lower - w.begin.begin());
  double length = 0.0;
  for (std::size_t i = first; i < w.begin.size() && w.begin[i] + w.length[i] <= end + end_slack * w.window; ++i) {
    series.time.push_back(w.begin[i] + 0.5 * w.length[i]);
    series.force.push_back(w.usable[i] ? draft.channel->values[i] : std::nan(""));
    length += w.usable[i] ? w.length[i] : w.window;
  }
  if (series.time.empty()) return;
  const double n = static_cast<double>(series.time.size());
  series.window = length / n;
  series.interval = w.window;
  const Reading reading = reading_of(*draft.channel);
  const bool instant =
      reading != Reading::pulses && reading != Reading::velocity && settings.word("samples") == "instant";
  series.averaging = instant ? 0.0 : series.window;
  if (instant)
    for (double& t : series.time) t -= 0.5 * w.window;
  series.begin = w.begin[first];
  series.end = w.begin[first + series.time.size() - 1] + w.length[first + series.time.size() - 1];
}

/// The test of all recordings, in work.
struct Test {
  const Evidence& evidence;
  std::vector<std::vector<MarkedSegment>> marks = marked_segments(evidence);
  StillPowerUps still{evidence};
  std::map<std::size_t, std::vector<Draft>> drafts = {};  ///< by unit
  Problems problems = {};
};

/// One marked segment of a unit, or a finding why it cannot be used.
void add_segment(Test& test, const MarkedSegment& marked, std::size_t unit, Draft& draft, Data& data) {
  Series series{.unit = unit,
                .recording = marked.recording,
                .run = marked.run,
                .planned_begin = planned_begin(plan_of(test.evidence, marked.recording), marked),
                .label = marked.label,
                .shake = shake_of(*marked.planned),
                .rest = test.still.rest(marked, draft.windows.window)};
  std::size_t first = 0;
  cut(draft, marked.begin, std::min(marked.end, marked.begin + marked.planned->duration), test.evidence.plan.settings,
      series, first);
  const auto windows = std::ranges::count_if(series.force, [](double v) { return !std::isnan(v); });
  if (series.time.empty() && marked.begin >= draft.channel->time(draft.channel->values.size() - 1)) {
    add_once({Severity::warning, "recording_ends_before_segment", {}, marked.label}, data.findings);
  } else if (windows < least_windows) {
    data.findings.push_back({Severity::warning,
                             "too_few_windows",
                             {{"windows", windows}, {"needed", least_windows}},
                             place_of(data, series)});
  } else {
    draft.series.push_back(data.series.size());
    draft.first.push_back(first);
    data.series.push_back(std::move(series));
  }
}

void add_segments(Test& test, std::size_t recording, std::size_t unit, Draft& draft, Data& data) {
  for (const auto& marked : test.marks[recording]) {
    if (marked.planned != nullptr)
      add_segment(test, marked, unit, draft, data);
    else if (unit == 0)
      data.findings.push_back({Severity::warning, "segment_not_planned", {}, marked.label});
  }
}

/// Counts that at rest follow the time between stamps are counts of windows of that length.
Windows windows_of(const Settings& settings, const std::vector<MarkedSegment>& marks, const Channel& channel,
                   Data& data) {
  Windows even = even_windows(channel, data.findings);
  const std::string& how = settings.word("windows");
  if (channel.timeline.uniform() || how == "even") return even;
  if (how == "stamps") return stamped_windows(channel, even);
  const Reading reading = reading_of(channel);
  if (reading != Reading::pulses && reading != Reading::velocity) return even;
  if (even.scatter < even_scatter * even.window) return even;
  std::vector<std::pair<double, double>> rests;
  for (const auto& marked : marks)
    if (marked.planned != nullptr && shake_of(*marked.planned).kind == Motion::Kind::hold)
      rests.emplace_back(marked.begin, marked.end);
  const double slope = slope_with_interval(channel, rests);
  const std::vector<FindingValue> scatter{{"scatter", even.scatter / even.window, "%"}};
  if (slope > 0.5) {
    data.findings.push_back({Severity::warning, "windows_of_unequal_length", scatter, channel.name});
    return stamped_windows(channel, even);
  }
  data.findings.push_back(
      {Severity::info, rests.empty() ? "stamps_scatter_without_rest" : "stamps_scatter", scatter, channel.name});
  return even;
}

/// The reference, whose clock runs at `rate`, over the windows of a series, or a finding why not.
void add_reference(const Evidence& evidence, const Channel& reference, double rate, const Draft& draft,
                   std::size_t first, Series& series, Data& data) {
  const double per_window = rate * series.interval;
  series.reference.assign(series.time.size(), std::nan(""));
  if (per_window > integrated_from) {
    data.reference_integrated = true;
    const double slack = stamp_slack(series.end, 1.0 / rate);
    std::size_t i = index_at(reference, series.begin - slack);
    for (std::size_t j = 0; j < series.time.size(); ++j) {
      const double begin = series.time[j] - 0.5 * draft.windows.length[first + j],
                   end = begin + draft.windows.length[first + j];
      double sum = 0.0, n = 0.0;
      while (i < reference.values.size() && reference.time(i) < begin - slack) ++i;
      for (std::size_t k = i; k < reference.values.size() && reference.time(k) < end - slack; ++k, ++n)
        sum += reference.values[k];
      if (n > 0.0) series.reference[j] = sum / n;
    }
    return;
  }
  if (std::abs(per_window - 1.0) > same_rate) {
    series.reference.clear();
    add_once({Severity::warning,
              "reference_rate_unsuitable",
              {{"rate", rate, "Hz"}, {"window", series.interval, "s"}},
              reference.name},
             data.findings);
    return;
  }
  data.reference_integrated = evidence.plan.settings.word("reference_is") == "window";
  std::size_t i = index_at(reference, series.begin - 0.5 * series.interval);
  for (std::size_t j = 0; j < series.time.size() && i < reference.values.size(); ++j) {
    const double stamp = series.time[j] - 0.5 * draft.windows.length[first + j];
    while (i + 1 < reference.values.size() && reference.time(i) < stamp - 0.5 * series.interval) ++i;
    if (std::abs(reference.time(i) - stamp) < 0.5 * series.interval) series.reference[j] = reference.values[i];
  }
}

/// Counts and increments of velocity per second of window.
void per_second(const Draft& draft, Data& data) {
  const Reading reading = reading_of(*draft.channel);
  if (reading != Reading::pulses && reading != Reading::velocity) return;
  for (std::size_t k = 0; k < draft.series.size(); ++k) {
    Series& series = data.series[draft.series[k]];
    for (std::size_t j = 0; j < series.force.size(); ++j) series.force[j] /= draft.windows.length[draft.first[k] + j];
  }
}

/// The first instrument is called by its serial where others stand beside it.
void name_units(const Evidence& evidence, Data& data, Problems& problems) {
  const Settings& settings = evidence.plan.settings;
  const std::string& serial = evidence.plan.instrument_serial;
  const bool word =
      !serial.empty() && std::ranges::all_of(serial, [](unsigned char c) { return std::isalnum(c) || c == '_'; });
  for (auto& unit : data.units)
    if (unit.name == role && data.units.size() > 1 && word &&
        std::ranges::find(data.units, serial, &UnitUnderTest::name) == data.units.end())
      unit.name = serial;
  for (auto& unit : data.units) unit.prefix = data.units.size() > 1 ? unit.name + "." : "";
  std::vector<std::string> names;
  for (const auto& unit : data.units) names.push_back(unit.name);
  for (const auto& named : named_in_scale(settings))
    if (std::ranges::find(names, named) == names.end())
      problems.push_back(say("[settings] scale_factor names a unit '{}' that is not recorded{} (units: {})", named,
                             did_you_mean(named, names), fmt::join(names, ", ")));
}

/// Every scale factor that is given can be read, and is given once.
void check_scales(const Evidence& evidence, const Data& data, Problems& problems) {
  const Settings& settings = evidence.plan.settings;
  for (const auto& twice : twice_in_scale(settings))
    problems.push_back(say("[settings] scale_factor has {} twice",
                           twice.empty() ? Sentence("a value for all units") : say("unit '{}'", Name{twice})));
  for (const auto& recording : evidence.recordings)
    for (const Channel* channel : units_in(evidence, recording)) {
      const auto unit = std::ranges::find(data.units, channel->name, &UnitUnderTest::channel);
      try {
        given_scale(settings, *unit, *channel);
      } catch (const Error& error) {
        if (error.kind != Error::Kind::bad_input) continue;  // of the channel's unit: reported with the data
        for (const auto& problem : error.problems)
          if (std::ranges::find(problems, problem) == problems.end()) problems.push_back(problem);
      }
    }
}

/// Units by name, with the settings that name them checked.
void add_units(const Evidence& evidence, Data& data) {
  Problems problems;
  for (const auto& recording : evidence.recordings)
    for (const Channel* channel : units_in(evidence, recording)) unit_index(channel->name, data);
  name_units(evidence, data, problems);
  check_scales(evidence, data, problems);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

/// Series of one unit in one recording, with the reference over their windows.
void add_channel(Test& test, std::size_t recording, const Channel& channel, Data& data) {
  const Evidence& evidence = test.evidence;
  reading_of(channel);
  const std::size_t unit = unit_index(channel.name, data);
  Draft draft{&channel, windows_of(evidence.plan.settings, test.marks[recording], channel, data), {}, {}};
  add_segments(test, recording, unit, draft, data);
  refuse_totals(draft, data, test.problems);
  unwrap_counts(evidence.plan.settings, draft, data, test.problems);
  per_second(draft, data);
  if (const Channel* reference = channel_for(evidence, evidence.recordings[recording], "reference")) {
    const double rate = clock_of(*reference).rate;
    for (std::size_t k = 0; k < draft.series.size(); ++k)
      add_reference(evidence, *reference, rate, draft, draft.first[k], data.series[draft.series[k]], data);
  }
  test.drafts[unit].push_back(std::move(draft));
}

void add_recordings(Test& test, Data& data) {
  for (std::size_t r = 0; r < test.evidence.recordings.size(); ++r) {
    const Recording& recording = test.evidence.recordings[r];
    if (recording.marks.empty())
      throw Error(Error::Kind::bad_data,
                  "the recording does not say when its segments begin, and the plan has no schedule");
    for (const Channel* channel : units_in(test.evidence, recording))
      attempt(test.problems, [&] {
        add_channel(test, r, *channel, data);
        return 0;
      });
  }
  if (!test.problems.empty()) throw Error(Error::Kind::bad_data, test.problems);
}

void set_scales(Test& test, Data& data) {
  for (const auto& [unit, of_unit] : test.drafts)
    if (std::ranges::find(data.series, unit, &Series::unit) != data.series.end())
      attempt(test.problems, [&] {
        set_scale(test.evidence.plan.settings, *of_unit.front().channel, unit, data);
        return 0;
      });
  if (!test.problems.empty()) throw Error(Error::Kind::bad_input, test.problems);
}

void require_vibration(const Data& data) {
  if (std::ranges::any_of(data.series, [](const Series& s) { return !s.at_rest(); })) return;
  Problems problems;
  for (const auto& finding : data.findings)
    if (finding.severity != Severity::info)
      problems.push_back(
          within(finding.where.empty() ? Sentence() : say("{}", Name{finding.where}), Problem(said_of(finding))));
  problems.emplace_back("no unit has a segment in which it vibrates");
  throw Error(Error::Kind::bad_data, problems);
}

}  // namespace

Data data_of(const Evidence& evidence) {
  const Settings& settings = evidence.plan.settings;
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "a vibration test needs at least one recording");
  Data data;
  if (settings.has("range")) data.range = settings.number("range");
  add_units(evidence, data);
  Test test{evidence};
  add_recordings(test, data);
  cut_to_vibrations(data);
  drop_dead(data);
  drop_moving(test.drafts, data);
  set_scales(test, data);
  refuse_sizes(data, test.problems);
  drop_still(data);
  check_ramps(data);
  if (!test.problems.empty()) throw Error(Error::Kind::bad_data, test.problems);
  compare_rests(settings, data);
  set_power_ups(data);
  std::ranges::stable_sort(data.series, [](const Series& a, const Series& b) {
    return std::tie(a.unit, a.power_up, a.begin) < std::tie(b.unit, b.power_up, b.begin);
  });
  require_vibration(data);
  return data;
}

}  // namespace tumble::vibration
