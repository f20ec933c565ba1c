#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tumble/core/finding.hpp"
#include "tumble/formats/ros/message.hpp"
#include "tumble/formats/ros/window.hpp"

namespace tumble::ros {

/// Publisher of a topic; a topic may have several.
struct Connection {
  std::string topic, type;  ///< "/imu/data", "sensor_msgs/Imu"
  Encoding encoding = Encoding::other;
  std::uint32_t type_id = 0;  ///< where the type is empty: its number in Log::types
};

/// How many messages, and when they were received.
struct Count {
  std::size_t messages = 0;
  std::int64_t first = std::numeric_limits<std::int64_t>::max();    ///< [ns]
  std::int64_t last = std::numeric_limits<std::int64_t>::lowest();  ///< [ns]

  void add(std::int64_t time);  ///< [ns]
  void add(const Count& other);
  double rate() const;  ///< [Hz]; 0 where it cannot be said
};

struct Message {
  std::uint32_t connection = 0;
  std::int64_t time = 0;   ///< [ns] when it was received
  std::string_view bytes;  ///< empty where the connection is not wanted
};

/// Functions that get the contents of a piece.
struct Visitor {
  std::function<bool(std::uint32_t connection)> wants;  ///< whether its bytes are of use
  std::function<void(const Message&)> message;
  std::function<void(std::uint32_t id, const Connection&)> connection;
  std::function<void(std::uint32_t id, const std::string& name)> type;
};

/// A file of messages: what it says of itself, and where its messages stand. Or several files: see joined().
struct Log {
  std::string path;
  std::shared_ptr<const file::InputFile> file;  ///< null where it has parts
  std::vector<Log> parts;
  std::map<std::uint32_t, Connection> connections;
  std::map<std::uint32_t, std::string> types;
  std::map<std::uint32_t, Count> counts;  ///< of the pieces that are counted
  std::vector<Piece> pieces;
  std::uint64_t messages_at_most = 0;  ///< of a file without counts: an upper limit of them all; 0: it has counts
  Findings findings;
  /// Visits the messages of a piece in their order. Throws Error::bad_file, the bare reason, where it is damaged.
  std::function<void(const Log&, const Piece&, Window&, const Visitor&)> visit;
};

/// [bytes] of the file, or of all files.
std::uint64_t size_of(const Log& log);
/// The SHA-256 of the file; of several files that of a text with the SHA-256 and the name of each. It is calculated
/// beside other work: the function returned waits for it.
std::function<std::string()> checksum_of(const Log& log);

/// Looks into the pieces that no index describes, so that all connections are known, and all counts of a file that has
/// some.
void look_into_uncounted(Log& log);
/// Counts the messages of a file without counts.
void count_messages(Log& log);

}  // namespace tumble::ros
