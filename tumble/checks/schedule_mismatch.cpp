#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/checks/check.hpp"
#include "tumble/core/say.hpp"

namespace tumble::checks {

namespace {

/// When the recording ends [s]: after the last sample of its longest channel has lasted; NaN without two samples.
struct Extent {
  double begin = INFINITY, end = -INFINITY, sample = 0.0;
};

Extent extent_of(const Recording& recording) {
  Extent extent;
  for (const Channel& channel : recording.channels) {
    const double rate = mean_rate(channel);
    if (!(rate > 0.0)) continue;
    extent.begin = std::min(extent.begin, channel.time(0));
    extent.end = std::max(extent.end, channel.time(channel.values.size() - 1) + 1.0 / rate);
    extent.sample = std::max(extent.sample, 1.0 / rate);
  }
  return extent;
}

/// The segments of the plan that this recording should hold: those its entry in the plan names, else all.
Schedule planned(const Recording& recording, const Plan& plan) {
  const auto entry = std::find_if(plan.recordings.begin(), plan.recordings.end(),
                                  [&](const RecordingEntry& e) { return e.file == recording.origin.file; });
  if (entry == plan.recordings.end()) return plan.schedule;
  Schedule segments;
  for (const Segment& segment : plan.schedule)
    if ((entry->segment.empty() || segment.label == entry->segment) && (entry->run == 0 || segment.run == entry->run))
      segments.push_back(segment);
  if (!entry->segment.empty() && segments.size() > 1) segments.resize(1);  // a repeat has a file of its own
  return segments;
}

Finding warning(std::string message, std::string where = "") {
  return {Finding::Severity::warning, std::move(message), std::move(where)};
}

/// Nobody switches a table to the sample: half a per cent, and two samples, are let pass.
double allowance(double duration, double sample) { return 0.005 * duration + 2.0 * sample; }

/// Without marks the length is all there is. The recording may hold the whole, one run or one segment; with several
/// runs in it, time may pass between the power-ups.
Findings by_length(const Schedule& segments, const Extent& extent) {
  const double found = extent.end - extent.begin;
  const auto fits = [&](double planned) { return std::abs(found - planned) <= allowance(planned, extent.sample); };
  double whole = 0.0;
  std::map<int, double> runs;
  for (const Segment& segment : segments) {
    if (fits(segment.duration)) return {};
    whole += segment.duration;
    runs[segment.run] += segment.duration;
  }
  for (const auto& [run, duration] : runs)
    if (fits(duration)) return {};
  if (fits(whole) || (runs.size() > 1 && found > whole)) return {};
  return {warning(fmt::format("the recording lasts {}, the schedule {}{}", say_seconds(found), say_seconds(whole),
                              segments.size() > 1 ? ", and no run or segment of it lasts as long" : ""))};
}

std::string named(const std::string& label, int run) { return fmt::format("segment '{}' of run {}", label, run); }

Findings by_marks(const Recording& recording, const Schedule& segments, const Extent& extent) {
  Findings findings;
  const auto& marks = recording.marks;
  std::vector<bool> seen(segments.size(), false);
  const auto run_is_here = [&](int run) {
    return std::any_of(marks.begin(), marks.end(), [&](const Mark& mark) { return mark.run == run; });
  };
  for (std::size_t i = 0; i < marks.size(); ++i) {
    std::size_t k = 0;
    while (k < segments.size() && (seen[k] || segments[k].label != marks[i].label || segments[k].run != marks[i].run))
      ++k;
    const std::string where = say_instant(marks[i].begin);
    if (k == segments.size()) {
      findings.push_back(warning(named(marks[i].label, marks[i].run) + " is not in the schedule", where));
      continue;
    }
    seen[k] = true;
    if (marks[i].begin >= extent.end) {
      findings.push_back(warning(fmt::format("{} is not in the recording, which ends at {}",
                                             named(marks[i].label, marks[i].run), say_instant(extent.end)),
                                 where));
      continue;
    }
    const bool last_of_run = i + 1 == marks.size() || marks[i + 1].run != marks[i].run;
    const double found = std::min(i + 1 < marks.size() ? marks[i + 1].begin : extent.end, extent.end) - marks[i].begin;
    const double planned_duration = segments[k].duration, allowed = allowance(planned_duration, extent.sample);
    const bool too_long = found > planned_duration + allowed && (!last_of_run || i + 1 == marks.size());
    if (found < planned_duration - allowed || too_long)
      findings.push_back(warning(fmt::format("{} lasts {}, but the plan says {}", named(marks[i].label, marks[i].run),
                                             say_seconds(found), say_seconds(planned_duration)),
                                 where));
  }
  for (std::size_t k = 0; k < segments.size(); ++k)
    if (!seen[k] && run_is_here(segments[k].run))
      findings.push_back(warning(named(segments[k].label, segments[k].run) + " is not in the recording"));
  return findings;
}

Findings run(const Recording& recording, const Plan* plan) {
  if (plan == nullptr) return {};
  const Schedule segments = planned(recording, *plan);
  const Extent extent = extent_of(recording);
  if (segments.empty() || !(extent.end > extent.begin)) return {};
  return recording.marks.empty() ? by_length(segments, extent) : by_marks(recording, segments, extent);
}

}  // namespace

extern const Check schedule_mismatch{"schedule_mismatch",
                                     "segments that last longer or shorter than planned, or are missing", run};

}  // namespace tumble::checks
