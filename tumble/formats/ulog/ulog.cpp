#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <utility>

#include "tumble/core/instant.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/formats/file/number_at.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/topics/choose.hpp"
#include "tumble/formats/topics/messages.hpp"
#include "tumble/formats/topics/read.hpp"
#include "tumble/formats/ulog/known.hpp"
#include "tumble/formats/ulog/scan.hpp"
#include "tumble/units/error.hpp"

namespace tumble::ulog {

namespace {

using topics::Log;

bool recognises(const std::string& path) { return file::begins_with(path, magic); }

[[noreturn]] void refuse(const std::string& path, const Sentence& what) {
  throw Error(Error::Kind::bad_file, say("'{}' {}", path, what));
}

/// The time of the accelerometer after that of the gyro [us] in sensor_combined, or `no_sample`.
constexpr std::string_view accelerometer_later = "accelerometer_timestamp_relative";
constexpr std::int32_t no_sample = std::numeric_limits<std::int32_t>::max();

/// The fields of a topic that become channels: of a known topic its samples, of another every number.
topics::Topic topic_of(const Scan& scan, const Scan::Topic& from) {
  topics::Topic topic{.name = from.name};
  const KnownTopic* const known = known_topic(from.format);
  topics::Burst burst;
  bool sampled = false;
  for (const Place& place : places_in(scan.definitions, from.format)) {
    if (place.field == "timestamp" || place.field == "timestamp_sample") {
      // The time of the sample, where the topic has one, rather than that of the message.
      if (place.number == topics::Number::u64 && place.length == 1 && !sampled) topic.layout.time = place.offset;
      sampled = sampled || place.field == "timestamp_sample";
      continue;
    }
    if (known && place.field == accelerometer_later && place.number == topics::Number::i32)
      topic.layout.later = place.offset;
    if (known && known->burst) {
      if (place.field == "samples") burst.count = place.offset;
      if (place.field == "dt") burst.interval = place.offset;
      if (place.field == "scale") burst.scale = place.offset;
    }
    topics::Column column{
        .field = place.field, .names = {}, .unit = {}, .offset = place.offset, .number = place.number};
    if (known && !describe(*known, instance_of(from.name), column)) continue;
    if (place.length > 1 && !(known && known->burst)) continue;
    if (known && known->burst) burst.capacity = place.length;
    topic.columns.push_back(std::move(column));
  }
  if (burst.count > 0 && burst.interval > 0 && burst.scale > 0) topic.layout.burst = burst;
  if (known && known->burst && !topic.layout.burst) topic.columns.clear();
  topic.most = from.messages * topics::most_samples(topic.layout);
  if (!topic.layout.burst) topic.samples = from.messages;
  return topic;
}

/// The topic, or its gyro and its accelerometer where these have times of their own.
std::vector<topics::Topic> halves_of(topics::Topic topic) {
  if (!topic.layout.later) return {std::move(topic)};
  topics::Topic accelerometer = topic;
  const auto felt = [](const topics::Column& column) { return column.names.front().starts_with("accelerometer"); };
  std::erase_if(topic.columns, felt);
  std::erase_if(accelerometer.columns, std::not_fn(felt));
  topic.layout.later = {};
  return {std::move(topic), std::move(accelerometer)};
}

/// What the log says of the vehicle, and the calibration that it had.
void take_meta(const Scan& scan, Recording& frame) {
  for (const char* key : {"sys_name", "ver_hw", "ver_sw", "ver_sw_branch", "sys_uuid"})
    if (const auto found = scan.information.find(key); found != scan.information.end()) frame.meta.insert(*found);
  if (scan.begun) frame.meta[clock_start] = iso_time(1000 * *scan.begun) + "Z";
  for (const char* key : {"sys_name", "ver_hw"})
    if (const auto found = frame.meta.find(key); found != frame.meta.end())
      frame.instrument += (frame.instrument.empty() ? "" : " ") + found->second;
  for (const auto& [name, value] : scan.parameters)
    if (name.starts_with("CAL_") || (name.starts_with("TC_") && value != "0" && value != "-0"))
      frame.meta[name] = value;
}

void take_damage(const Scan& scan, Findings& findings) {
  topics::name_damage(scan.damage, scan.unreadable, findings);
  const auto& lost = scan.dropouts;
  if (lost.count > 0)
    findings.push_back({Finding::Severity::warning,
                        "log_dropouts",
                        {{"total", lost.total, "s"}, {"longest", lost.longest, "s"}},
                        "",
                        {lost.count, lost.first_at, lost.longest_at}});
}

/// Up to 1.10 the drivers of PX4 corrected and filtered what they published as sensor_gyro and sensor_accel; the counts
/// stood beside it.
bool of_old_driver(const Definitions& definitions, const std::string& format) {
  const auto found = definitions.find(format);
  return found != definitions.end() && std::ranges::find(found->second, "x_raw", &Field::name) != found->second.end();
}

void say_corrected(const Scan& scan, const Log& log, Findings& findings) {
  for (const topics::Topic& topic : log.topics)
    if (const KnownTopic* known = known_topic(base_of(topic.name));
        known && (known->corrected || of_old_driver(scan.definitions, base_of(topic.name))))
      findings.push_back({Finding::Severity::warning, "corrected_topic", {{"topic", topic.name}}, topic.name});
}

/// PX4 writes the raw topics once a second unless it is asked for more, and the corrected ones at their full rate.
void say_slow(const std::vector<std::string>& names, const std::vector<std::size_t>& messages,
              const std::vector<std::size_t>& chosen, Findings& findings) {
  constexpr std::size_t far_fewer = 5;
  for (const std::size_t raw : chosen)
    for (std::size_t other = 0; other < names.size(); ++other) {
      const KnownTopic* const known = known_topic(base_of(names[raw]));
      const KnownTopic* const faster = known_topic(base_of(names[other]));
      if (!known || known->corrected || !faster || !faster->corrected) continue;
      const bool same = (known->gyro && faster->gyro) || (known->accelerometer && faster->accelerometer);
      if (!same || messages[other] < far_fewer * messages[raw]) continue;
      findings.push_back({Finding::Severity::warning,
                          "raw_topic_slow",
                          {{"topic", names[raw]},
                           {"messages", messages[raw]},
                           {"faster", names[other]},
                           {"others", messages[other]}}});
      break;
    }
}

/// A topic of the log that is read.
struct Taken {
  std::size_t topic;   ///< in Log::topics
  std::size_t time;    ///< offset of the stamp
  std::size_t later;   ///< offset of what is added to it
  std::uint64_t last;  ///< stamp [us] of the last sample
};

/// Whether a message brings a sample: that of the accelerometer may be absent, or that of the message before.
bool is_new(Taken& of, const char* message) {
  const auto later = file::number_at<std::int32_t>(message + of.later);
  const auto stamp = file::number_at<std::uint64_t>(message + of.time) + static_cast<std::uint64_t>(later);
  return later != no_sample && std::exchange(of.last, stamp) != stamp;
}

/// The messages of these topics, whose sources are topics of the scan.
topics::Messages messages_of(const std::string& path, const Scan& scan, const std::vector<topics::Topic>& topics) {
  std::vector<std::vector<Taken>> whole(scan.topics.size()), with_own_time(scan.topics.size());
  for (std::size_t i = 0; i < topics.size(); ++i) {
    const topics::Layout& layout = topics[i].layout;
    (layout.later ? with_own_time : whole)[topics[i].source].push_back(
        {i, layout.time, layout.later.value_or(0), std::numeric_limits<std::uint64_t>::max()});
  }
  return [path, whole, with_own_time](const topics::TakeMessage& take, const Progress& progress) {
    auto late = with_own_time;
    replay(path, progress, [&](std::size_t topic, const char* sample) {
      for (const Taken& of : whole[topic]) take(of.topic, sample);
      for (Taken& of : late[topic])
        if (is_new(of, sample)) take(of.topic, sample);
    });
  };
}

/// Topics with samples; the instances of one in their order, in which a log may not name them.
std::vector<std::size_t> sampled(const Scan& scan) {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < scan.topics.size(); ++i)
    if (scan.topics[i].messages > 0) indices.push_back(i);
  const auto place = [&](std::size_t i) {
    const auto first = std::ranges::find(scan.topics, scan.topics[i].format, &Scan::Topic::format);
    return std::pair{first - scan.topics.begin(), instance_of(scan.topics[i].name)};
  };
  std::ranges::stable_sort(indices, {}, place);
  return indices;
}

/// Reads everything but the samples.
Log open(const std::string& path, const ReadOptions& options, bool checksum) {
  Log log;
  log.frame.origin.file = path;
  if (checksum) log.frame.origin.checksum = sha256_in_background(path);
  if (!recognises(path)) refuse(path, "is no ULog: it does not begin with ULog and the version");
  const Scan found = scan(path);
  std::vector<std::string> names;
  std::vector<std::size_t> messages, indices = sampled(found);
  for (const std::size_t i : indices) {
    names.push_back(found.topics[i].name);
    messages.push_back(found.topics[i].messages);
  }
  if (names.empty() && !found.unreadable.empty())
    refuse(path, say("holds no samples that can be read: there is no description, no timestamp of 64 bits, or "
                     "there are two descriptions of {}",
                     fmt::join(found.unreadable, ", ")));
  if (names.empty()) refuse(path, "holds no samples: no message of a described topic (is it cut off?)");
  const auto chosen =
      options.topics.empty() ? preferred(names, messages) : topics::asked_for(names, options.topics, path);
  if (chosen.empty())
    refuse(path, say("has no topic of a gyro or an accelerometer; name one with --topic: {}", fmt::join(names, ", ")));
  for (const std::size_t i : chosen)
    for (topics::Topic& topic : halves_of(topic_of(found, found.topics[indices[i]]))) {
      topic.source = indices[i];
      log.topics.push_back(std::move(topic));
    }
  take_meta(found, log.frame);
  take_damage(found, log.frame.findings);
  say_corrected(found, log, log.frame.findings);
  say_slow(names, messages, chosen, log.frame.findings);
  topics::name_the_others(names, chosen, log.frame.findings);
  topics::name_channels(options, log);
  topics::play_messages(messages_of(path, found, log.topics), log);
  return log;
}

}  // namespace

extern const Format ulog{.name = "ulog",
                         .summary = "log of the autopilot PX4: topics such as sensor_gyro:0",
                         .extensions = {".ulg"},
                         .recognises = recognises,
                         .read = topics::read_file<open>,
                         .memory = topics::memory_of_file<open>,
                         .stream = topics::stream_file<open>};

}  // namespace tumble::ulog
