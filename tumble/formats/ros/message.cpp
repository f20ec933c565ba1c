#include "tumble/formats/ros/message.hpp"

#include "tumble/formats/file/number_at.hpp"
#include "tumble/formats/file/utf8.hpp"

namespace tumble::ros {
namespace {

// Order of the numbers: common_interfaces/sensor_msgs/msg, geometry_msgs/msg.
const std::vector<MessageType>& message_types() {
  static const std::vector<MessageType> types{
      {"sensor_msgs/Imu", 37, {{"gyro", "rad/s", 13, 3, 16}, {"accelerometer", "m/s^2", 25, 3, 28}}},
      {"sensor_msgs/MagneticField", 12, {{"magnetometer", "T", 0, 3}}},
      {"sensor_msgs/Temperature", 2, {{"temperature", "degC", 0, 1}}},
      {"sensor_msgs/FluidPressure", 2, {{"pressure", "Pa", 0, 1}}},
      {"geometry_msgs/Vector3Stamped", 3, {{"", "", 0, 3}}},
  };
  return types;
}

constexpr std::size_t longest_name = 256;  ///< [bytes]
constexpr std::int64_t nanoseconds = 1'000'000'000;

bool decode_ros1(std::string_view bytes, std::size_t numbers, Body& body) {
  constexpr std::size_t fixed = 16;  // seq, stamp.secs, stamp.nsecs, length of frame_id
  if (bytes.size() < fixed) return false;
  const std::size_t length = file::number_at<std::uint32_t>(bytes.data() + 12);
  if (bytes.size() - fixed < length || bytes.size() - fixed - length != 8 * numbers) return false;
  body.stamp =
      nanoseconds * file::number_at<std::uint32_t>(bytes.data() + 4) + file::number_at<std::uint32_t>(bytes.data() + 8);
  body.frame = bytes.substr(fixed, length);
  body.numbers = bytes.data() + fixed + length;
  body.reversed = false;
  return true;
}

/// OMG DDS-RTPS 2.5, 10.5, and DDS-XTypes 1.3, 7.4: four bytes that say how it is written; from there on numbers stand
/// at multiples of their size, of no more than 4 in the second version. A string has its length with a zero at its end.
bool decode_cdr(std::string_view bytes, std::size_t numbers, Body& body) {
  constexpr std::size_t fixed = 12;  // stamp.sec, stamp.nanosec, length of frame_id
  if (bytes.size() < 4 + fixed || bytes[0] != 0) return false;
  const auto kind = static_cast<unsigned char>(bytes[1]);
  if (kind != 0 && kind != 1 && kind != 6 && kind != 7) return false;
  body.reversed = kind % 2 == 0;
  const std::size_t alignment = kind > 1 ? 4 : 8;
  bytes.remove_prefix(4);
  const auto word = [&](std::size_t at) { return file::number_at<std::uint32_t>(bytes.data() + at, body.reversed); };
  const std::size_t length = word(8);
  if (bytes.size() - fixed < length) return false;
  const std::size_t begin = (fixed + length + alignment - 1) / alignment * alignment;
  // Padding at the end, no more: else it is another message.
  if (bytes.size() < begin + 8 * numbers || bytes.size() > begin + 8 * numbers + 7) return false;
  body.stamp = nanoseconds * static_cast<std::int32_t>(word(0)) + word(4);
  body.frame = bytes.substr(fixed, length == 0 ? 0 : length - 1);
  body.numbers = bytes.data() + begin;
  return true;
}

}  // namespace

std::string plain_type(std::string_view name) {
  std::string plain(name);
  for (const std::string_view between : {"/msg/", "::msg::dds_::", "::msg::"})
    if (const auto at = plain.find(between); at != std::string::npos) plain.replace(at, between.size(), "/");
  if (name.find("::dds_::") != name.npos && plain.ends_with('_')) plain.pop_back();  // as DDS calls its types
  return plain;
}

std::string printable(std::string_view name) {
  std::string text(name.substr(0, longest_name));
  while (text.size() < name.size() && (static_cast<unsigned char>(name[text.size()]) & 0xC0) == 0x80 && !text.empty())
    text.pop_back();
  const bool letters = file::valid_utf8(text + ' ');
  for (char& letter : text) {
    const auto code = static_cast<unsigned char>(letter);
    if (code < 0x20 || code == 0x7f || (code > 0x7f && !letters)) letter = '?';
  }
  return text;
}

const MessageType* find_message_type(std::string_view name) {
  const std::string plain = plain_type(name);
  for (const MessageType& type : message_types())
    if (plain == type.name) return &type;
  return nullptr;
}

std::string known_message_types() {
  std::string text;
  for (const MessageType& type : message_types()) text += (text.empty() ? "" : ", ") + std::string(type.name);
  return text;
}

double Body::number(std::size_t index) const { return file::number_at<double>(numbers + 8 * index, reversed); }

bool decode(std::string_view bytes, Encoding encoding, std::size_t numbers, Body& body) {
  if (encoding == Encoding::ros1) return decode_ros1(bytes, numbers, body);
  return encoding == Encoding::cdr && decode_cdr(bytes, numbers, body);
}

}  // namespace tumble::ros
