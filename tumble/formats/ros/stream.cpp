#include "tumble/formats/ros/stream.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <string_view>

#include "tumble/formats/topics/choose.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble::ros {
namespace {

using Topics = std::vector<Topic>;

constexpr std::string_view imu = "sensor_msgs/Imu", vector = "geometry_msgs/Vector3Stamped";

std::string_view without_slash(std::string_view name) { return name.starts_with('/') ? name.substr(1) : name; }

bool readable(const Topic& topic) { return topic.encoding != Encoding::other && find_message_type(topic.type); }

/// "/imu/" for "/imu/data".
std::string_view room_of(std::string_view name) { return name.substr(0, name.rfind('/') + 1); }

/// "imu.data" for "/imu/data".
std::string as_prefix(std::string_view topic) {
  std::string text(without_slash(topic));
  std::ranges::replace(text, '/', '.');
  return text;
}

/// As it is typed in a shell.
std::string as_word(const std::string& name) {
  const bool plain =
      std::ranges::all_of(name, [](unsigned char c) { return std::isalnum(c) != 0 || c == '/' || c == '_'; });
  return plain ? name : "'" + name + "'";
}

[[noreturn]] void refuse(const Log& log, const Sentence& what) {
  throw Error{Error::Kind::bad_file, say("'{}' {}", log.path, what)};
}

[[noreturn]] void refuse_to_guess(const Log& log, const Topics& candidates) {
  const auto raw =
      std::ranges::find_if(candidates, [](const Topic& topic) { return topic.name.find("raw") != std::string::npos; });
  const Topic& example = raw == candidates.end() ? candidates.front() : *raw;
  refuse(log, say("holds {} topics that can be read: {}; name the one to read: --topic {}, or in the plan, "
                  "[[recording]] topics = [\"{}\"]",
                  candidates.size(), described(candidates), Name{as_word(example.name)}, example.name));
}

[[noreturn]] void refuse_all(const Log& log, const Topics& topics) {
  std::vector<Sentence> damage;
  for (const Finding& finding : log.findings)
    if (finding.severity == Finding::Severity::warning) damage.push_back(say("; {}", said_of(finding)));
  if (topics.empty()) refuse(log, say("holds no message{}", in_a_row(damage, "")));
  const auto sampled = std::ranges::find_if(
      topics, [](const Topic& topic) { return readable(topic) && topic.type == vector && topic.count.messages > 0; });
  if (sampled != topics.end()) {
    const std::string channel = as_prefix(sampled->name);
    refuse(log, say("has nothing that is read without being named: {}. A {} states no unit: name the topic and "
                    "give the units, --topic {} --set unit.{}.x=rad/s --set unit.{}.y=rad/s "
                    "--set unit.{}.z=rad/s{}",
                    described(topics), Name{std::string(vector)}, Name{as_word(sampled->name)}, Name{channel},
                    Name{channel}, Name{channel}, in_a_row(damage, "")));
  }
  if (std::ranges::any_of(topics, readable))
    refuse(log, say("holds no message of {}{}", described(topics), in_a_row(damage, "")));
  refuse(log, say("holds no topic of a type that is read ({}): its topics are {}{}", Name{known_message_types()},
                  described(topics), in_a_row(damage, "")));
}

Topics of_type(const Topics& topics, std::string_view type) {
  Topics found;
  for (const Topic& topic : topics)
    if (topic.type == type) found.push_back(topic);
  return found;
}

/// Of the topics of one type, the one that belongs to the IMU.
const Topic* companion(const Topics& of_one_type, std::string_view imu_name) {
  if (of_one_type.size() == 1) return &of_one_type.front();
  const Topic* found = nullptr;
  for (const Topic& topic : of_one_type) {
    if (room_of(topic.name) != room_of(imu_name)) continue;
    if (found) return nullptr;
    found = &topic;
  }
  return found;
}

Topics read_by_default(Log& log) {
  Topics topics = topics_of(log), candidates;
  const auto find = [&] {
    candidates.clear();
    for (const Topic& topic : topics)
      if (readable(topic) && topic.type != vector && (topic.count.messages > 0 || log.messages_at_most > 0))
        candidates.push_back(topic);
  };
  find();
  if (log.messages_at_most > 0 && candidates.size() != 1) {  // some may be empty
    count_messages(log);
    topics = topics_of(log);
    find();
  }
  if (candidates.empty()) refuse_all(log, topics);
  const Topics imus = of_type(candidates, imu);
  if (imus.size() > 1) refuse_to_guess(log, imus);
  Topics chosen = imus;
  std::vector<std::string> done{std::string(imu)};
  for (const Topic& topic : candidates) {
    if (std::ranges::find(done, topic.type) != done.end()) continue;
    done.push_back(topic.type);
    const Topics alike = of_type(candidates, topic.type);
    if (imus.empty() && alike.size() > 1) refuse_to_guess(log, candidates);
    if (const Topic* one = companion(alike, imus.empty() ? topic.name : imus.front().name)) chosen.push_back(*one);
  }
  return chosen;
}

Topics named(const Log& log, const std::vector<std::string>& names) {
  const Topics topics = topics_of(log);
  std::vector<std::string> known;
  for (const Topic& topic : topics) known.push_back(topic.name);
  const auto alike = [&](const Topic& topic, const std::string& name) {
    return without_slash(topic.name) == without_slash(name);
  };
  const auto is_meant = [&](std::size_t index, const std::string& name) {
    const auto of_name = [&](const Topic& topic) { return alike(topic, name) && readable(topic); };
    return std::ranges::find_if(topics, of_name) - topics.begin() == static_cast<std::ptrdiff_t>(index);
  };
  const auto refusal = [&](const std::string& name) -> Problem {
    const auto present = std::ranges::find_if(topics, [&](const Topic& topic) { return alike(topic, name); });
    if (present == topics.end())
      return say("'{}' has no topic '{}'{}; its topics are {}", log.path, name, did_you_mean(name, known),
                 described(topics));
    return say("'{}': topic {} is of a type that is not read; those that are read are {}", log.path,
               described(*present), Name{known_message_types()});
  };
  Topics chosen;
  for (const std::size_t i : topics::asked_for(topics.size(), names, is_meant, refusal)) chosen.push_back(topics[i]);
  return chosen;
}

std::vector<topics::Column> columns_of(const Topic& topic, bool several) {
  std::vector<topics::Column> columns;
  for (const Part& part : find_message_type(topic.type)->parts) {
    const std::string own = part.name;
    const std::string name =
        own.empty() ? as_prefix(topic.name) : (several ? as_prefix(topic.name) + "." : std::string()) + own;
    std::optional<Unit> unit;
    if (*part.unit != '\0') unit = Unit::parse(part.unit);
    for (std::size_t i = 0; i < part.count; ++i) {
      const std::string axis = part.count == 1 ? "" : std::string(".") + "xyz"[i];
      columns.push_back({.field = own + axis,
                         .names = {name + axis},
                         .unit = unit,
                         .offset = (part.first + i) * sizeof(double),
                         .number = topics::Number::f64});
    }
  }
  return columns;
}

/// At most so many messages of a topic: as the index says, and as the file has room for.
std::size_t most_messages(const Log& log, const Topic& topic) {
  const std::uint64_t message = 8 * find_message_type(topic.type)->numbers + 12;
  const std::uint64_t known = log.messages_at_most > 0 ? log.messages_at_most : topic.count.messages;
  std::uint64_t bytes = size_of(log);
  for (const Piece& piece : log.pieces)
    if (piece.packing != Packing::none) bytes += std::min(piece.unpacked, piece.size * 256);
  return std::min(known, bytes / message);
}

topics::Topic topic_of(const Log& log, const Topic& from, bool several) {
  topics::Topic topic{.name = from.name, .type = from.type, .may_lack = true};
  if (from.type == imu) topic.other = "orientation_not_read";
  topic.samples = topic.most = most_messages(log, from);
  topic.columns = columns_of(from, several);
  return topic;
}

/// Units of numbers whose message says none.
void require_units(const Log& log, const ReadOptions& options, topics::Topic& topic) {
  const auto without = topics::give_units(options.units, topic);
  if (without.empty()) return;
  refuse(log, say("states no unit for {} of topic {}; give it: --set unit.{}=rad/s",
                  Name{fmt::format("'{}'", fmt::join(without, "', '"))}, Name{topic.name},
                  Name{topic.columns.front().name()}));
}

Stream stream_of(const Topic& from, const topics::Topic& topic) {
  Stream stream{from, find_message_type(from.type)};
  for (const topics::Column& column : topic.columns) {
    const std::size_t number = column.offset / sizeof(double);
    const auto part = std::ranges::find_if(
        stream.type->parts, [&](const Part& each) { return number >= each.first && number < each.first + each.count; });
    stream.numbers.push_back({number, part->covariance});
  }
  return stream;
}

}  // namespace

