#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "tumble/checks/check.hpp"
#include "tumble/core/roles.hpp"
#include "tumble/formats/conflicts.hpp"
#include "tumble/formats/recorded_findings.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble {
namespace {

constexpr std::size_t samples_at_a_time = 1 << 20;

/// Adds the samples of one block to a summary. Mean and variance by the update for joined sets of Chan, Golub and
/// LeVeque (1979), their equation 2.1: exact for blocks of any size, no cancellation. `summary.sd` holds the sum of
/// squares until finish().
void add(const Channel& channel, ChannelSummary& summary) {
  double sum = 0.0;
  std::size_t present = 0;
  for (const double value : channel.values) {
    if (std::isnan(value)) continue;
    sum += value;
    ++present;
    summary.minimum = std::min(summary.minimum, value);
    summary.maximum = std::max(summary.maximum, value);
  }
  const auto before = static_cast<double>(summary.samples - summary.missing);
  summary.samples += channel.values.size();
  summary.missing += channel.values.size() - present;
  if (!channel.values.empty()) summary.last = channel.time(channel.values.size() - 1);
  if (present == 0) return;
  const auto count = static_cast<double>(present);
  const double mean = sum / count;
  double squares = 0.0;
  for (const double value : channel.values)
    if (!std::isnan(value)) squares += (value - mean) * (value - mean);
  const double shift = mean - summary.mean;
  summary.sd += squares + shift * shift * before * count / (before + count);
  summary.mean += shift * count / (before + count);
}

ChannelSummary begin(const Channel& channel) {
  ChannelSummary summary;
  summary.name = channel.name;
  summary.kind = channel.kind;
  summary.unit = channel.unit;
  summary.uniform = channel.timeline.uniform();
  summary.first = channel.values.empty() ? channel.timeline.start : channel.time(0);
  summary.minimum = std::numeric_limits<double>::infinity();
  summary.maximum = -summary.minimum;
  return summary;
}

void finish(ChannelSummary& summary) {
  const auto present = summary.samples - summary.missing;
  const double none = std::numeric_limits<double>::quiet_NaN();
  summary.sd = present > 1 ? std::sqrt(summary.sd / static_cast<double>(present - 1)) : none;
  if (present == 0) summary.minimum = summary.mean = summary.maximum = none;
}

void add(const Recording& block, Inspection& inspection) {
  if (inspection.channels.empty()) {
    inspection.header = {block.instrument, {}, block.marks, block.origin, block.meta, {}, block.recognised};
    inspection.header.meta.erase(std::string(recorded_findings_key));  // they are among the findings
    for (const auto& channel : block.channels) inspection.channels.push_back(begin(channel));
  }
  for (std::size_t i = 0; i < block.channels.size(); ++i) add(block.channels[i], inspection.channels[i]);
  inspection.findings.insert(inspection.findings.end(), block.findings.begin(), block.findings.end());
}

/// The table for a plan, and the words for the command line, of columns whose names say an IMU's roles in their own
/// way.
void propose_roles(Inspection& inspection) {
  std::vector<NamedKind> columns;
  for (const auto& channel : inspection.channels) columns.push_back({channel.name, channel.kind});
  std::string table, words;
  for (const auto& [role, channel] : proposed_roles(columns)) {
    table += (table.empty() ? "" : ", ") + role + " = \"" + channel + "\"";
    words += (words.empty() ? "" : " ") + ("--set channels." + role) + "=" + channel;
  }
  if (table.empty()) return;
  inspection.header.recognised.push_back({"[channels]", table + " (in a plan, for methods of an IMU)"});
  inspection.header.recognised.push_back({"or say", words});
}

/// [bytes] of a file, or of the samples in a folder.
std::uintmax_t size_of(const std::string& path, const ReadOptions& options) {
  std::error_code unknown;
  const auto size = std::filesystem::file_size(path, unknown);
  if (!unknown) return size;
  return std::filesystem::is_directory(path, unknown) ? recording_memory(format_of(path, options), path, options) : 0;
}

}  // namespace

Inspection inspect(const std::string& path, const ReadOptions& options, const Progress& progress,
                   std::uintmax_t whole_below) {
  Inspection inspection;
  if (size_of(path, options) <= whole_below) {
    const auto recording = read_recording(path, options, progress);
    refuse_conflicts(recording, options);
    add(recording, inspection);
    const auto found = run_checks(recording, nullptr);
    inspection.findings.insert(inspection.findings.end(), found.begin(), found.end());
    if (options.rate && std::ranges::all_of(recording.channels, [](const Channel& c) { return c.timeline.uniform(); }))
      for (auto& finding : against_stated_rate(recording, *options.rate))
        inspection.findings.push_back(std::move(finding));
  } else {
    stream_recording(
        format_of(path, options), path, options, samples_at_a_time,
        [&](const Recording& block) {
          if (inspection.channels.empty()) refuse_conflicts(block, options);
          add(block, inspection);
        },
        progress);
    inspection.findings.push_back({Finding::Severity::info, "too_large_for_checks", {}, path});
  }
  for (auto& channel : inspection.channels) finish(channel);
  propose_roles(inspection);
  return inspection;
}

}  // namespace tumble
