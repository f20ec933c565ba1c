#include "tumble/formats/topics/overview.hpp"

#include <algorithm>
#include <map>

#include "tumble/core/instant.hpp"
#include "tumble/units/error.hpp"

namespace tumble::topics {
namespace {

using Severity = Finding::Severity;

[[noreturn]] void refuse_nothing_read(const Log& log, const std::vector<Overview>& overviews, const Played& played) {
  std::size_t unreadable = 0, read = 0;
  for (const Overview& overview : overviews) unreadable += overview.unreadable, read += overview.count;
  std::vector<Sentence> why = played.why;
  if (unreadable > 0) why.push_back(say("; {} messages are not what their type says", unreadable));
  if (read > 0)
    why.push_back("; the messages state by a covariance of -1 that the instrument does not measure what is wanted");
  throw Error{Error::Kind::bad_file, say("'{}' holds no message of {} that can be read{}", log.frame.origin.file,
                                         log.wanted, in_a_row(why, ""))};
}

void add_channels(const Topic& topic, const Overview& overview, Recording& recording) {
  std::string lacking;
  for (std::size_t i = 0; i < topic.columns.size(); ++i) {
    const Column& column = topic.columns[i];
    if (is_channel(topic, overview, i))
      recording.channels.push_back({column.name(), kind_of(*column.unit), *column.unit, {}, {}});
    else
      lacking += (lacking.empty() ? "" : ", ") + column.name();
  }
  if (!lacking.empty())
    recording.findings.push_back({Severity::info, "not_measured", {{"channels", lacking}}, topic.name});
}

void add_meta(const Topic& topic, const Overview& overview, Recording& recording) {
  if (!topic.type.empty()) recording.meta["topic " + topic.name] = topic.type;
  if (!overview.frame.empty()) recording.meta["frame_id " + topic.name] = overview.frame;
}

void add_faults(const Topic& topic, const Overview& overview, Findings& findings) {
  const auto say = [&](Severity severity, const char* code, std::vector<FindingValue> values) {
    findings.push_back({severity, code, std::move(values), topic.name});
  };
  if (overview.unreadable > 0)
    say(Severity::warning, "messages_unreadable", {{"unreadable", overview.unreadable}, {"type", topic.type}});
  if (overview.infinite > 0) findings.push_back(infinite_samples(topic, overview.infinite));
  if (!overview.other_frame.empty())
    say(Severity::warning, "messages_of_two_frames", {{"first", overview.frame}, {"other", overview.other_frame}});
  if (overview.sorted > 0) say(Severity::info, "log_out_of_order", {{"places", overview.sorted}});
}

/// What the messages of the topics hold beside their columns.
void add_others(const std::vector<Topic>& topics, const std::vector<Overview>& overviews, Findings& findings) {
  std::map<std::string, std::string> others;
  for (std::size_t i = 0; i < topics.size(); ++i) {
    if (*topics[i].other == '\0' || overviews[i].count == 0) continue;
    std::string& where = others[topics[i].other];
    where += (where.empty() ? "" : ", ") + topics[i].name;
  }
  for (const auto& [code, where] : others) findings.push_back({Severity::info, code, {}, where});
}

void append(const Findings& from, Findings& to) { to.insert(to.end(), from.begin(), from.end()); }

}  // namespace

std::vector<Overview> overviews_of(const std::vector<Topic>& topics) {
  std::vector<Overview> overviews(topics.size());
  for (std::size_t i = 0; i < topics.size(); ++i) overviews[i].measured.assign(topics[i].columns.size(), 0);
  return overviews;
}

void note(std::span<const Stretch* const> stretches, std::vector<Overview>& overviews) {
  for (const Stretch* stretch : stretches)
    for (std::size_t i = 0; i < overviews.size(); ++i) {
      const Samples& samples = (*stretch)[i];
      Overview& overview = overviews[i];
      overview.count += samples.count;
      overview.unreadable += samples.unreadable;
      overview.values_seen = !samples.values.empty();
      for (const std::string* const frame : {&samples.frame, &samples.other_frame}) {
        if (overview.frame.empty()) overview.frame = *frame;
        if (overview.other_frame.empty() && *frame != overview.frame) overview.other_frame = *frame;
      }
      for (std::size_t c = 0; c < overview.measured.size(); ++c) overview.measured[c] |= samples.measured[c];
    }
}

std::int64_t set_epoch(const Log& log, std::vector<Overview>& overviews) {
  if (!log.two_clocks) return 0;
  std::optional<std::int64_t> epoch;
  for (const Overview& overview : overviews)
    if (overview.count > 0 && (!epoch || overview.first < *epoch)) epoch = overview.first;
  const std::int64_t zero = epoch.value_or(0);
  for (Overview& overview : overviews)
    if (overview.even) overview.even->start = seconds_after(zero, overview.first);
  return zero;
}

Finding infinite_samples(const Topic& topic, std::size_t count) {
  return {Severity::warning, "infinite_samples", {{"topic", topic.name}}, "", {count, {}, {}}};
}

Recording frame_of(const Log& log, const std::vector<Overview>& overviews, std::int64_t epoch, const Played& played,
                   const Findings& clock_findings) {
  Recording recording = log.frame;
  append(played.damage, recording.findings);
  if (log.two_clocks) {
    recording.meta["epoch"] = epoch_text(epoch);
    if (is_set(epoch)) recording.meta[clock_start] = iso_time(epoch) + "Z";
  }
  for (std::size_t i = 0; i < log.topics.size(); ++i) {
    const bool any = overviews[i].count > 0 || !log.topics[i].may_lack;
    if (any) {
      add_channels(log.topics[i], overviews[i], recording);
      add_meta(log.topics[i], overviews[i], recording);
    }
    add_faults(log.topics[i], overviews[i], recording.findings);
  }
  if (recording.channels.empty()) refuse_nothing_read(log, overviews, played);
  add_others(log.topics, overviews, recording.findings);
  append(clock_findings, recording.findings);
  append(played.not_read, recording.findings);
  return recording;
}

}  // namespace tumble::topics
