#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/instant.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/formats/dataflash/known.hpp"
#include "tumble/formats/file/input_file.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/topics/choose.hpp"
#include "tumble/formats/topics/messages.hpp"
#include "tumble/formats/topics/read.hpp"
#include "tumble/units/error.hpp"

namespace tumble::dataflash {

namespace {

using topics::Log;

bool recognises(const std::string& path) { return file::begins_with(path, magic); }

[[noreturn]] void refuse(const std::string& path, const Sentence& what) {
  throw Error(Error::Kind::bad_file, say("'{}' {}", path, what));
}

/// A unit of FMTU that is one of ours.
std::optional<Unit> unit_of(const Scan& scan, char character) {
  const auto found = scan.units.find(character);
  if (found == scan.units.end() || character == '?') return std::nullopt;
  const std::string& label = found->second;
  try {
    return label.empty() ? Unit() : Unit::parse(label == "m/s/s" ? "m/s^2" : label);
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// What one count of a field is worth: by the multiplier of FMTU, which replaces the one that the type implies unless
/// it is "?", which ArduPilot writes where nobody has stated one yet.
double scale_of(const Scan& scan, const FieldUnits& units, std::size_t index, char type) {
  if (index < units.multipliers.size() && units.multipliers[index] != '?') {
    const auto found = scan.multipliers.find(units.multipliers[index]);
    if (found != scan.multipliers.end() && found->second > 0.0 && std::isfinite(found->second)) return found->second;
  }
  if (type == 'c' || type == 'C' || type == 'e' || type == 'E') return 0.01;
  return type == 'L' ? 1e-7 : 1.0;
}

/// The fields of a stream that become channels: of known messages the samples, of others every number.
topics::Topic topic_of(const Scan& scan, const Stream& stream) {
  const Description& description = scan.descriptions[stream.id];
  const FieldUnits& units = scan.field_units[stream.id];
  const Field* const time = time_field(description);
  const Field* const instance = scan.instance_field(stream.id);
  topics::Topic topic{.name = stream.name, .samples = stream.messages, .most = stream.messages};
  topic.layout = {.time = time->offset, .time_number = *number_of(time->type), .ticks = ticks_of(*time)};
  for (std::size_t i = 0; i < description.fields.size(); ++i) {
    const Field& field = description.fields[i];
    const auto number = number_of(field.type);
    if (!number || &field == instance || field.label == "TimeUS" || field.label == "TimeMS" || &field == time) continue;
    topics::Column column{.field = field.label, .names = {}, .unit = {}, .offset = field.offset, .number = *number};
    column.scale = scale_of(scan, units, i, field.type);
    if (i < units.units.size()) column.unit = unit_of(scan, units.units[i]);
    if (known_message(description.name) && !describe(instance_of(stream, description.name), column)) continue;
    topic.columns.push_back(std::move(column));
  }
  return topic;
}

/// Streams with a time and a number, whose description is clear; the instances of one in their order, in which a log
/// may not begin.
std::vector<std::size_t> readable(const Scan& scan) {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < scan.streams.size(); ++i) {
    const Description& description = scan.descriptions[scan.streams[i].id];
    if (!description.ambiguous && time_field(description) && !topic_of(scan, scan.streams[i]).columns.empty())
      indices.push_back(i);
  }
  const auto place = [&](std::size_t i) {
    const auto first = std::ranges::find(scan.streams, scan.streams[i].id, &Stream::id);
    return std::pair{first - scan.streams.begin(), scan.streams[i].instance};
  };
  std::ranges::stable_sort(indices, {}, place);
  return indices;
}

void take_meta(const Scan& scan, Recording& frame) {
  frame.instrument = scan.firmware;
  for (const auto& [name, value] : scan.parameters)
    if (name.starts_with("INS_GYR") || name.starts_with("INS_ACC") || name == "AHRS_ORIENTATION" ||
        name == "INS_RAW_LOG_OPT" || (name.starts_with("INS_TCAL") && value != 0.0))
      frame.meta[name] = fmt::format("{}", static_cast<float>(value));
}

/// Date and time of the first sample, where a GPS receiver said them.
void take_start(const Scan& scan, const std::vector<topics::Topic>& topics, Recording& frame) {
  std::optional<double> first;
  for (const topics::Topic& topic : topics)
    if (const auto& own = scan.streams[topic.source].first; own && (!first || *own < *first)) first = own;
  constexpr double latest = 1e9;  // s
  if (scan.started && first && *first < latest)
    frame.meta[clock_start] = iso_time(*scan.started + std::llround(1e6 * *first) * 1000) + "Z";
}

/// Names of messages that cannot be read.
std::vector<std::string> unreadable(const Scan& scan) {
  std::vector<std::string> names;
  for (const Description& description : scan.descriptions)
    if (description.ambiguous || (!description.name.empty() && description.fields.empty()))
      names.push_back(description.name);
  return names;
}

void take_damage(const Scan& scan, Findings& findings) {
  topics::name_damage(scan.damage, unreadable(scan), findings);
  if (scan.rejected > 0.0)
    findings.push_back({Finding::Severity::warning, "log_rejected", {{"number", scan.rejected}}});
}

/// Without them (a log whose beginning is missing) nothing says that the corrections are neutral.
bool has_parameters_of_sensors(const Scan& scan) {
  return std::ranges::any_of(scan.parameters, [](const auto& one) { return one.first.starts_with("INS_"); });
}

void say_corrected(const Scan& scan, const std::vector<topics::Topic>& topics, Findings& findings) {
  std::vector<std::string> all;
  for (const topics::Topic& topic : topics) {
    const Stream& stream = scan.streams[topic.source];
    const std::string& name = scan.descriptions[stream.id].name;
    const KnownMessage* const known = known_message(name);
    if (!known) continue;
    if (!has_parameters_of_sensors(scan))
      findings.push_back({Finding::Severity::warning, "corrected_topic", {{"topic", stream.name}}, stream.name});
    for (auto& parameter : corrections(scan, *known, instance_of(stream, name)))
      if (std::ranges::find(all, parameter) == all.end()) all.push_back(std::move(parameter));
  }
  if (!all.empty())
    findings.push_back({Finding::Severity::warning,
                        "corrected_by_parameters",
                        {{"parameters", fmt::format("{}", fmt::join(all, ", "))}}});
}

/// Topics of the messages: by id, and by instance where there is a field for it.
struct Route {
  const Field* instance = nullptr;
  std::vector<int> topics = std::vector<int>(256, -1);
};

/// The messages of these topics, whose sources are streams of the scan.
topics::Messages messages_of(const std::string& path, const std::shared_ptr<const Scan>& scan,
                             const std::vector<topics::Topic>& topics) {
  auto routes = std::make_shared<std::vector<std::optional<Route>>>(256);
  for (std::size_t i = 0; i < topics.size(); ++i) {
    const Stream& stream = scan->streams[topics[i].source];
    auto& route = (*routes)[stream.id];
    if (!route) route = Route{stream.instance < 0 ? nullptr : scan->instance_field(stream.id)};
    route->topics[stream.instance < 0 ? 0 : static_cast<std::size_t>(stream.instance)] = static_cast<int>(i);
  }
  return [path, scan, routes](const topics::TakeMessage& take, const Progress& progress) {
    Descriptions descriptions;
    walk(path, descriptions, progress, [&](std::uint8_t id, const char* message) {
      const auto& route = (*routes)[id];
      if (!route) return;
      const int topic =
          route->topics[route->instance ? static_cast<unsigned char>(message[route->instance->offset]) : 0];
      if (topic >= 0) take(static_cast<std::size_t>(topic), message);
    });
  };
}

/// Reads everything but the samples.
Log open(const std::string& path, const ReadOptions& options, bool checksum) {
  Log log;
  log.frame.origin.file = path;
  if (checksum) log.frame.origin.checksum = sha256_in_background(path);
  if (!recognises(path))
    refuse(path, "is not a recording that can be read: it does not begin with the bytes A3 95 of a DataFlash log");
  const auto found = std::make_shared<const Scan>(scan(path));
  const auto streams = readable(*found);
  std::vector<std::string> names;
  for (const std::size_t i : streams) names.push_back(found->streams[i].name);
  if (names.empty())
    refuse(path,
           "holds no samples: no message that FMT describes has a time and numbers (is it cut off, or its beginning "
           "missing?)");
  const auto chosen =
      options.topics.empty() ? preferred(*found, streams) : topics::asked_for(names, options.topics, path);
  if (chosen.empty())
    refuse(path, say("has no messages of a gyro or an accelerometer: IMU, GYR, ACC{}; name others with --topic: {}",
                     found->damage.undescribed > 0 ? " (it holds messages without FMT: is its beginning missing?)"
                                                   : " (is it cut off?)",
                     fmt::join(names, ", ")));
  for (const std::size_t i : chosen) {
    log.topics.push_back(topic_of(*found, found->streams[streams[i]]));
    log.topics.back().source = streams[i];
  }
  take_meta(*found, log.frame);
  take_damage(*found, log.frame.findings);
  say_corrected(*found, log.topics, log.frame.findings);
  topics::name_the_others(names, chosen, log.frame.findings);
  topics::name_channels(options, log);
  take_start(*found, log.topics, log.frame);
  topics::play_messages(messages_of(path, found, log.topics), log);
  return log;
}

}  // namespace

extern const Format dataflash{.name = "dataflash",
                              .summary = "log of the autopilot ArduPilot: messages such as IMU:0",
                              .extensions = {".bin"},
                              .recognises = recognises,
                              .read = topics::read_file<open>,
                              .memory = topics::memory_of_file<open>,
                              .stream = topics::stream_file<open>};

}  // namespace tumble::dataflash
