#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string_view>

#include "tumble/checks/check.hpp"
#include "tumble/core/unit_facts.hpp"
#include "tumble/departures/judgement.hpp"
#include "tumble/reduce/arrival_stamps.hpp"
#include "tumble/reduce/table/recorded_turns.hpp"
#include "tumble/report/report.hpp"
#include "tumble/tasks/identity.hpp"
#include "tumble/tasks/long_record.hpp"
#include "tumble/tasks/noticed.hpp"
#include "tumble/tasks/plausible.hpp"
#include "tumble/tasks/prior.hpp"
#include "tumble/tasks/provenance.hpp"
#include "tumble/tasks/streamed.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {
namespace {

/// Whether the method has reported already what a check reports: of the segments of the plan, or of steps that its
/// uncertainties include.
bool is_reported(const Finding& checked, const Findings& reported) {
  const auto text = [](const Finding& finding) {
    const auto* name = finding.values.empty() ? nullptr : std::get_if<std::string>(&finding.values.front().value);
    return name ? *name : std::string();
  };
  return std::ranges::any_of(reported, [&](const Finding& finding) {
    return (checked.code == "segment_not_recorded" && finding.code == "not_recorded") ||
           (checked.code == "steps_exceed_noise" && finding.code == "rests_show_rounding" &&
            checked.where == finding.where) ||
           (checked.code == "segment_not_scheduled" && finding.code == "segment_not_used" &&
            text(checked) == text(finding));
  });
}

bool is_marked(const Recording& recording, const Segment& segment) {
  return std::ranges::any_of(recording.marks,
                             [&](const Mark& mark) { return mark.label == segment.label && mark.run == segment.run; });
}

/// The plan as one recording should follow it: as its entry says, and without the segments that only others hold.
Plan plan_for(const Evidence& evidence, std::size_t i) {
  Plan plan = plan_of(evidence, i);
  const auto& entries = evidence.plan.recordings;
  if (i < entries.size()) plan.recordings = {entries[i]};
  const auto held_by_others = [&](const Segment& segment) {
    if (is_marked(evidence.recordings[i], segment)) return false;
    for (std::size_t other = 0; other < evidence.recordings.size(); ++other)
      if (&plan_of(evidence, other) == &plan_of(evidence, i) && is_marked(evidence.recordings[other], segment))
        return true;
    return false;
  };
  std::erase_if(plan.schedule, held_by_others);
  return plan;
}

/// What the readers and the checks noticed in one recording, beyond what the method has said.
Findings noticed_in(const Evidence& evidence, std::size_t i, const Findings& reported) {
  const auto& recording = evidence.recordings[i];
  auto noticed = recording.findings;
  Plan plan = plan_for(evidence, i);
  if (!plan.reading.rate) plan.reading.rate = evidence.plan.reading.rate;
  const auto checked = run_checks(recording, &plan);
  noticed.insert(noticed.end(), checked.begin(), checked.end());
  std::erase_if(noticed, [&](const Finding& finding) { return is_reported(finding, reported); });
  return noticed;
}

void add_data_findings(const Evidence& evidence, Findings& findings) {
  std::vector<NoticedIn> noticed;
  for (std::size_t i = 0; i < evidence.recordings.size(); ++i)
    noticed.push_back({evidence.recordings[i].origin.file, noticed_in(evidence, i, findings)});
  for (auto& finding : gathered(noticed)) findings.push_back(std::move(finding));
}

bool ends_with(const std::string& name, std::string_view end) {
  return name == end || name.ends_with("." + std::string(end)) || name.ends_with("_" + std::string(end));
}

/// The least relative standard deviation [1] of a scale factor; infinity without one.
double finest_scale_factor(const Estimate& estimate) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t j = 0; j < estimate.parameters.size(); ++j) {
    const Parameter& parameter = estimate.parameters[j];
    const double sd = std::sqrt(estimate.covariance(j, j));
    if (ends_with(parameter.name, "scale_factor")) least = std::min(least, sd / std::abs(parameter.value));
    if (ends_with(parameter.name, "scale_factor_error")) least = std::min(least, sd);
  }
  return least;
}

/// A scale factor of counts is off by as much as the clock: two clocks that contradict each other by more than its standard
/// deviation are worth a warning, however good they are.
void weigh_clocks(Estimate& estimate) {
  const double finest = finest_scale_factor(estimate);
  for (Finding& finding : estimate.findings) {
    if (finding.code != "rate_of_counts_differs" || finding.severity != Finding::Severity::info) continue;
    for (const FindingValue& value : finding.values)
      if (value.name == "difference" && std::abs(std::get<double>(value.value)) > finest)
        finding.severity = Finding::Severity::warning;
  }
}

/// Whether outputs come in bursts and an encoder beside them does not: nobody knows how long the last sample of a burst
/// waited, and the motion is compared with it at that time.
bool has_other_clock(const Recording& recording, const Recording& taken) {
  bool bursts = false, even = false;
  for (std::size_t c = 0; c < recording.channels.size(); ++c) {
    const bool changed = taken.channels[c].timeline.stamps != recording.channels[c].timeline.stamps;
    bursts = bursts || changed;
    even = even || (!changed && recording.channels[c].kind == QuantityKind::angle);
  }
  return bursts && even;
}