std::vector<Topic> topics_of(const Log& log) {
  Topics topics;
  for (const auto& [id, connection] : log.connections) {
    const auto same = std::ranges::find_if(topics, [&, &c = connection](const Topic& topic) {
      return topic.name == c.topic && topic.type == c.type && topic.encoding == c.encoding;
    });
    Topic& topic = same == topics.end()
                       ? topics.emplace_back(Topic{connection.topic, connection.type, connection.encoding, {}, {}})
                       : *same;
    topic.connections.push_back(id);
    if (const auto count = log.counts.find(id); count != log.counts.end()) topic.count.add(count->second);
  }
  std::ranges::stable_sort(topics, {}, &Topic::name);
  return topics;
}

Sentence described(const Topic& topic) {
  std::vector<Sentence> about{topic.type.empty() ? Sentence("no type") : say("{}", Name{topic.type})};
  if (topic.encoding == Encoding::other && find_message_type(topic.type)) about.push_back("neither ROS 1 nor CDR");
  if (const double rate = topic.count.rate(); rate > 0.0) about.push_back(say("{:.4g} Hz", rate));
  const std::size_t count = topic.count.messages;
  if (count > 0) about.push_back(count == 1 ? say("{} message", count) : say("{} messages", count));
  return say("{} ({})", Name{topic.name}, in_a_row(about, ", "));
}

