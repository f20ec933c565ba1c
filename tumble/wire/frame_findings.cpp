#include "tumble/wire/frame_findings.hpp"

namespace tumble {

namespace {

using Severity = Finding::Severity;

void add_losses(const FrameCounts& counts, const std::string& path, Findings& findings) {
  const auto often = [](const FrameIncident& incident) {
    return Occurrences{static_cast<std::size_t>(incident.count)};
  };
  if (counts.damaged.count > 0)
    findings.push_back(
        {Severity::warning, "frames_damaged", {{"byte", counts.damaged.first}}, path, often(counts.damaged)});
  if (counts.unreadable.count > 0)
    findings.push_back(
        {Severity::warning, "frames_not_numbers", {{"byte", counts.unreadable.first}}, path, often(counts.unreadable)});
  if (counts.gaps.count > 0)
    findings.push_back({Severity::warning,
                        "frames_lost",
                        {{"lost", counts.lost}, {"byte", counts.gaps.first}},
                        path,
                        often(counts.gaps)});
  if (counts.repeated.count > 0)
    findings.push_back(
        {Severity::warning, "frames_repeated", {{"byte", counts.repeated.first}}, path, often(counts.repeated)});
  if (counts.exchanged.count > 0)
    findings.push_back(
        {Severity::info, "frames_exchanged", {{"byte", counts.exchanged.first}}, path, often(counts.exchanged)});
  if (counts.too_late.count > 0)
    findings.push_back(
        {Severity::warning, "frames_too_late", {{"byte", counts.too_late.first}}, path, often(counts.too_late)});
  if (counts.restarts.count > 0)
    findings.push_back(
        {Severity::warning, "frames_counted_anew", {{"byte", counts.restarts.first}}, path, often(counts.restarts)});
  // A capture often begins in the middle of a frame.
  const bool only_begin = counts.skipped.count == 1 && counts.skipped.first == 0 && counts.skipped_bytes < 512;
  if (counts.skipped.count > 0)
    findings.push_back({only_begin ? Severity::info : Severity::warning,
                        "frames_skipped",
                        {{"bytes", counts.skipped_bytes}, {"byte", counts.skipped.first}},
                        path,
                        often(counts.skipped)});
  if (counts.cut > 0) findings.push_back({Severity::info, "frames_cut", {{"bytes", counts.cut}}, path});
}

void add_statuses(const FrameCodec& codec, const FrameCounts& counts, const std::string& path, Findings& findings) {
  for (std::size_t i = 0; i < codec.frames.size(); ++i)
    for (std::size_t s = 0; s < codec.frames[i].statuses.size(); ++s) {
      const FrameIncident& incident = counts.not_good[i][s];
      if (incident.count == 0) continue;
      const FrameStatus& status = codec.frames[i].statuses[s];
      findings.push_back(
          {Severity::warning,
           status.fails ? "frames_not_valid" : "frames_status",
           {{"status", status.text.empty() ? std::string("status ") + std::to_string(s + 1) : status.text},
            {"frames", incident.count},
            {"byte", incident.first}},
           path,
           Occurrences{static_cast<std::size_t>(incident.count)}});
    }
}

}  // namespace

Findings findings_of_stream(const FrameCodec& codec, const FrameCounts& counts, const std::string& where) {
  Findings findings;
  add_losses(counts, where, findings);
  add_statuses(codec, counts, where, findings);
  return findings;
}

}  // namespace tumble