void weigh_bursts(const std::vector<Recording>& recordings, const std::vector<Recording>& taken, Findings& findings) {
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    if (!has_other_clock(recordings[r], taken[r])) continue;
    for (Finding& finding : findings)
      if (finding.code == "jitter_with_pauses") finding.severity = Finding::Severity::warning;
  }
}

std::string default_title(const Evidence& evidence) {
  std::string title = evidence.plan.method;
  if (!evidence.recordings.empty() && !evidence.recordings.front().origin.file.empty())
    title += " of " + std::filesystem::path(evidence.recordings.front().origin.file).filename().string();
  if (evidence.recordings.size() > 1) title += fmt::format(" and {} more", evidence.recordings.size() - 1);
  return title;
}

void describe(const Plan& plan, Estimate& estimate) {
  estimate.method = plan.method;
  estimate.instrument_model = plan.instrument_model;
  estimate.provenance = provenance_of(plan);
}

/// Which channel played each role: compensate takes the same. The seed, where the data were simulated.
void add_origin(const Evidence& evidence, Provenance& provenance) {
  for (const auto& recording : evidence.recordings) {
    provenance.inputs.push_back({relative_to(evidence.plan, recording.origin.file), sha256_of(recording.origin)});
    for (const auto& role : find_method(evidence.plan.method).roles())
      if (const auto* channel = channel_for(evidence, recording, role.name))
        provenance.settings["channels." + role.name] = channel->name;
    if (const auto seed = recording.meta.find(std::string(seed_fact)); seed != recording.meta.end())
      if (const auto value = as_number<unsigned long long>(seed->second)) provenance.seed = *value;
  }
}

/// The method's own work. It knows channels but no files: where there is one file its name goes before what is refused.
Estimate reduce(const std::function<Estimate()>& work, const std::string& file) try {
  return work();
} catch (const Error& error) {
  if (error.kind != Error::Kind::bad_data) throw;
  auto problems = error.problems;
  for (auto& problem : problems)
    if (!file.empty() && problem.text().find(file) == std::string::npos) problem = in_file(file, problem);
  throw Error(error.kind, problems);
}

/// When each recording was made, where any of their files says it.
void add_times(const Evidence& evidence, const std::vector<Extent>& extents, Estimate& estimate) {
  std::vector<RecordingTimes> times;
  for (std::size_t i = 0; i < evidence.recordings.size(); ++i) {
    const Recording& recording = evidence.recordings[i];
    times.push_back({relative_to(evidence.plan, recording.origin.file), test_times(recording.meta, extents[i])});
  }
  if (std::ranges::any_of(times, [](const RecordingTimes& one) { return !one.times.begun.empty(); }))
    estimate.tables.push_back(table_of(times));
}

void complete(const Evidence& evidence, const UnitIdentity& unit, const std::vector<Extent>& extents,
              Estimate& estimate) {
  describe(evidence.plan, estimate);
  estimate.instrument_serial = unit.serial;
  estimate.findings.insert(estimate.findings.end(), unit.findings.begin(), unit.findings.end());
  add_origin(evidence, estimate.provenance);
  add_times(evidence, extents, estimate);
  estimate.title = evidence.plan.title.empty() ? default_title(evidence) : evidence.plan.title;
}

/// Says what no data of the test can show: the budget contains of it only what the plan states.
void add_unseen(const Evidence& evidence, Estimate& estimate) {
  const auto names = unseen_in(evidence.plan, evidence.recordings);
  if (names.empty()) return;
  estimate.findings.push_back(
      {Finding::Severity::info, "cannot_be_seen", {{"departures", fmt::format("'{}'", fmt::join(names, "', '"))}}, ""});
}

/// What the answer and the plan show to be wrong, whatever the data say.
void add_doubts(const Plan& plan, Estimate& estimate) {
  for (auto& finding : implausible(estimate, plan)) estimate.findings.push_back(std::move(finding));
  for (auto& finding : about_site(plan)) estimate.findings.push_back(std::move(finding));
  for (auto& finding : ruled_by_site(plan, estimate)) estimate.findings.push_back(std::move(finding));
}

Estimate identify(const Streamed& streamed, std::uintmax_t memory, const Progress& progress) {
  const Plan& plan = streamed.evidence.plan;
  Evidence evidence{plan, std::vector<Recording>(1)};
  auto estimate = reduce([&] { return find_method(plan.method).stream(streamed.evidence, progress); }, streamed.file);
  add_doubts(plan, estimate);
  evidence.recordings[0] = *streamed.header;
  add_unseen(evidence, estimate);
  evidence.recordings[0].origin.checksum = streamed.checksum;
  complete(evidence, unit_of(evidence), {*streamed.extent}, estimate);
  const Findings& noticed = evidence.recordings[0].findings;
  estimate.findings.insert(estimate.findings.end(), noticed.begin(), noticed.end());
  estimate.findings.push_back(
      {Finding::Severity::info, "processed_in_blocks", {{"size", streamed.bytes}, {"memory", memory}}, streamed.file});
  estimate.provenance.memory = memory;
  add_prior(plan, estimate);
  settle_findings(estimate);
  estimate.verdicts = judge(plan.limits, estimate);
  return estimate;
}

