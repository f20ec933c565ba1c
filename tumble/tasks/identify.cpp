#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <functional>

#include "tumble/checks/check.hpp"
#include "tumble/tasks/calibration.hpp"
#include "tumble/tasks/plausible.hpp"
#include "tumble/tasks/sets.hpp"
#include "tumble/tasks/streamed.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// Whether the method has reported already what a check reports of the segments of the plan.
bool is_reported(const Finding& checked, const Findings& reported) {
  const auto text = [](const Finding& finding) {
    const auto* name = finding.values.empty() ? nullptr : std::get_if<std::string>(&finding.values.front().value);
    return name ? *name : std::string();
  };
  return std::ranges::any_of(reported, [&](const Finding& finding) {
    return (checked.code == "segment_not_recorded" && finding.code == "not_recorded") ||
           (checked.code == "segment_not_scheduled" && finding.code == "segment_not_used" &&
            text(checked) == text(finding));
  });
}

/// What the readers and the checks noticed, with the file where there are several.
void add_data_findings(const Evidence& evidence, Findings& findings) {
  const Findings reported = findings;
  for (std::size_t i = 0; i < evidence.recordings.size(); ++i) {
    const auto& recording = evidence.recordings[i];
    auto found = recording.findings;
    const auto checked = run_checks(recording, &plan_of(evidence, i));
    found.insert(found.end(), checked.begin(), checked.end());
    for (auto& finding : found) {
      if (is_reported(finding, reported)) continue;
      if (evidence.recordings.size() > 1)
        finding.where = recording.origin.file + (finding.where.empty() ? "" : ", " + finding.where);
      findings.push_back(std::move(finding));
    }
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
  estimate.instrument_serial = plan.instrument_serial;
  for (const auto& [key, text] : plan.settings.texts()) estimate.provenance.settings[key] = text;
  for (const auto& [role, choices] : plan.channels) estimate.provenance.settings["channels." + role] = listed(choices);
}

/// Which channel played each role: compensate takes the same. The seed, where the data were simulated.
void add_origin(const Evidence& evidence, Provenance& provenance) {
  add_calibration(evidence.plan, provenance);
  for (const auto& recording : evidence.recordings) {
    provenance.inputs.push_back({recording.origin.file, sha256_of(recording.origin)});
    for (const auto& role : find_method(evidence.plan.method).roles())
      if (const auto* channel = channel_for(evidence, recording, role.name))
        provenance.settings["channels." + role.name] = channel->name;
    if (const auto seed = recording.meta.find("seed"); seed != recording.meta.end()) {
      unsigned long long value = 0;
      const auto& text = seed->second;
      if (std::from_chars(text.data(), text.data() + text.size(), value).ec == std::errc()) provenance.seed = value;
    }
  }
}

/// The method's own work. It knows channels but no files: where there is one file its name goes before what is refused.
Estimate reduce(const std::function<Estimate()>& work, const std::string& file) try {
  return work();
} catch (const Error& error) {
  if (error.kind != Error::Kind::bad_data) throw;
  auto problems = error.problems;
  for (auto& problem : problems)
    if (!file.empty() && problem.find(file) == std::string::npos) problem.insert(0, file + ": ");
  throw Error(error.kind, problems);
}

void complete(const Evidence& evidence, Estimate& estimate) {
  describe(evidence.plan, estimate);
  add_origin(evidence, estimate.provenance);
  estimate.title = evidence.plan.title.empty() ? default_title(evidence) : evidence.plan.title;
}

Estimate identify(const Streamed& streamed, std::uintmax_t memory, const Progress& progress) {
  const Plan& plan = streamed.evidence.plan;
  Evidence evidence{plan, std::vector<Recording>(1)};
  auto estimate = reduce([&] { return find_method(plan.method).stream(streamed.evidence, progress); }, streamed.file);
  evidence.recordings[0] = *streamed.header;
  evidence.recordings[0].origin.checksum = streamed.checksum;
  complete(evidence, estimate);
  const Findings& noticed = evidence.recordings[0].findings;
  estimate.findings.insert(estimate.findings.end(), noticed.begin(), noticed.end());
  estimate.findings.push_back(
      {Finding::Severity::info, "processed_in_blocks", {{"size", streamed.bytes}, {"memory", memory}}, streamed.file});
  estimate.verdicts = judge(plan.limits, estimate, estimate.findings);
  return estimate;
}

}  // namespace

Estimate identify(const Evidence& evidence, const Progress& progress) {
  const std::string file = evidence.recordings.size() == 1 ? evidence.recordings[0].origin.file : "";
  auto estimate = reduce([&] { return find_method(evidence.plan.method).identify(evidence, progress); }, file);
  for (auto& finding : implausible(estimate)) estimate.findings.push_back(std::move(finding));
  for (auto& finding : about_site(evidence.plan)) estimate.findings.push_back(std::move(finding));
  for (auto& finding : ruled_by_site(evidence.plan, estimate)) estimate.findings.push_back(std::move(finding));
  add_data_findings(evidence, estimate.findings);
  complete(evidence, estimate);
  estimate.verdicts = judge(evidence.plan.limits, estimate, estimate.findings);
  return estimate;
}

Estimate identify(const Plan& plan, const std::vector<std::string>& recordings, std::uintmax_t memory,
                  const Progress& progress) {
  if (const auto streamed = open_stream(plan, recordings, memory, progress))
    return identify(*streamed, memory, progress);
  return identify(gather(plan, recordings, progress), progress);
}

Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan* plan) {
  const auto& method = find_method(estimate.method);
  if (!method.compensate)
    throw Error(Error::Kind::unsupported,
                estimate.method + " identifies no error model that could be subtracted from a recording");
  return method.compensate(estimate, recording, plan);
}

}  // namespace tumble
