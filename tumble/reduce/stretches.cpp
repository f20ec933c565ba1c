#include "tumble/reduce/stretches.hpp"

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
#include "tumble/clocks/stamp_slack.hpp"
#include "tumble/reduce/order_of_marks.hpp"
#include "tumble/reduce/table/kept_motion.hpp"
#include "tumble/sim/power_up.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

PowerUp power_up_of(const Plan& plan, Schedule segments, double rate) {
  PowerUp out{.plan = &plan, .step = 1.0 / rate, .begins = {0.0}};
  for (const auto& segment : segments) out.begins.push_back(out.begins.back() + segment.duration);
  out.rig = {std::move(segments), plan.rig, plan.site, rate, {}, RandomStream(0)};
  if (!plan.rig_kind.empty()) out.reference = find_rig(plan.rig_kind).reference(out.rig);
  return out;
}

std::vector<PowerUp> power_ups_of(const Plan& plan, double rate) {
  std::vector<PowerUp> out;
  for (auto& run : power_ups(plan.schedule, rate)) out.push_back(power_up_of(plan, std::move(run.segments), rate));
  return out;
}

double settled_at(const PowerUp& power_up, std::size_t segment) {
  const auto& settled = power_up.reference.settled;
  const double begin = power_up.begins[segment];
  return segment < settled.size() ? std::max(begin, settled[segment]) : begin;
}

double longest_turn(const Segment& segment) {
  double turn = 0.0;
  for (const auto& [name, motion] : segment.axes)
    if (motion.kind == Motion::Kind::rate && motion.value != 0.0)
      turn = std::max(turn, two_pi / std::abs(motion.value));
  return turn;
}

Finding unused_segment(const std::string& label, int run, Phrase why) {
  return {Finding::Severity::warning,
          "segment_not_used",
          {{"segment", label}, {"reason", std::move(why)}},
          fmt::format("run {}", run)};
}

void refuse_unused(const ConductedTest& test, Error::Kind kind) {
  if (!test.stretches.empty()) return;
  Problems why;
  for (const auto& finding : test.findings) why.push_back(said_of(finding));
  why.push_back("no segment of the schedule has usable samples");
  throw Error(kind, why);
}

SampleRange samples_between(const Channel& channel, double begin, double end) {
  SampleRange range{0, channel.values.size()};
  if (channel.values.empty()) return range;
  const double rate = mean_rate(channel), step = rate > 0.0 ? 1.0 / rate : 0.0;
  if (std::isfinite(begin)) range.begin = index_at(channel, begin - stamp_slack(begin, step));
  if (std::isfinite(end)) range.end = std::max(range.begin, index_at(channel, end - stamp_slack(end, step)));
  return range;
}

