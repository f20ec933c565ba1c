#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "tumble/formats/ros/log.hpp"

namespace tumble::mcap {

enum class Op : std::uint8_t {
  header = 1,
  footer = 2,
  schema = 3,
  channel = 4,
  message = 5,
  chunk = 6,
  message_index = 7,
  last = 15
};

struct Record {
  Op op = Op::header;
  std::uint64_t size = 0;  ///< [bytes] that follow
};

/// The bytes end within a record.
struct Cut {};

/// The next `count` bytes. Throws Cut where there are fewer.
const char* take(ros::Window& window, std::uint64_t count);
/// Passes over `count` bytes. Throws as take().
void skip(ros::Window& window, std::uint64_t count);

/// Takes the kind and the size of the next record. False at the end of the window. Throws Error::bad_file, the bare
/// reason, where no record stands; Cut.
bool next_record(ros::Window& window, Record& record);

/// The number and the name of a message type.
std::pair<std::uint32_t, std::string> take_schema(ros::Window& window, const Record& record);
/// The number of a channel, and what it is; its type is that of a schema, which may stand elsewhere.
std::pair<std::uint32_t, ros::Connection> take_channel(ros::Window& window, const Record& record);

constexpr std::uint64_t message_header = 22;  ///< [bytes] channel, sequence, log time, publish time
ros::Message take_message_header(ros::Window& window, const Record& record);

/// [ns] Throws Error::bad_file, the bare reason, beyond the year 2262.
std::int64_t time_at(const char* bytes);

struct ChunkHeader {
  std::uint64_t unpacked = 0, packed = 0;  ///< [bytes]
  std::uint32_t crc = 0;                   ///< of the unpacked bytes; 0: none
  std::string compression;
};
ChunkHeader take_chunk_header(ros::Window& window, const Record& record);

}  // namespace tumble::mcap