/// The recordings with the times at which their samples were taken; nothing: the stamps say it.
using Taken = std::optional<std::vector<Recording>>;

table::RecordedTurns recorded_turns(const Evidence& evidence, const Taken& taken) {
  return taken ? table::recorded_turns({evidence.plan, *taken, evidence.plans}) : table::recorded_turns(evidence);
}

/// With plans that say how the rigs moved, and what is to be said of that.
Estimate identify_as_planned(const Evidence& evidence, const Taken& taken, const Findings& said,
                             const Progress& progress) {
  const UnitIdentity unit = unit_of(evidence);  // first: a contradiction costs no reduction
  const std::string file = evidence.recordings.size() == 1 ? evidence.recordings[0].origin.file : "";
  auto estimate = reduce(
      [&] {
        const Method& method = find_method(evidence.plan.method);
        return taken ? method.identify({evidence.plan, *taken, evidence.plans}, progress)
                     : method.identify(evidence, progress);
      },
      file);
  estimate.findings.insert(estimate.findings.end(), said.begin(), said.end());
  add_doubts(evidence.plan, estimate);
  add_unseen(evidence, estimate);
  add_data_findings(evidence, estimate.findings);
  weigh_clocks(estimate);
  if (taken) weigh_bursts(evidence.recordings, *taken, estimate.findings);
  std::vector<Extent> extents(evidence.recordings.size());
  for (std::size_t i = 0; i < extents.size(); ++i) extents[i].add(evidence.recordings[i]);
  complete(evidence, unit, extents, estimate);
  add_prior(evidence.plan, estimate);
  settle_findings(estimate);
  estimate.verdicts = judge(evidence.plan.limits, estimate);
  return estimate;
}

}  // namespace

Estimate identify(Evidence&& evidence, const Progress& progress) {
  const Taken taken = with_clocks_of_bursts(evidence.recordings);
  auto turns = recorded_turns(evidence, taken);
  if (!turns.findings.empty()) {
    evidence.plan = std::move(turns.plan);
    evidence.plans = std::move(turns.plans);
  }
  return identify_as_planned(evidence, taken, turns.findings, progress);
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  const Taken taken = with_clocks_of_bursts(evidence.recordings);
  auto turns = recorded_turns(evidence, taken);
  if (turns.findings.empty()) return identify_as_planned(evidence, taken, {}, progress);
  return identify_as_planned({std::move(turns.plan), evidence.recordings, std::move(turns.plans)}, taken,
                             turns.findings, progress);
}

Estimate identify(const Plan& plan, const std::vector<std::string>& recordings, std::uintmax_t memory,
                  const Progress& progress) {
  if (const auto streamed = open_stream(plan, recordings, memory, progress))
    return identify(*streamed, memory, progress);
  return identify(gather(plan, recordings, progress), progress);
}

namespace {

/// The channels of a record in several files, with a sample each. Their kind is not kept: they are outputs.
Recording channels_of(const RecordPiece& piece) {
  Recording recording;
  for (const auto& channel : piece.channels)
    recording.channels.push_back(
        {channel.label, QuantityKind::angular_rate, Unit{}, {channel.begin, channel.rate, {}}, {0.0}});
  return recording;
}

}  // namespace

Estimate identify_pieces(const Plan& plan, const std::vector<RecordPiece>& pieces,
                         const std::vector<std::string>& sha256, const NoisePart& joined) {
  Estimate estimate = joined.estimate(plan);
  add_doubts(plan, estimate);
  if (!pieces.empty()) add_unseen({plan, {channels_of(pieces.front())}}, estimate);
  describe(plan, estimate);
  std::vector<RecordingTimes> times;
  std::vector<NoticedIn> noticed;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const std::string& file = pieces[i].file;
    const std::string name = file.find("://") == std::string::npos ? relative_to(plan, file) : file;
    estimate.provenance.inputs.push_back({name, sha256[i]});
    times.push_back({name, {pieces[i].begun, pieces[i].ended}});
    if (!pieces[i].findings.empty()) noticed.push_back({name, estimate_from_json(pieces[i].findings, name).findings});
  }
  if (std::ranges::any_of(times, [](const RecordingTimes& one) { return !one.times.begun.empty(); }))
    estimate.tables.push_back(table_of(times));
  for (auto& finding : gathered(noticed)) estimate.findings.push_back(std::move(finding));
  for (auto& finding : lay_out(pieces).findings) estimate.findings.push_back(std::move(finding));
  estimate.title =
      plan.title.empty() ? fmt::format("{} of {} files, one record", plan.method, pieces.size()) : plan.title;
  settle_findings(estimate);
  estimate.verdicts = judge(plan.limits, estimate);
  return estimate;
}

}  // namespace tumble
