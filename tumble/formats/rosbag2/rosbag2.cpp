// ROS 2 bag in SQLite: rosbag2_storage_sqlite3, schema versions 1 to 4; tables `topics` and `messages`.

#include <fmt/format.h>

#include <filesystem>
#include <string_view>

#include "tumble/formats/format.hpp"
#include "tumble/formats/mcap/mcap.hpp"
#include "tumble/formats/ros/joined.hpp"
#include "tumble/formats/ros/recording.hpp"
#include "tumble/formats/rosbag2/database.hpp"
#include "tumble/formats/rosbag2/folder.hpp"
#include "tumble/formats/topics/read.hpp"
#include "tumble/units/error.hpp"

namespace tumble::rosbag2 {
namespace {

constexpr std::string_view magic("SQLite format 3\0", 16);
constexpr std::uint64_t rows_at_once = 16384;

bool is_database(const std::string& path) { return file::begins_with(path, magic); }

bool recognises(const std::string& path) {
  std::error_code problem;
  return std::filesystem::is_directory(path, problem) ? is_folder_of_bag(path) : is_database(path);
}

/// The rows of a piece, in the order in which they were written.
void visit(const ros::Log& log, const ros::Piece& piece, ros::Window&, const ros::Visitor& visitor) {
  std::string wanted;
  for (const auto& [id, connection] : log.connections)
    if (visitor.wants && visitor.wants(id)) wanted += (wanted.empty() ? "" : ",") + std::to_string(id);
  const Database database(log.path);
  // Only what is asked for is brought from its pages.
  Query query(database,
              "SELECT topic_id, timestamp, " +
                  (wanted.empty() ? std::string("NULL") : "CASE WHEN topic_id IN (" + wanted + ") THEN data END") +
                  " FROM messages WHERE id BETWEEN ?1 AND ?2 ORDER BY id");
  const auto begin = static_cast<std::int64_t>(piece.begin);
  query.bind(1, begin);
  query.bind(2, begin + static_cast<std::int64_t>(piece.size - 1));
  while (query.next())
    visitor.message({static_cast<std::uint32_t>(query.integer(0)), query.integer(1), query.bytes(2)});
}

void find_topics(const Database& database, ros::Log& log) {
  Query query(database, "SELECT id, name, type, serialization_format FROM topics");
  while (query.next()) {
    const std::int64_t id = query.integer(0);
    if (id < 0 || id > 0xffffffff) continue;
    ros::Connection connection{ros::printable(query.bytes(1)), ros::plain_type(ros::printable(query.bytes(2))),
                               query.bytes(3) == "cdr" ? ros::Encoding::cdr : ros::Encoding::other};
    log.connections.emplace(static_cast<std::uint32_t>(id), connection);
  }
}

/// Rows by their number. Numbers far apart are one piece, which is read by one thread.
void find_pieces(const Database& database, ros::Log& log) {
  constexpr std::uint64_t smallest_row = 8;  // bytes in the file
  Query query(database, "SELECT (SELECT min(id) FROM messages), (SELECT max(id) FROM messages)");
  if (!query.next() || query.is_null(0)) return;
  const std::int64_t first = query.integer(0), last = query.integer(1);
  const std::uint64_t numbers = static_cast<std::uint64_t>(last) - static_cast<std::uint64_t>(first) + 1;
  const std::uint64_t most = log.file->size() / smallest_row;
  log.messages_at_most = std::max<std::uint64_t>(1, std::min(numbers == 0 ? most : numbers, most));
  if (first < 0 || numbers > 4 * most) {
    // Packed size: as a piece that is handed out in parts.
    log.pieces.push_back({static_cast<std::uint64_t>(first), numbers, ~std::uint64_t{0}, {}, true, false});
    return;
  }
  for (std::uint64_t done = 0; done < numbers; done += rows_at_once) {  // the last number may be the greatest of all
    const std::uint64_t size = std::min(rows_at_once, numbers - done);
    log.pieces.push_back({static_cast<std::uint64_t>(first) + done, size, size, {}, true, false});
  }
}

std::uint64_t big_endian(const char* bytes, std::size_t count) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

/// SQLite fills what is missing of a page with zeros, which would be samples. (SQLite, file format, 1.3: size of a
/// page, number of pages, and whether that number is up to date.)
void require_all_pages(const file::InputFile& file) {
  char head[100];
  if (file.read_at(0, head, sizeof head) < sizeof head) throw Error{Error::Kind::bad_file, "its header is cut off"};
  const std::uint64_t stated = big_endian(head + 16, 2), page = stated == 1 ? 65536 : stated;
  const bool counted = big_endian(head + 24, 4) == big_endian(head + 92, 4);
  const std::uint64_t size = big_endian(head + 28, 4) * page;
  if ((counted && file.size() < size) || page == 0 || file.size() % page != 0)
    throw Error{Error::Kind::bad_file,
                say("it has {} bytes, where its header states {}: it is cut off or not completely copied; copy "
                    "it again, or take out what is there with `sqlite3 FILE .recover`",
                    file.size(), size)};
}

ros::Log open_database(const std::string& path) {
  ros::Log log;
  log.path = path;
  log.file = std::make_shared<const file::InputFile>(path);
  log.visit = visit;
  if (!is_database(path))
    throw Error{Error::Kind::bad_file, say("'{}' is not an SQLite database, as a ROS 2 bag (.db3) is", path)};
  try {
    require_all_pages(*log.file);
    const Database database(path);
    require_tables(database);
    find_topics(database, log);
    find_pieces(database, log);
  } catch (const Error& error) {
    throw Error{Error::Kind::bad_file, say("'{}' cannot be read as a ROS 2 bag: {}", path, reason_of(error))};
  }
  return log;
}

/// A file, or all files of a folder.
ros::Log open(const std::string& path) {
  std::error_code problem;
  if (!std::filesystem::is_directory(path, problem)) return open_database(path);
  std::vector<ros::Log> parts;
  for (const std::string& file : files_of_bag(path))
    parts.push_back(file.ends_with(".mcap") ? mcap::open(file) : open_database(file));
  return parts.size() == 1 ? std::move(parts.front()) : ros::joined(path, std::move(parts));
}

topics::Log open_topics(const std::string& path, const ReadOptions& options, bool checksum) {
  return ros::topics_log(open(path), options, checksum);
}

}  // namespace

extern const Format rosbag2{
    .name = "rosbag2",
    .summary = "ROS 2 bag, in SQLite or its folder: IMU, magnetic field, temperature and pressure messages",
    .extensions = {".db3"},
    .recognises = recognises,
    .read = topics::read_file<open_topics>,
    .memory = topics::memory_of_file<open_topics>,
    .stream = topics::stream_file<open_topics>,
    .folders = true};

}  // namespace tumble::rosbag2