Sentence described(const std::vector<Topic>& topics) {
  constexpr std::size_t most = 24;
  std::vector<Sentence> some;
  for (std::size_t i = 0; i < std::min(most, topics.size()); ++i) some.push_back(described(topics[i]));
  const Sentence all = in_a_row(some, ", ");
  return topics.size() > most ? say("{} and {} more", all, topics.size() - most) : all;
}

std::vector<Stream> choose_streams(Log& log, const ReadOptions& options, topics::Log& to) {
  const Topics chosen = options.topics.empty() ? read_by_default(log) : named(log, options.topics);
  for (const Topic& topic : chosen) {
    const auto alike = std::ranges::count_if(chosen, [&](const Topic& other) { return other.type == topic.type; });
    to.topics.push_back(topic_of(log, topic, alike > 1));
    to.topics.back().source = to.topics.size() - 1;
  }
  topics::name_columns(to.topics);
  std::vector<std::string> channels;
  for (const topics::Topic& topic : to.topics)
    for (const topics::Column& column : topic.columns) channels.push_back(column.name());
  topics::keep_columns(options.only, to.topics);
  if (to.topics.empty())
    refuse(log,
           say("has no channel '{}'; its channels are {}", fmt::join(options.only, "', '"), fmt::join(channels, ", ")));
  Topics wanted;
  std::vector<Stream> streams;
  for (topics::Topic& topic : to.topics) {
    require_units(log, options, topic);
    streams.push_back(stream_of(chosen[topic.source], topic));
    wanted.push_back(streams.back().topic);
  }
  to.wanted = described(wanted);
  return streams;
}

}  // namespace tumble::ros
