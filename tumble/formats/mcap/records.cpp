#include "tumble/formats/mcap/records.hpp"

#include <fmt/format.h>

#include <limits>
#include <string_view>

#include "tumble/formats/file/number_at.hpp"
#include "tumble/units/error.hpp"

namespace tumble::mcap {
namespace {

[[noreturn]] void no_record(const Sentence& reason) { throw Error{Error::Kind::bad_file, reason}; }

/// The fields of a record, one after the other.
struct Fields {
  ros::Window& window;
  std::uint64_t remaining;

  const char* bytes(std::uint64_t count) {
    if (count > remaining) no_record("a field is longer than its record");
    remaining -= count;
    return take(window, count);
  }
  template <class Number>
  Number number() {
    return file::number_at<Number>(bytes(sizeof(Number)));
  }
  std::string text() {
    const std::uint64_t length = number<std::uint32_t>();
    if (length > 4096) no_record(say("a name of {} bytes", length));
    return {bytes(length), static_cast<std::size_t>(length)};
  }
  void rest() { skip(window, remaining); }
};

ros::Encoding encoding_of(std::string_view name) {
  if (name == "ros1") return ros::Encoding::ros1;
  return name == "cdr" ? ros::Encoding::cdr : ros::Encoding::other;
}

}  // namespace

const char* take(ros::Window& window, std::uint64_t count) {
  const char* const bytes = window.take(count);
  if (!bytes) throw Cut{};
  return bytes;
}

void skip(ros::Window& window, std::uint64_t count) {
  if (!window.skip(count)) throw Cut{};
}

bool next_record(ros::Window& window, Record& record) {
  if (window.at_end()) return false;
  const char* const bytes = take(window, 9);
  record = {static_cast<Op>(*bytes), file::number_at<std::uint64_t>(bytes + 1)};
  if (record.op == Op{0}) no_record("a record of the kind 0");
  return true;
}

std::pair<std::uint32_t, std::string> take_schema(ros::Window& window, const Record& record) {
  Fields fields{window, record.size};
  const auto id = fields.number<std::uint16_t>();
  const std::string name = ros::plain_type(ros::printable(fields.text()));
  fields.rest();
  return {id, name};
}

std::pair<std::uint32_t, ros::Connection> take_channel(ros::Window& window, const Record& record) {
  Fields fields{window, record.size};
  const auto id = fields.number<std::uint16_t>();
  ros::Connection connection;
  connection.type_id = fields.number<std::uint16_t>();
  connection.topic = ros::printable(fields.text());
  connection.encoding = encoding_of(fields.text());
  fields.rest();
  return {id, connection};
}

std::int64_t time_at(const char* bytes) {
  const auto time = file::number_at<std::uint64_t>(bytes);
  if (time > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()))
    no_record("the time of a message lies beyond the year 2262");
  return static_cast<std::int64_t>(time);
}

ros::Message take_message_header(ros::Window& window, const Record& record) {
  if (record.size < message_header) no_record(say("a message of {} bytes", record.size));
  const char* const bytes = take(window, message_header);
  return {file::number_at<std::uint16_t>(bytes), time_at(bytes + 6), {}};
}

ChunkHeader take_chunk_header(ros::Window& window, const Record& record) {
  Fields fields{window, record.size};
  fields.bytes(16);  // first and last time
  ChunkHeader header;
  header.unpacked = fields.number<std::uint64_t>();
  header.crc = fields.number<std::uint32_t>();
  header.compression = fields.text();
  header.packed = fields.number<std::uint64_t>();
  if (header.packed != fields.remaining)
    no_record(say("a chunk of {} bytes in a record with room for {}", header.packed, fields.remaining));
  return header;
}

}  // namespace tumble::mcap