namespace {

void require(const Plan& plan, double rate, const StretchOptions& options, Problems& problems) {
  const auto complain = [&](const char* what) { problems.push_back(in_file(plan.file, what)); };
  if (plan.rig_kind.empty()) complain("the plan needs [rig] kind = \"...\" that says what was felt");
  if (plan.schedule.empty()) complain("the plan needs at least one [[schedule]]");
  if (options.needs_site && !plan.site)
    complain(
        "the plan needs [site] latitude = \"34.25 deg\" or the like: the Earth's rate and gravity are part of what the "
        "instrument feels");
  if (!(rate > 0.0)) complain("the plan needs [instrument] rate = \"1 Hz\" or the like");
}

/// Whether a recording is the file of one segment, as [[recording]] says.
bool stands_alone(const Evidence& evidence, std::size_t recording) {
  const auto& entries = evidence.plan.recordings;
  return recording < entries.size() && !entries[recording].segment.empty();
}

/// Adds the power-ups of a plan. Returned: where the segments of its schedule stand among those of the test.
std::vector<Conducted::Place> add_power_ups(Conducted power_ups, std::size_t number, ConductedTest& test) {
  for (auto& place : power_ups.places)
    if (place.power_up != Conducted::nowhere) place.power_up += test.power_ups.size();
  for (auto& power_up : power_ups.power_ups) {
    power_up.plan_number = number;
    test.power_ups.push_back(std::move(power_up));
  }
  return power_ups.places;
}

bool passed_over(const Segment& segment, const StretchOptions& options) {
  return options.passed_over && options.passed_over(segment);
}

bool from_beginning(const Segment& segment, const StretchOptions& options) {
  return options.unsettled && options.unsettled(segment);
}

/// From when the segment's samples are used [s since power-on].
double used_from(const PowerUp& power_up, std::size_t segment, const StretchOptions& options) {
  if (from_beginning(power_up.rig.segments[segment], options)) return power_up.begins[segment];
  return settled_at(power_up, segment) + options.settling;
}

bool is_steady(const PowerUp& power_up, const Stretch& stretch) {
  const double from = stretch.first + 0.5 * power_up.step;
  const double last = stretch.first + (static_cast<double>(stretch.samples) - 0.5) * stretch.step;
  const auto& until = power_up.reference.steady_until;
  return !until || until(from) >= last;
}

/// How the samples of a channel lie on its clock [Hz].
double rate_of(const Channel& channel) {
  if (channel.values.empty()) return 0.0;
  return channel.timeline.uniform() ? channel.timeline.rate : clock_of(channel).rate;
}

double checked_rate(const Recording& recording, const Channel& channel) {
  const double rate = rate_of(channel);
  const auto finite = [](double v) { return std::isfinite(v); };
  if (rate > 0.0 && std::isfinite(rate) && channel.values.size() > 1 && std::ranges::any_of(channel.values, finite))
    return rate;
  throw Error(Error::Kind::bad_data,
              in_file(recording.origin.file, say("channel '{}' holds no evenly timed samples", channel.name)));
}

/// Whether any sample was taken from `begin` to `end` [s, recording's clock].
bool has_samples(const Channel& channel, double begin, double end) {
  const SampleRange range = samples_between(channel, begin, end);
  for (std::size_t i = range.begin; i < range.end; ++i)
    if (!std::isnan(channel.values[i])) return true;
  return false;
}

/// One recording: the channel that is used, its rate [Hz], and the encoders beside it.
struct ReadFrom {
  const Channel& channel;
  double rate = 0.0;
  std::vector<table::Encoder> encoders;
};

/// Leaves out what the encoders show of the moves before and after a segment, where these are not over, or begun, when the
/// plan and the marks say.
void leave_out_moves(const ReadFrom& source, const PowerUp& power_up, const StretchOptions& options, Stretch& stretch) {
  const Segment& segment = power_up.rig.segments[stretch.segment];
  if (from_beginning(segment, options)) return;
  const double settled = stretch.power_on + settled_at(power_up, stretch.segment), end = stretch.end;
  for (const auto& encoder : source.encoders) {
    const Motion* motion = table::motion_of(segment, encoder.axis);
    if (motion != nullptr && motion->continued) continue;
    const table::Kept kept = table::kept_motion(encoder, motion, settled, end);
    // a rate that goes on from a recorded angle was reached at another time: perhaps within the first sample
    const bool elsewhere = motion != nullptr && motion->kind == Motion::Kind::rate && motion->from.has_value();
    const double from = elsewhere && kept.from == settled ? settled + 1.0 / source.rate : kept.from;
    if (from > settled) stretch.begin = std::max(stretch.begin, from + options.settling);
    stretch.end = std::min(stretch.end, kept.until);
  }
}

/// Adds the samples of one marked segment, or a finding why not.
void add_stretch(const ReadFrom& source, const MarkedSegment& marked, const Conducted::Place& place,
                 const StretchOptions& options, ConductedTest& test) {
  const auto& [channel, rate, encoders] = source;
  const PowerUp& power_up = test.power_ups[place.power_up];
  if (passed_over(power_up.rig.segments[place.segment], options)) return;
  Stretch out{.power_up = place.power_up,
              .segment = place.segment,
              .label = marked.label,
              .run = marked.run,
              .start = marked.start,
              .repetition = marked.repetition,
              .recording = marked.recording};
  out.power_on = marked.begin - power_up.begins[place.segment];
  out.begin = out.power_on + used_from(power_up, place.segment, options);
  out.end = std::min(marked.end, out.power_on + power_up.begins[place.segment + 1]);
  // A move may begin within a sample, which is then its first.
  if (from_beginning(power_up.rig.segments[place.segment], options))
    out.begin -= 1.0 / rate - 2.0 * stamp_slack(out.begin, 1.0 / rate);
  leave_out_moves(source, power_up, options, out);
  auto samples = even_samples(channel, rate, out.begin, out.end, options.scale);
  out.first = samples.first - out.power_on;
  out.step = samples.step;
  out.samples = samples.count;
  out.values = std::move(samples.values);
  if (std::ranges::all_of(out.values, [](double v) { return std::isnan(v); })) {
    const bool any = has_samples(channel, marked.begin, out.end);
    test.findings.push_back(
        unused_segment(marked.label, marked.run, {any ? "no_sample_after_settling" : "no_sample_recorded"}));
    return;
  }
  out.steady = is_steady(power_up, out);
  test.stretches.push_back(std::move(out));
}

/// Adds a segment of a plan that was not yet carried out.
void add_planned(const PowerUp& power_up, const Conducted::Place& place, std::size_t start,
                 const StretchOptions& options, ConductedTest& test) {
  const Segment& segment = power_up.rig.segments[place.segment];
  if (passed_over(segment, options)) return;
  Stretch out{.power_up = place.power_up,
              .segment = place.segment,
              .label = segment.label,
              .run = segment.run,
              .start = start,
              .step = 1.0 / power_up.plan->sample_rate};
  out.begin = out.first = std::ceil(used_from(power_up, place.segment, options) / out.step - 1e-6) * out.step;
  out.end = power_up.begins[place.segment + 1];
  const double length = out.end - out.first + 1e-6 * out.step;
  out.samples = length > 0.0 ? static_cast<std::size_t>(length / out.step) : 0;
  if (out.samples == 0) {
    test.findings.push_back(unused_segment(segment.label, segment.run, {"no_sample_after_settling"}));
    return;
  }
  out.steady = is_steady(power_up, out);
  test.stretches.push_back(std::move(out));
}

}  // namespace

