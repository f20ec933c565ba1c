#include "tumble/formats/rosbag/records.hpp"

#include <fmt/format.h>

#include <cstring>
#include <string_view>

#include "tumble/formats/file/number_at.hpp"
#include "tumble/units/error.hpp"

namespace tumble::rosbag {
namespace {

[[noreturn]] void no_record(const Sentence& reason) { throw Error{Error::Kind::bad_file, reason}; }

/// Bytes that the record says it has.
const char* take(ros::Window& window, std::size_t count) {
  const char* const bytes = window.take(count);
  if (!bytes) throw Cut{};
  return bytes;
}

/// Calls use(name, value) for each field of a header: length, name=value.
template <class Use>
void each_field(std::string_view header, Use use) {
  while (!header.empty()) {
    if (header.size() < 4) no_record("the header of a record is damaged");
    const std::size_t length = file::number_at<std::uint32_t>(header.data());
    if (length > header.size() - 4) no_record("the header of a record is damaged");
    const std::string_view field = header.substr(4, length);
    std::size_t equals = 0;  // after a few letters: a call of memchr takes longer
    while (equals < length && field[equals] != '=') ++equals;
    if (equals == length) no_record("the header of a record is damaged");
    use(field.substr(0, equals), field.substr(equals + 1));
    header.remove_prefix(4 + length);
  }
}

std::int64_t time_at(const char* bytes) {
  return std::int64_t{1'000'000'000} * file::number_at<std::uint32_t>(bytes) +
         file::number_at<std::uint32_t>(bytes + 4);
}

constexpr std::size_t time_size = 8;

/// Whether nothing but the time differs from the header that is known.
bool repeats(const HeaderOfMessage& known, std::string_view header) {
  if (header.size() != known.length) return false;
  const std::size_t behind = known.time + time_size;
  return std::memcmp(header.data(), known.bytes, known.time) == 0 &&
         std::memcmp(header.data() + behind, known.bytes + behind, known.length - behind) == 0;
}

/// Keeps the header of a message with one time.
void keep(std::string_view header, const Record& record, HeaderOfMessage& known) {
  constexpr std::string_view name("\x0d\0\0\0time=", 9);
  known.length = 0;
  const auto at = header.find(name);
  if (record.op != Op::message || header.size() > HeaderOfMessage::most || at == header.npos ||
      header.find(name, at + 1) != header.npos || header.size() < at + name.size() + time_size)
    return;
  std::memcpy(known.bytes, header.data(), header.size());
  known.length = header.size();
  known.time = at + name.size();
  known.connection = record.connection;
}

/// A field of a record other than a message.
void take_other_field(Record& record, std::string_view name, std::string_view value) {
  const char* const bytes = value.data();
  if (name == "size" && value.size() == 4) record.size = file::number_at<std::uint32_t>(bytes);
  if (name == "index_pos" && value.size() == 8) record.index_pos = file::number_at<std::uint64_t>(bytes);
  if (name == "chunk_pos" && value.size() == 8) record.chunk_pos = file::number_at<std::uint64_t>(bytes);
  if (name == "compression") record.compression = value;
  if (name == "topic") record.topic = value;
}

void take_field(Record& record, std::string_view name, std::string_view value) {
  const char* const bytes = value.data();
  if (value.size() == 8 && name == "time")
    record.time = time_at(bytes);
  else if (value.size() == 4 && name == "conn")
    record.connection = file::number_at<std::uint32_t>(bytes);
  else if (value.size() == 1 && name == "op")
    record.op = static_cast<Op>(*bytes);
  else
    take_other_field(record, name, value);
}

}  // namespace

bool next_record(ros::Window& window, Record& record) {
  HeaderOfMessage unknown;
  return next_record(window, record, unknown);
}

bool next_record(ros::Window& window, Record& record, HeaderOfMessage& known) {
  if (window.at_end()) return false;
  const std::size_t length = file::number_at<std::uint32_t>(take(window, 4));
  if (length == 0 || length > ros::Window::longest)
    no_record(say("{} bytes for the header of a record, where 1 to {} are expected", length, ros::Window::longest));
  const std::string_view header(take(window, length), length);
  if (repeats(known, header)) {
    record.op = Op::message;
    record.connection = known.connection;
    record.time = time_at(header.data() + known.time);
  } else {
    record = {};
    each_field(header, [&](std::string_view name, std::string_view value) { take_field(record, name, value); });
    keep(header, record, known);
  }
  record.data = file::number_at<std::uint32_t>(take(window, 4));
  if (record.op < Op::message || record.op > Op::connection)
    no_record(say("a record of the unknown kind {}", static_cast<int>(record.op)));
  return true;
}

ros::Connection take_connection(ros::Window& window, const Record& record) {
  ros::Connection connection{ros::printable(record.topic), "", ros::Encoding::ros1};
  // The definition of the message may be long: only the fields before it count, and they are short.
  if (record.data > ros::Window::longest) no_record("a connection with a definition that is too long");
  each_field({take(window, record.data), record.data}, [&](std::string_view name, std::string_view value) {
    if (name == "type") connection.type = ros::plain_type(ros::printable(value));
    if (name == "topic" && connection.topic.empty()) connection.topic = ros::printable(value);
  });
  return connection;
}

}  // namespace tumble::rosbag
