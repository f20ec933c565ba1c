#pragma once

#include <cstdint>
#include <string>

#include "tumble/formats/ros/log.hpp"

namespace tumble::rosbag {

enum class Op : std::uint8_t { none = 0, message = 2, bag = 3, index = 4, chunk = 5, chunk_info = 6, connection = 7 };

/// The header of a record; its data follow.
struct Record {
  Op op = Op::none;
  std::uint32_t connection = 0;
  std::int64_t time = 0;        ///< [ns]
  std::uint64_t index_pos = 0;  ///< [bytes] 0: no index was written
  std::uint64_t chunk_pos = 0;  ///< [bytes]
  std::uint32_t size = 0;       ///< [bytes] of a chunk, unpacked
  std::string topic, compression;
  std::uint32_t data = 0;  ///< [bytes] that follow
};

/// The header of a message: of the next one mostly the time alone differs.
struct HeaderOfMessage {
  static constexpr std::size_t most = 64;  ///< [bytes] of a header that is kept
  char bytes[most] = {};
  std::size_t length = 0;  ///< [bytes] 0: none is known
  std::size_t time = 0;    ///< [bytes] where its time stands
  std::uint32_t connection = 0;
};

/// Takes the header of the next record. False at the end of the window. Throws Error::bad_file, the bare reason, where
/// no record stands; `Cut` where the bytes end within it.
/// Given  known  the header of the message before, which is kept up to date
bool next_record(ros::Window& window, Record& record, HeaderOfMessage& known);
bool next_record(ros::Window& window, Record& record);

/// Takes the data of a connection record. Throws as next_record().
ros::Connection take_connection(ros::Window& window, const Record& record);

/// The bytes end within a record.
struct Cut {};

}  // namespace tumble::rosbag
