#include "tumble/formats/ros/recording.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "tumble/formats/ros/samples.hpp"

namespace tumble::ros {
namespace {

using Severity = Finding::Severity;

/// Topics of which the file holds messages that no stream reads.
std::vector<Topic> topics_not_read(const Log& log, const std::vector<Stream>& streams, const ScanReport& report) {
  std::vector<Topic> others;
  for (Topic& topic : topics_of(log)) {
    topic.count = {};
    for (const std::uint32_t id : topic.connections)
      if (const auto count = report.counts.find(id); count != report.counts.end()) topic.count.add(count->second);
    const bool is_read = std::ranges::any_of(
        streams, [&](const Stream& stream) { return stream.topic.connections == topic.connections; });
    if (!is_read && topic.count.messages > 0) others.push_back(std::move(topic));
  }
  return others;
}

topics::Played played_of(const Log& log, const std::vector<Stream>& streams, const ScanReport& report) {
  topics::Played played;
  if (report.damaged > 0) {
    played.damage.push_back({Severity::warning,
                             "log_chunks_damaged",
                             {{"damaged", report.damaged},
                              {"chunks", log.pieces.size()},
                              {"place", std::to_string(report.first_place)},
                              {"reason", report.first_reason}},
                             log.path});
    played.why.push_back(say("; {} of {} parts are damaged, the first at byte {}: {}", report.damaged,
                             log.pieces.size(), report.first_place, Sentence(report.first_reason.c_str())));
  }
  if (const auto others = topics_not_read(log, streams, report); !others.empty())
    played.not_read.push_back({Severity::info, "topics_not_read", {{"topics", described(others).text()}}, log.path});
  return played;
}

/// A log that is opened, and its streams that are read.
struct Opened {
  Log log;
  std::vector<Stream> streams;
};

}  // namespace

topics::Log topics_log(Log log, const ReadOptions& options, bool checksum) {
  topics::Log result;
  if (checksum) result.frame.origin.checksum = checksum_of(log);
  look_into_uncounted(log);
  result.frame.origin.file = log.path;
  result.two_clocks = true;
  auto streams = choose_streams(log, options, result);
  result.frame.findings = log.findings;
  const auto opened = std::make_shared<const Opened>(Opened{std::move(log), std::move(streams)});
  result.play = [opened](topics::Want, std::size_t, const topics::Take& take, const Progress& progress) {
    return played_of(opened->log, opened->streams, scan(opened->log, opened->streams, take, progress));
  };
  return result;
}

}  // namespace tumble::ros
