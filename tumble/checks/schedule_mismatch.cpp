#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/checks/check.hpp"
#include "tumble/language/say.hpp"

namespace tumble::checks::schedule_mismatch {

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

/// Nobody switches a table to the sample: half a per cent and two samples are accepted.
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
  return {{Finding::Severity::warning,
           segments.size() > 1 ? "length_of_no_part" : "length_mismatch",
           {{"recorded", found, "s"}, {"planned", whole, "s"}}}};
}

/// Whether the station ended the segment of a mark before its duration by a rule of the plan: it says so itself.
bool ended_by_rule(const Recording& recording, const Mark& mark) {
  return std::ranges::any_of(recording.findings, [&](const Finding& finding) {
    if (finding.code != "ended_by_rule" || finding.values.size() < 2) return false;
    const auto* label = std::get_if<std::string>(&finding.values[0].value);
    const auto* run = std::get_if<long long>(&finding.values[1].value);
    return label && run && *label == mark.label && *run == mark.run;
  });
}

/// What is the matter with the duration of the segment that a mark begins; nothing if it is as planned.
void compare_duration(const std::vector<Mark>& marks, std::size_t i, double planned, const Extent& extent,
                      Findings& findings) {
  const Mark& mark = marks[i];
  const std::string where = say_instant(mark.begin);
  if (mark.begin >= extent.end) {
    findings.push_back({Finding::Severity::warning,
                        "segment_after_end",
                        {{"segment", mark.label}, {"run", mark.run}, {"end", extent.end, "s"}},
                        where});
    return;
  }
  const bool last = i + 1 == marks.size(), last_of_run = last || marks[i + 1].run != mark.run;
  const double recorded = std::min({last ? extent.end : marks[i + 1].begin, mark.end, extent.end}) - mark.begin;
  const double allowed = allowance(planned, extent.sample);
  const bool too_long = recorded > planned + allowed && (!last_of_run || last);
  if (recorded < planned - allowed || too_long)
    findings.push_back(
        {Finding::Severity::warning,
         "segment_duration",
         {{"segment", mark.label}, {"run", mark.run}, {"recorded", recorded, "s"}, {"planned", planned, "s"}},
         where});
}

std::string name_of(const Finding& finding) {
  return fmt::format("'{}' of run {}", std::get<std::string>(finding.values[0].value),
                     std::get<long long>(finding.values[1].value));
}

/// How far the length of a segment is from that planned [s]; 0 of other findings.
double departure(const Finding& finding) {
  if (finding.code != "segment_duration") return 0.0;
  return std::abs(std::get<double>(finding.values[2].value) - std::get<double>(finding.values[3].value));
}

/// One finding of each kind, with a count, the first and the worst segment: a plan in another order is one mistake.
Findings gathered(const Findings& each) {
  Findings all;
  for (const Finding& one : each) {
    const auto same = std::ranges::find(all, one.code, &Finding::code);
    if (same == all.end()) {
      all.push_back(one);
      all.back().occurrences = {1, name_of(one), name_of(one)};
      continue;
    }
    Occurrences occurrences = same->occurrences;
    ++occurrences.count;
    const bool worse = departure(one) > departure(*same);
    if (worse) occurrences.worst = name_of(one);
    *same = {one.severity, one.code, worse ? one.values : same->values, "", occurrences};
  }
  return all;
}

/// How much later than the first mark the samples begin [s], where they end as much after the plan and all other segments are
/// as planned: the stamps are late, or the marks early. Else 0.
///
/// Given     each         of all marks
///           before_last  how many of these are of the marks before the last one
double late_by(const Recording& recording, const Findings& each, std::size_t before_last, const Extent& extent) {
  const double late = extent.begin - recording.marks.front().begin, alike = 2.0 * extent.sample;
  const bool only_last = before_last == 0 && each.size() == 1 && each.front().code == "segment_duration";
  if (!only_last || !(late > alike)) return 0.0;
  const auto number = [&](std::size_t k) { return std::get<double>(each.front().values[k].value); };
  return std::abs(number(2) - number(3) - late) < alike ? late : 0.0;
}

Findings by_marks(const Recording& recording, const Schedule& segments, const Extent& extent) {
  Findings findings;
  const auto& marks = recording.marks;
  std::vector<bool> recorded(segments.size(), false);
  std::size_t before_last = 0;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const Mark& mark = marks[i];
    before_last = findings.size();
    if (mark.label.empty()) continue;  // the way between segments
    std::size_t k = 0;
    while (k < segments.size() && (recorded[k] || segments[k].label != mark.label || segments[k].run != mark.run)) ++k;
    if (k == segments.size()) {
      findings.push_back({Finding::Severity::warning,
                          "segment_not_scheduled",
                          {{"segment", mark.label}, {"run", mark.run}},
                          say_instant(mark.begin)});
      continue;
    }
    recorded[k] = true;
    if (!ended_by_rule(recording, mark)) compare_duration(marks, i, segments[k].duration, extent, findings);
  }
  for (std::size_t k = 0; k < segments.size(); ++k)
    if (!recorded[k] && std::ranges::find(marks, segments[k].run, &Mark::run) != marks.end())
      findings.push_back({Finding::Severity::warning,
                          "segment_not_recorded",
                          {{"segment", segments[k].label}, {"run", segments[k].run}}});
  if (const double late = late_by(recording, findings, before_last, extent); late > 0.0)
    return {{Finding::Severity::warning, "samples_late_on_marks", {{"shift", late, "s"}}}};
  return gathered(findings);
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

}  // namespace tumble::checks::schedule_mismatch