Finding segments_not_recorded(int run, const std::vector<std::string>& labels) {
  return {Finding::Severity::warning,
          "not_recorded",
          {{"segments", fmt::format("'{}'", fmt::join(labels, "', '"))}},
          fmt::format("run {}", run),
          {labels.size(), labels.front(), {}}};
}

namespace {

/// A warning for each run of a plan of which some segments have no mark in any recording.
void warn_of_unrecorded(const Plan& plan, const std::vector<std::vector<MarkedSegment>>& marks,
                        const StretchOptions& options, Findings& findings) {
  std::set<const Segment*> recorded;
  std::set<int> runs;
  for (const auto& of_recording : marks)
    for (const auto& marked : of_recording) recorded.insert(marked.planned);
  for (const Segment& segment : plan.schedule)
    if (recorded.contains(&segment)) runs.insert(segment.run);
  for (const int run : runs) {
    std::vector<std::string> labels;
    for (const Segment& segment : plan.schedule)
      if (segment.run == run && !recorded.contains(&segment) && !passed_over(segment, options))
        labels.push_back(segment.label);
    if (labels.empty()) continue;
    findings.push_back(segments_not_recorded(run, labels));
  }
}

/// A section of a recording that the schedule does not contain.
struct NotPlanned {
  std::string label;
  int run = 1;
};

/// One finding for each power-up. A section without a label is the way between segments, as its writer says.
void add_not_planned(std::vector<NotPlanned> sections, Findings& findings) {
  std::erase_if(sections, [](const NotPlanned& section) { return section.label.empty(); });
  std::set<int> runs;
  for (const auto& section : sections) runs.insert(section.run);
  for (const int run : runs) {
    std::vector<std::string> labels;
    for (const auto& section : sections)
      if (section.run == run) labels.push_back(section.label);
    Finding finding = unused_segment(labels.front(), run, {"not_in_schedule"});
    finding = {finding.severity, finding.code, finding.values, finding.where, {labels.size(), labels.front(), {}}};
    findings.push_back(std::move(finding));
  }
}

}  // namespace

