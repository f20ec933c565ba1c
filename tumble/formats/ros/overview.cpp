#include "tumble/formats/ros/overview.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tumble/core/instant.hpp"
#include "tumble/units/error.hpp"

namespace tumble::ros {
namespace {

using Severity = Finding::Severity;

[[noreturn]] void refuse_nothing_read(const Log& log, const std::vector<Stream>& streams,
                                      const std::vector<Overview>& overviews, const ScanReport& report) {
  std::vector<Topic> topics;
  std::size_t unreadable = 0, read = 0;
  for (const Stream& stream : streams) topics.push_back(stream.topic);
  for (const Overview& overview : overviews) unreadable += overview.unreadable, read += overview.clocks.count;
  std::vector<Sentence> why;
  if (report.damaged > 0)
    why.push_back(say("; {} of {} parts are damaged, the first at byte {}: {}", report.damaged, log.pieces.size(),
                      report.first_place, Sentence(report.first_reason.c_str())));
  if (unreadable > 0) why.push_back(say("; {} messages are not what their type says", unreadable));
  if (read > 0)
    why.push_back("; the messages state by a covariance of -1 that the instrument does not measure what is wanted");
  throw Error{Error::Kind::bad_file,
              say("'{}' holds no message of {} that can be read{}", log.path, described(topics), in_a_row(why, ""))};
}

void add_channels(const Stream& stream, const Overview& overview, std::int64_t epoch, Recording& recording) {
  std::string lacking;
  for (std::size_t i = 0; i < stream.columns.size(); ++i) {
    const Column& column = stream.columns[i];
    if (!overview.measured[i]) {
      lacking += (lacking.empty() ? "" : ", ") + column.name;
      continue;
    }
    Timeline timeline;
    if (overview.even) timeline = {seconds_after(epoch, overview.first), overview.even->rate, nullptr};
    recording.channels.push_back({column.name, kind_of(column.unit), column.unit, timeline, {}});
  }
  if (!lacking.empty())
    recording.findings.push_back({Severity::info, "not_measured", {{"channels", lacking}}, stream.topic.name});
}

void add_topics_not_read(const Log& log, const std::vector<Stream>& streams, const ScanReport& report,
                         Recording& recording) {
  std::vector<Topic> others;
  for (Topic& topic : topics_of(log)) {
    topic.count = {};
    for (const std::uint32_t id : topic.connections)
      if (const auto count = report.counts.find(id); count != report.counts.end()) topic.count.add(count->second);
    const bool is_read = std::ranges::any_of(
        streams, [&](const Stream& stream) { return stream.topic.connections == topic.connections; });
    if (!is_read && topic.count.messages > 0) others.push_back(std::move(topic));
  }
  if (!others.empty())
    recording.findings.push_back({Severity::info, "topics_not_read", {{"topics", described(others).text()}}, log.path});
}

void add_faults(const Stream& stream, const Overview& overview, Recording& recording) {
  const auto say = [&](const char* code, std::vector<FindingValue> values) {
    recording.findings.push_back({Severity::warning, code, std::move(values), stream.topic.name});
  };
  if (overview.unreadable > 0)
    say("messages_unreadable", {{"unreadable", overview.unreadable}, {"type", stream.topic.type}});
  if (overview.infinite > 0)
    recording.findings.push_back({Severity::warning,
                                  "infinite_samples",
                                  {{"topic", stream.topic.name}},
                                  "",
                                  {static_cast<std::size_t>(overview.infinite), {}, {}}});
  if (!overview.other_frame.empty())
    say("messages_of_two_frames", {{"first", overview.frame}, {"other", overview.other_frame}});
  if (overview.sorted > 0)
    recording.findings.push_back(
        {Severity::info, "log_out_of_order", {{"places", overview.sorted}}, stream.topic.name});
}

}  // namespace

std::int64_t epoch_of(const std::vector<Overview>& overviews) {
  std::optional<std::int64_t> epoch;
  for (const Overview& overview : overviews)
    if (overview.clocks.count > 0 && (!epoch || overview.first < *epoch)) epoch = overview.first;
  return epoch.value_or(0);
}

Recording frame_of(const Log& log, const std::vector<Stream>& streams, const std::vector<Overview>& overviews,
                   const ScanReport& report, const Findings& clock_findings) {
  Recording recording;
  recording.origin.file = log.path;
  recording.findings = log.findings;
  if (report.damaged > 0)
    recording.findings.push_back({Severity::warning,
                                  "log_chunks_damaged",
                                  {{"damaged", report.damaged},
                                   {"chunks", log.pieces.size()},
                                   {"place", std::to_string(report.first_place)},
                                   {"reason", report.first_reason}},
                                  log.path});
  const std::int64_t epoch = epoch_of(overviews);
  recording.meta["epoch"] = epoch_text(epoch);
  if (is_set(epoch)) recording.meta[clock_start] = iso_time(epoch) + "Z";
  std::string oriented;
  for (std::size_t i = 0; i < streams.size(); ++i) {
    const Stream& stream = streams[i];
    if (overviews[i].clocks.count > 0) {
      add_channels(stream, overviews[i], epoch, recording);
      recording.meta["topic " + stream.topic.name] = stream.topic.type;
      if (!overviews[i].frame.empty()) recording.meta["frame_id " + stream.topic.name] = overviews[i].frame;
      if (stream.topic.type == "sensor_msgs/Imu") oriented += (oriented.empty() ? "" : ", ") + stream.topic.name;
    }
    add_faults(stream, overviews[i], recording);
  }
  if (recording.channels.empty()) refuse_nothing_read(log, streams, overviews, report);
  if (!oriented.empty()) recording.findings.push_back({Severity::info, "orientation_not_read", {}, oriented});
  recording.findings.insert(recording.findings.end(), clock_findings.begin(), clock_findings.end());
  add_topics_not_read(log, streams, report, recording);
  return recording;
}

}  // namespace tumble::ros
