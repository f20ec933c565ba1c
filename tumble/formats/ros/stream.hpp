#pragma once

#include <string>
#include <vector>

#include "tumble/core/read_options.hpp"
#include "tumble/formats/ros/log.hpp"
#include "tumble/formats/topics/topic.hpp"

namespace tumble::ros {

/// A topic, with the connections that publish messages of one type to it.
struct Topic {
  std::string name, type;
  Encoding encoding = Encoding::other;
  std::vector<std::uint32_t> connections;
  Count count;
};

/// In the order of their names.
std::vector<Topic> topics_of(const Log& log);
/// "/imu/data (sensor_msgs/Imu, 400 Hz, 44000 messages)"
Sentence described(const Topic& topic);
Sentence described(const std::vector<Topic>& topics);

/// A number of a message that becomes a channel.
struct ReadNumber {
  std::size_t index = 0;
  int covariance = -1;  ///< as in Part
};

/// A topic that is read.
struct Stream {
  Topic topic;
  const MessageType* type = nullptr;
  std::vector<ReadNumber> numbers = {};  ///< by column
};

/// Chooses the topics that are read, and the numbers of them that are: they become the topics of `to`, which are in the
/// order of the streams that are returned.
///
/// Topics that the options name; else the only topic of sensor_msgs/Imu, and with it of each other known type the topic
/// that is the only one, or the only one beside the IMU's ("/imu/data", "/imu/temperature"). Throws Error::bad_file,
/// with all topics, where the options have to say which, or name one that is not there or cannot be read.
std::vector<Stream> choose_streams(Log& log, const ReadOptions& options, topics::Log& to);

}  // namespace tumble::ros
