#include "tumble/formats/ros/stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>

#include "tumble/core/settings.hpp"
#include "tumble/units/error.hpp"

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

Topics named(Log& log, const std::vector<std::string>& names) {
  const Topics topics = topics_of(log);
  std::vector<std::string> known;
  Problems problems;
  for (const Topic& topic : topics) known.push_back(topic.name);
  Topics chosen;
  for (const std::string& name : names) {
    const auto alike = [&](const Topic& topic) { return without_slash(topic.name) == without_slash(name); };
    const auto present = std::ranges::find_if(topics, alike);
    const auto found =
        std::ranges::find_if(topics, [&](const Topic& topic) { return alike(topic) && readable(topic); });
    if (present == topics.end())
      problems.push_back(say("'{}' has no topic '{}'{}; its topics are {}", log.path, name, did_you_mean(name, known),
                             described(topics)));
    else if (found == topics.end())
      problems.push_back(say("'{}': topic {} is of a type that is not read; those that are read are {}", log.path,
                             described(*present), Name{known_message_types()}));
    else if (std::ranges::none_of(chosen, [&](const Topic& topic) { return topic.name == found->name; }))
      chosen.push_back(*found);
  }
  if (!problems.empty()) throw Error{Error::Kind::bad_file, problems};
  return chosen;
}

std::vector<Column> columns_of(const Topic& topic, bool several) {
  std::vector<Column> columns;
  for (const Part& part : find_message_type(topic.type)->parts) {
    const std::string own = part.name;
    const std::string name =
        own.empty() ? as_prefix(topic.name) : (several ? as_prefix(topic.name) + "." : std::string()) + own;
    const Unit unit = *part.unit == '\0' ? Unit() : Unit::parse(part.unit);
    for (std::size_t i = 0; i < part.count; ++i)
      columns.push_back({part.count == 1 ? name : name + '.' + "xyz"[i], unit, part.first + i, part.covariance});
  }
  return columns;
}

/// Numbers whose message says no unit.
void give_units(const Log& log, const ReadOptions& options, Stream& stream) {
  if (*stream.type->parts.front().unit != '\0') return;
  std::string without;
  for (Column& column : stream.columns) {
    const auto given = options.units.find(column.name);
    if (given != options.units.end())
      column.unit = given->second;
    else
      without += (without.empty() ? "'" : ", '") + column.name + "'";
  }
  if (without.empty()) return;
  refuse(log, say("states no unit for {} of topic {}; give it: --set unit.{}=rad/s", Name{without},
                  Name{stream.topic.name}, Name{stream.columns.front().name}));
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

std::vector<Stream> choose_streams(Log& log, const ReadOptions& options) {
  const Topics chosen = options.topics.empty() ? read_by_default(log) : named(log, options.topics);
  std::vector<Stream> streams;
  std::vector<std::string> channels;
  for (const Topic& topic : chosen) {
    const auto alike = std::ranges::count_if(chosen, [&](const Topic& other) { return other.type == topic.type; });
    Stream stream{topic, find_message_type(topic.type), columns_of(topic, alike > 1)};
    for (const Column& column : stream.columns) channels.push_back(column.name);
    if (!options.only.empty())
      std::erase_if(stream.columns, [&](const Column& column) {
        return std::ranges::find(options.only, column.name) == options.only.end();
      });
    if (stream.columns.empty()) continue;
    give_units(log, options, stream);
    streams.push_back(std::move(stream));
  }
  if (streams.empty())
    refuse(log,
           say("has no channel '{}'; its channels are {}", fmt::join(options.only, "', '"), fmt::join(channels, ", ")));
  return streams;
}

}  // namespace tumble::ros
