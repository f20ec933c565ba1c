#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string_view>

#include "tumble/formats/file/number_at.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/ros/recording.hpp"
#include "tumble/formats/rosbag/records.hpp"
#include "tumble/formats/topics/read.hpp"
#include "tumble/units/error.hpp"

namespace tumble::rosbag {
namespace {

using ros::Window;

constexpr std::string_view signature = "#ROSBAG V";
constexpr std::string_view version = "#ROSBAG V2.0\n";

bool recognises(const std::string& path) { return file::begins_with(path, signature); }

ros::Packing packing_of(const std::string& name) {
  if (name == "none" || name.empty()) return ros::Packing::none;
  if (name == "lz4") return ros::Packing::lz4;
  if (name == "bz2") return ros::Packing::bzip2;
  throw Error{Error::Kind::bad_file,
              say("a chunk is packed by '{}'; none, lz4 and bz2 are read", ros::printable(name))};
}

/// Messages and connections in a chunk.
void visit(const ros::Log& log, const ros::Piece& piece, Window& window, const ros::Visitor& visitor) try {
  window.open(*log.file, piece);
  HeaderOfMessage known;
  for (Record record; next_record(window, record, known);) {
    if (record.op == Op::message) {
      ros::Message message{record.connection, record.time, {}};
      const bool wanted = record.data <= Window::longest && visitor.wants && visitor.wants(record.connection);
      if (wanted) {
        const char* const bytes = window.take(record.data);
        if (!bytes) throw Cut{};
        message.bytes = {bytes, record.data};
      } else if (!window.skip(record.data)) {
        throw Cut{};
      }
      visitor.message(message);
    } else if (record.op == Op::connection && visitor.connection) {
      visitor.connection(record.connection, take_connection(window, record));
    } else if (!window.skip(record.data)) {
      throw Cut{};
    }
  }
  if (window.position() != piece.unpacked)
    throw Error{Error::Kind::bad_file,
                say("it holds {} bytes, where its header states {}", window.position(), piece.unpacked)};
} catch (const Cut&) {
  throw Error{Error::Kind::bad_file, "a record in it is longer than the rest of it"};
}

/// Walks over the records of a file without unpacking any.
class Walk {
 public:
  explicit Walk(ros::Log& log) : log_(log), size_(log.file->size()) {}

  void whole() {
    std::uint64_t from = version.size();
    std::string reason;
    try {
      over(from);
      if (index_pos_ == 0 && !log_.pieces.empty())
        log_.findings.push_back({Finding::Severity::info, "log_not_closed", {}, log_.path});
      return;
    } catch (const Cut&) {
      reason = "cut";
    } catch (const Error& error) {
      reason = error.what();
    }
    if (reason == "cut" && (index_pos_ == 0 || index_pos_ >= size_)) return cut_off();
    if (reason == "cut") reason = "a record is longer than the rest of the file";
    log_.findings.push_back({Finding::Severity::warning,
                             "log_records_damaged",
                             {{"place", std::to_string(at_)}, {"reason", reason}},
                             log_.path});
    from_index();
  }

 private:
  void cut_off() {
    log_.findings.push_back(
        {Finding::Severity::warning, "log_ends_in_record", {{"size", std::to_string(size_)}}, log_.path});
  }

  void over(std::uint64_t from) {
    window_.open(*log_.file, {from, size_ - from, 0, ros::Packing::none}, 4096);
    for (;;) {
      at_ = from + window_.position();
      Record record;
      if (!next_record(window_, record)) return;
      take(record, from);
    }
  }

  void take(const Record& record, std::uint64_t from) {
    std::uint64_t rest = record.data;
    if (record.op == Op::bag) index_pos_ = record.index_pos;
    if (record.op == Op::chunk) add_piece(record, from + window_.position());
    if (record.op == Op::index) rest -= count(record);
    if (record.op == Op::chunk_info) starts_.push_back(record.chunk_pos);
    if (record.op == Op::connection) {
      log_.connections.emplace(record.connection, take_connection(window_, record));
      return;
    }
    if (!window_.skip(rest)) throw Cut{};
  }

  void add_piece(const Record& record, std::uint64_t begin) {
    const std::uint64_t size = std::min<std::uint64_t>(record.data, size_ - begin);
    if (!seen_.insert(begin).second) return;
    log_.pieces.push_back({begin, size, record.size, packing_of(record.compression), false, size < record.data});
  }

  /// The messages of the chunk before, by the index that follows it: time and place of each. Returns the bytes taken.
  std::uint64_t count(const Record& record) {
    constexpr std::uint32_t entry = 12;
    if (record.data < entry || record.data % entry != 0 || log_.pieces.empty()) return 0;
    const auto time = [&] {
      const char* const bytes = window_.take(entry);
      if (!bytes) throw Cut{};
      return std::int64_t{1'000'000'000} * file::number_at<std::uint32_t>(bytes) +
             file::number_at<std::uint32_t>(bytes + 4);
    };
    ros::Count count{record.data / entry - (record.data == entry ? 1 : 2)};
    count.add(time());
    if (record.data > entry) {
      if (!window_.skip(record.data - 2 * entry)) throw Cut{};
      count.add(time());
    }
    log_.counts[record.connection].add(count);
    log_.pieces.back().counted = true;
    return record.data;
  }

  /// Where a record in the middle is damaged, the index at the end says where the chunks after it begin.
  void from_index() {
    const std::uint64_t damage = at_;
    if (index_pos_ <= damage || index_pos_ >= size_) return;
    try {
      over(index_pos_);
    } catch (const Cut&) {
    } catch (const Error&) {
    }
    std::sort(starts_.begin(), starts_.end());
    for (const std::uint64_t start : starts_)
      if (start > damage && start < index_pos_) one_chunk(start);
  }

  void one_chunk(std::uint64_t start) try {
    window_.open(*log_.file, {start, size_ - start, 0, ros::Packing::none}, 4096);
    Record record;
    if (next_record(window_, record) && record.op == Op::chunk) add_piece(record, start + window_.position());
  } catch (const Cut&) {
  } catch (const Error&) {
  }

  ros::Log& log_;
  std::uint64_t size_;
  std::uint64_t at_ = 0;
  std::uint64_t index_pos_ = 0;
  std::vector<std::uint64_t> starts_;
  std::set<std::uint64_t> seen_;
  Window window_;
};

ros::Log open(const std::string& path) {
  ros::Log log;
  log.path = path;
  log.file = std::make_shared<const file::InputFile>(path);
  log.visit = visit;
  char bytes[version.size()];
  const std::string_view found(bytes, log.file->read_at(0, bytes, sizeof bytes));
  if (found != version) {
    const bool bag = found.starts_with(signature);
    throw Error{Error::Kind::bad_file,
                say("'{}' is not a ROS bag of version 2.0: its first line is not '#ROSBAG V2.0'{}", path,
                    bag ? "; convert it with `rosbag migrate` or the rosbags package" : "")};
  }
  Walk(log).whole();
  return log;
}

topics::Log open_topics(const std::string& path, const ReadOptions& options, bool checksum) {
  return ros::topics_log(open(path), options, checksum);
}

}  // namespace

extern const Format rosbag{.name = "rosbag",
                           .summary = "ROS 1 bag: IMU, magnetic field, temperature and pressure messages",
                           .extensions = {".bag"},
                           .recognises = recognises,
                           .read = topics::read_file<open_topics>,
                           .memory = topics::memory_of_file<open_topics>,
                           .stream = topics::stream_file<open_topics>};

}  // namespace tumble::rosbag
