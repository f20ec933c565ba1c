#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tumble::ros {

/// How a message is written as bytes.
enum class Encoding { ros1, cdr, other };

/// Neighbouring numbers of a message that are channels: a vector, or one number.
struct Part {
  const char* name;     ///< of the channel, "gyro"; empty: as the topic is called
  const char* unit;     ///< as REP 103 and the definition of the message say; empty: it has none
  std::size_t first;    ///< index of the first number
  std::size_t count;    ///< 3: .x, .y, .z
  int covariance = -1;  ///< index of the number that is -1 where the instrument does not measure this; -1: none
};

/// A message that is read: a std_msgs/Header, then float64 numbers.
struct MessageType {
  const char* name;     ///< "sensor_msgs/Imu"
  std::size_t numbers;  ///< after the header
  std::vector<Part> parts;
};

/// Null where messages of this type are not read. Given: "sensor_msgs/Imu", also as "sensor_msgs/msg/Imu".
const MessageType* find_message_type(std::string_view name);
/// "sensor_msgs/Imu, sensor_msgs/MagneticField"
std::string known_message_types();
/// "sensor_msgs/Imu" for "sensor_msgs/msg/Imu".
std::string plain_type(std::string_view name);

/// A name as it may be shown: ASCII, of at most 256 characters.
std::string printable(std::string_view name);

/// Contents of the bytes of a message.
struct Body {
  std::int64_t stamp = 0;  ///< [ns] header.stamp
  std::string_view frame;  ///< header.frame_id
  const char* numbers = nullptr;
  bool reversed = false;  ///< the numbers are big-endian

  double number(std::size_t index) const;  ///< [as written]
};

/// False where the bytes are not a message with so many numbers.
bool decode(std::string_view bytes, Encoding encoding, std::size_t numbers, Body& body);

}  // namespace tumble::ros
