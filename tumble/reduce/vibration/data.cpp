#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <span>
#include <tuple>

#include "tumble/core/attempt.hpp"
#include "tumble/core/clock.hpp"
#include "tumble/core/say.hpp"
#include "tumble/reduce/stretches.hpp"
#include "tumble/reduce/vibration/faults.hpp"
#include "tumble/reduce/vibration/scale.hpp"
#include "tumble/reduce/vibration/vibration.hpp"
#include "tumble/reduce/vibration/windows.hpp"
#include "tumble/units/error.hpp"

namespace tumble::vibration {
namespace {

using Severity = Finding::Severity;
const std::string role = "accelerometer";

/// What is said of several segments alike is said once.
void add_once(Finding finding, Findings& findings) {
  const auto same = [&](const Finding& f) { return f.message == finding.message && f.where == finding.where; };
  if (std::ranges::none_of(findings, same)) findings.push_back(std::move(finding));
}

std::string unit_name(const std::string& channel) {
  const std::string tail = "." + role;
  if (channel.size() > tail.size() && channel.ends_with(tail)) return channel.substr(0, channel.size() - tail.size());
  return channel;
}

/// The accelerometers of a recording; Error::bad_data where there is none.
std::vector<const Channel*> units_in(const Evidence& evidence, const Recording& recording) {
  auto found = channels_for(evidence, recording, role);
  if (found.empty()) require_channel(evidence, recording, role);
  return found;
}

bool vibrates(const Motion& motion) {
  return motion.kind == Motion::Kind::sine || motion.kind == Motion::Kind::sweep || motion.kind == Motion::Kind::random;
}

/// What the fixture does in a segment: its first axis that vibrates.
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
  const auto found = std::ranges::find(data.units, channel, &UnitUnderTest::channel);
  if (found != data.units.end()) return static_cast<std::size_t>(found - data.units.begin());
  data.units.push_back({.name = unit_name(channel), .prefix = "", .channel = channel});
  return data.units.size() - 1;
}

/// Part of the channel between two marks, in values of the channel.
void cut(const Draft& draft, double begin, double end, const Settings& settings, Series& series, std::size_t& first) {
  const Windows& w = draft.windows;
  const double cycles = series.at_rest() || !(series.shake.frequency > 0.0) ? 0.0 : 2.0 / series.shake.frequency;
  const double from = begin + std::max(settings.number("settling"), cycles), slack = 1e-6 * w.window;
  const auto lower = std::ranges::lower_bound(w.begin, from - slack);
  first = static_cast<std::size_t>(lower - w.begin.begin());
  double length = 0.0;
  for (std::size_t i = first; i < w.begin.size() && w.begin[i] + w.length[i] <= end + 0.01 * w.window; ++i) {
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

/// What all recordings share.
struct Test {
  const Evidence& evidence;
  std::vector<std::vector<MarkedSegment>> marks = marked_segments(evidence);
  StillPowerUps still{evidence};
};

void add_segments(Test& test, std::size_t r, std::size_t unit, Draft& draft, Data& data) {
  for (const auto& marked : test.marks[r]) {
    if (marked.planned == nullptr) {
      if (unit == 0)
        data.findings.push_back(
            {Severity::warning, "left out: the schedule has no segment of that name", marked.label});
      continue;
    }
    Series series{.unit = unit,
                  .recording = r,
                  .run = marked.run,
                  .planned_begin = planned_begin(plan_of(test.evidence, r), marked),
                  .label = marked.label,
                  .shake = shake_of(*marked.planned),
                  .rest = test.still.rest(marked, draft.windows.window)};
    std::size_t first = 0;
    cut(draft, marked.begin, std::min(marked.end, marked.begin + marked.planned->duration), test.evidence.plan.settings,
        series, first);
    const auto there = std::ranges::count_if(series.force, [](double v) { return !std::isnan(v); });
    if (series.time.empty() && marked.begin >= draft.channel->time(draft.channel->values.size() - 1)) {
      add_once({Severity::warning, "left out: the recording ends before it begins", marked.label}, data.findings);
      continue;
    }
    if (there < 16) {
      data.findings.push_back({Severity::warning,
                               fmt::format("left out: {} behind the settling time, 16 are needed",
                                           say_count(static_cast<std::size_t>(there), "window")),
                               data.units[unit].prefix + marked.label});
      continue;
    }
    draft.series.push_back(data.series.size());
    draft.first.push_back(first);
    data.series.push_back(std::move(series));
  }
}

/// At rest, counts that go with the time between stamps are those of windows that long.
Windows windows_of(const Settings& settings, const std::vector<MarkedSegment>& marks, const Channel& channel,
                   Data& data) {
  Windows even = even_windows(channel, data.findings);
  const std::string& how = settings.word("windows");
  if (channel.timeline.uniform() || how == "even") return even;
  if (how == "stamps") return stamped_windows(channel, even);
  const Reading reading = reading_of(channel);
  if (reading != Reading::pulses && reading != Reading::velocity) return even;
  if (even.scatter < 1e-4 * even.window) return even;
  std::vector<std::pair<double, double>> rests;
  for (const auto& marked : marks)
    if (marked.planned != nullptr && shake_of(*marked.planned).kind == Motion::Kind::hold)
      rests.emplace_back(marked.begin, marked.end);
  const double slope = slope_with_interval(channel, rests);
  const double percent = 100.0 * even.scatter / even.window;
  if (slope > 0.5) {
    data.findings.push_back(
        {Severity::warning,
         fmt::format("the windows are unequal: gate times scatter by {:.2g} % of H, and at rest the "
                     "counts go with them: each count is divided by its own time",
                     percent),
         channel.name});
    return stamped_windows(channel, even);
  }
  data.findings.push_back(
      {Severity::info,
       fmt::format("stamps scatter by {:.2g} % of H{}: windows are taken as equal", percent,
                   rests.empty()
                       ? " and no segment at rest shows whether the counts do; set windows = \"stamps\" if they do"
                       : ", the counts at rest do not"),
       channel.name});
  return even;
}

/// The reference, whose clock runs at `rate`, over the windows of a series, or a finding why not.
void add_reference(const Evidence& evidence, const Channel& reference, double rate, const Draft& draft,
                   std::size_t first, Series& series, Data& data) {
  const double per_window = rate * series.interval;
  series.reference.assign(series.time.size(), std::nan(""));
  if (per_window > 3.5) {
    data.reference_integrated = true;
    std::size_t i = index_at(reference, series.begin);
    for (std::size_t j = 0; j < series.time.size(); ++j) {
      const double begin = series.time[j] - 0.5 * draft.windows.length[first + j],
                   end = begin + draft.windows.length[first + j];
      double sum = 0.0, n = 0.0;
      while (i < reference.values.size() && reference.time(i) < begin - 1e-9) ++i;
      for (std::size_t k = i; k < reference.values.size() && reference.time(k) < end - 1e-9; ++k, ++n)
        sum += reference.values[k];
      if (n > 0.0) series.reference[j] = sum / n;
    }
    return;
  }
  if (std::abs(per_window - 1.0) > 1e-3) {
    series.reference.clear();
    add_once({Severity::warning,
              fmt::format("sampled at {:.6g} Hz it cannot be put on windows of {}: record it with the windows, or at "
                          "four times their rate at least",
                          rate, say_seconds(series.interval)),
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

/// Values per second where the channel counts; K_1 and the pulse where given.
void set_scale(const Evidence& evidence, const std::vector<Draft>& drafts, std::size_t unit, Data& data) {
  UnitUnderTest& u = data.units[unit];
  const Channel& channel = *drafts.front().channel;
  const Reading reading = reading_of(channel);
  const Settings& settings = evidence.plan.settings;
  u.scale_relative_sd = settings.number("scale_factor_sd");
  double scale = 1.0;
  if (reading == Reading::pulses || reading == Reading::electric) {
    if (const auto given = given_scale(settings, u, channel)) {
      scale = *given;
    } else {
      std::vector<const Series*> rests;
      for (const auto& series : data.series)
        if (series.unit == unit && series.at_rest()) rests.push_back(&series);
      const auto found = scale_at_rest(rests, settings.number("bias_sd"));
      if (!found)
        throw Error(Error::Kind::bad_input,
                    fmt::format("'{}' is in {} and its scale factor is not known: set [settings] scale_factor, or add "
                                "segments at rest with the input axis along gravity",
                                channel.name, channel.unit.text()));
      scale = found->scale;
      u.scale_relative_sd = found->relative_sd;
      u.scale_from_rest = true;
      data.findings.push_back(
          {Severity::info,
           fmt::format("scale factor from the segments at rest, to {:.2g} % (a bias of {} is taken "
                       "for scale): set scale_factor if it is known better",
                       100.0 * u.scale_relative_sd, say_difference(settings.number("bias_sd"), Unit::parse("mg"))),
           u.channel});
    }
  }
  if (reading == Reading::pulses) u.pulse = 1.0 / std::abs(scale);
  u.force_per_value = 1.0 / scale;
  for (auto& series : data.series)
    if (series.unit == unit)
      for (double& v : series.force) v *= u.force_per_value;
}

/// Counts put right where the register ran over; values per second of window.
void per_second(const Draft& draft, Data& data) {
  const Reading reading = reading_of(*draft.channel);
  if (reading != Reading::pulses && reading != Reading::velocity) return;
  for (std::size_t k = 0; k < draft.series.size(); ++k) {
    Series& series = data.series[draft.series[k]];
    for (std::size_t j = 0; j < series.force.size(); ++j) series.force[j] /= draft.windows.length[draft.first[k] + j];
  }
}

void refuse_impossible(const Settings& settings, std::vector<std::string>& problems) {
  for (const char* name : {"scale_factor_sd", "bias_sd", "settling", "reference_gain_sd"})
    if (!(settings.number(name) >= 0.0 && std::isfinite(settings.number(name))))
      problems.push_back(fmt::format("[settings] {} must not be negative", name));
  if (settings.has("range") && !(settings.number("range") > 0.0))
    problems.emplace_back("[settings] range must be positive");
}

/// The first instrument is called by its serial where others stand beside it.
void name_units(const Evidence& evidence, Data& data, std::vector<std::string>& problems) {
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
      problems.push_back(fmt::format("[settings] scale_factor names a unit '{}' that is not recorded{} (units: {})",
                                     named, did_you_mean(named, names), fmt::join(names, ", ")));
}

/// Every scale factor that is given can be read, and is said once.
void check_scales(const Evidence& evidence, const Data& data, std::vector<std::string>& problems) {
  const Settings& settings = evidence.plan.settings;
  for (const auto& twice : twice_in_scale(settings))
    problems.push_back(fmt::format("[settings] scale_factor gives {} twice",
                                   twice.empty() ? "that of all units" : "that of '" + twice + "'"));
  for (const auto& recording : evidence.recordings)
    for (const Channel* channel : units_in(evidence, recording)) {
      const auto unit = std::ranges::find(data.units, channel->name, &UnitUnderTest::channel);
      try {
        given_scale(settings, *unit, *channel);
      } catch (const Error& error) {
        if (error.kind != Error::Kind::bad_input) continue;  // of the channel's unit: said with the data
        for (const auto& problem : error.problems)
          if (std::ranges::find(problems, problem) == problems.end()) problems.push_back(problem);
      }
    }
}

}  // namespace

Data data_of(const Evidence& evidence) {
  const Settings& settings = evidence.plan.settings;
  std::vector<std::string> problems;
  refuse_impossible(settings, problems);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "a vibration test needs at least one recording");
  Data data;
  if (settings.has("range")) data.range = settings.number("range");
  for (const auto& recording : evidence.recordings)
    for (const Channel* channel : units_in(evidence, recording)) unit_index(channel->name, data);
  name_units(evidence, data, problems);
  check_scales(evidence, data, problems);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  std::map<std::size_t, std::vector<Draft>> drafts;
  Test test{evidence};
  for (std::size_t r = 0; r < evidence.recordings.size(); ++r) {
    const Recording& recording = evidence.recordings[r];
    if (recording.marks.empty())
      throw Error(Error::Kind::bad_data,
                  "the recording does not say when its segments begin, and the plan has no schedule");
    const Channel* reference = channel_for(evidence, recording, "reference");
    const double reference_rate = reference == nullptr ? 0.0 : clock_of(*reference).rate;
    for (const Channel* channel : units_in(evidence, recording)) {
      attempt(problems, [&] {
        reading_of(*channel);
        const std::size_t unit = unit_index(channel->name, data);
        Draft draft{channel, windows_of(settings, test.marks[r], *channel, data), {}, {}};
        add_segments(test, r, unit, draft, data);
        refuse_totals(draft, data, problems);
        unwrap_counts(settings, draft, data, problems);
        per_second(draft, data);
        for (std::size_t k = 0; reference != nullptr && k < draft.series.size(); ++k)
          add_reference(evidence, *reference, reference_rate, draft, draft.first[k], data.series[draft.series[k]],
                        data);
        drafts[unit].push_back(std::move(draft));
        return 0;
      });
    }
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
  drop_dead(data);
  drop_moving(drafts, data);
  for (const auto& [unit, of_unit] : drafts)
    if (std::ranges::find(data.series, unit, &Series::unit) != data.series.end())
      attempt(problems, [&] {
        set_scale(evidence, of_unit, unit, data);
        return 0;
      });
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  compare_rests(data);
  set_power_ups(data);
  std::ranges::stable_sort(data.series, [](const Series& a, const Series& b) {
    return std::tie(a.unit, a.power_up, a.begin) < std::tie(b.unit, b.power_up, b.begin);
  });
  if (std::ranges::none_of(data.series, [](const Series& s) { return !s.at_rest(); })) {
    for (const auto& finding : data.findings)
      if (finding.severity != Severity::info)
        problems.push_back(finding.where.empty() ? finding.message : finding.where + ": " + finding.message);
    problems.emplace_back("no unit has a segment in which it vibrates");
    throw Error(Error::Kind::bad_data, problems);
  }
  return data;
}

}  // namespace tumble::vibration