ConductedTest stretches(const Evidence& evidence, const StretchOptions& options) {
  ConductedTest test;
  std::map<const Plan*, std::size_t> numbers;
  std::map<std::tuple<const Plan*, bool, std::size_t>, std::vector<Conducted::Place>> places;
  Problems problems;
  std::vector<NotPlanned> not_planned;
  const auto marks = marked_segments(evidence);
  for (std::size_t r = 0; r < evidence.recordings.size(); ++r) {
    const Plan& plan = plan_of(evidence, r);
    const Channel& channel = require_channel(evidence, evidence.recordings[r], options.role);
    const double rate = checked_rate(evidence.recordings[r], channel);
    require(plan, rate, options, problems);
    if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
    const bool alone = stands_alone(evidence, r);
    const std::size_t number = numbers.try_emplace(&plan, numbers.size()).first->second;
    // recordings in the order of the plan share its power-ups
    const std::tuple key{&plan, alone, alone || !in_order_of_marks(plan, marks[r]) ? evidence.recordings.size() : r};
    if (!places.contains(key))
      places[key] = add_power_ups(conducted(plan, marks[r], alone, rate * options.oversampling), number, test);
    if (marks[r].empty())
      throw Error(Error::Kind::bad_data,
                  "the recording does not say when its segments begin, and the plan has no schedule");
    const ReadFrom source{channel, rate, table::encoders_of(evidence, r)};
    for (const auto& marked : marks[r]) {
      test.starts = std::max(test.starts, marked.start + 1);
      if (marked.planned == nullptr)
        not_planned.push_back({marked.label, marked.run});
      else
        add_stretch(source, marked, places[key][marked.index], options, test);
    }
  }
  add_not_planned(not_planned, test.findings);
  test.plans = numbers.size();
  std::vector<const Plan*> plans(numbers.size());
  for (const auto& [plan, number] : numbers) plans[number] = plan;
  for (const Plan* plan : plans) warn_of_unrecorded(*plan, marks, options, test.findings);
  refuse_unused(test, Error::Kind::bad_data);
  return test;
}

ConductedTest stretches(const Plan& plan, const StretchOptions& options) {
  std::vector<const Plan*> plans{&plan};
  for (const auto& entry : plan.recordings)
    if (entry.plan && std::ranges::find(plans, entry.plan.get()) == plans.end()) plans.push_back(entry.plan.get());
  Problems problems;
  for (const Plan* each : plans) require(*each, each->sample_rate, options, problems);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  ConductedTest test;
  for (const Plan* each : plans) {
    std::map<int, std::size_t> starts;
    const auto places = add_power_ups(
        conducted(*each, {}, recorded_one_by_one(*each), each->sample_rate * options.oversampling), test.plans++, test);
    for (const auto& place : places) {
      const PowerUp& power_up = test.power_ups[place.power_up];
      const auto start = starts.try_emplace(power_up.rig.segments[place.segment].run, test.starts);
      if (start.second) ++test.starts;
      add_planned(power_up, place, start.first->second, options, test);
    }
  }
  if (test.stretches.empty()) throw Error(Error::Kind::bad_input, "no sample of any segment remains after settling");
  return test;
}

}  // namespace tumble
