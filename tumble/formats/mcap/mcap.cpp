// MCAP, version 0: mcap.dev/spec.

#include "tumble/formats/mcap/mcap.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "tumble/formats/file/number_at.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/mcap/records.hpp"
#include "tumble/formats/ros/recording.hpp"
#include "tumble/formats/topics/read.hpp"
#include "tumble/units/error.hpp"

namespace tumble::mcap {
namespace {

using ros::Window;

constexpr std::string_view magic("\x89MCAP0\r\n", 8);
constexpr std::uint64_t piece_size = std::uint64_t{1} << 20;  ///< [bytes] of messages outside of chunks

bool recognises(const std::string& path) { return file::begins_with(path, magic); }

ros::Packing packing_of(const std::string& name) {
  if (name.empty() || name == "none") return ros::Packing::none;
  if (name == "lz4") return ros::Packing::lz4;
  if (name == "zstd") return ros::Packing::zstandard;
  throw Error{Error::Kind::bad_file,
              say("a chunk is packed by '{}'; none, lz4 and zstd are read", ros::printable(name))};
}

/// Messages and channels in a chunk, or between chunks.
void visit(const ros::Log& log, const ros::Piece& piece, Window& window, const ros::Visitor& visitor) try {
  window.open(*log.file, piece);
  for (Record record; next_record(window, record);) {
    if (record.op == Op::message) {
      ros::Message message = take_message_header(window, record);
      const std::uint64_t rest = record.size - message_header;
      if (rest <= Window::longest && visitor.wants && visitor.wants(message.connection)) {
        message.bytes = {take(window, rest), static_cast<std::size_t>(rest)};
      } else {
        skip(window, rest);
      }
      visitor.message(message);
    } else if (record.op == Op::schema && visitor.type) {
      const auto [id, name] = take_schema(window, record);
      visitor.type(id, name);
    } else if (record.op == Op::channel && visitor.connection) {
      const auto [id, connection] = take_channel(window, record);
      visitor.connection(id, connection);
    } else {
      skip(window, record.size);
    }
  }
  if (piece.packing != ros::Packing::none && window.position() != piece.unpacked)
    throw Error{Error::Kind::bad_file,
                say("it holds {} bytes, where its header states {}", window.position(), piece.unpacked)};
  if (!window.crc_agrees()) throw ros::Untrusted{"its CRC does not agree with its bytes, of which none is used"};
} catch (const Cut&) {
  throw Error{Error::Kind::bad_file, "a record in it is longer than the rest of it"};
}

/// Walks over the records of a file without unpacking any.
class Walk {
 public:
  explicit Walk(ros::Log& log) : log_(log), size_(log.file->size()) {}

  void whole() {
    try {
      window_.open(*log_.file, {magic.size(), size_ - magic.size(), 0, ros::Packing::none}, near);
      over();
      end_piece(at_);
      if (!footer_ && !log_.pieces.empty()) say(Finding::Severity::info, "log_not_closed", {});
    } catch (const Cut&) {
      end_piece(at_);
      say(Finding::Severity::warning, "log_ends_in_record", {{"size", std::to_string(size_)}});
    } catch (const Error& error) {
      end_piece(at_);
      say(Finding::Severity::warning, "log_records_damaged",
          {{"place", std::to_string(at_)}, {"reason", std::string(error.what())}});
    }
  }

 private:
  static constexpr std::size_t near = 4096, far = 262144;  ///< [bytes] read at once between chunks, and of messages

  void say(Finding::Severity severity, const char* code, std::vector<FindingValue> values) {
    log_.findings.push_back({severity, code, std::move(values), log_.path});
  }

  std::uint64_t position() const { return magic.size() + window_.position(); }

  void over() {
    for (;;) {
      at_ = position();
      Record record;
      if (!next_record(window_, record)) return;
      footer_ = footer_ || record.op == Op::footer;
      if (record.op == Op::footer) return;  // the magic at the end follows
      take_record(record);
    }
  }

  void take_record(const Record& record) {
    if (record.op != Op::message && record.op != Op::schema && record.op != Op::channel) end_piece(at_);
    switch (record.op) {
      case Op::message:
        return take_message(record);
      case Op::schema:
        log_.types.insert(take_schema(window_, record));
        return;
      case Op::channel:
        log_.connections.insert(take_channel(window_, record));
        return;
      case Op::chunk:
        return take_chunk(record);
      case Op::message_index:
        return take_index(record);
      default:
        skip(window_, record.size);
    }
  }

  /// Messages outside of chunks: neighbours are a piece.
  void take_message(const Record& record) {
    if (begin_ == 0 || at_ - begin_ > piece_size) {
      end_piece(at_);
      begin_ = at_;
      window_.read_ahead(far);
    }
    const ros::Message message = take_message_header(window_, record);
    skip(window_, record.size - message_header);
    log_.counts[message.connection].add(message.time);
  }

  void end_piece(std::uint64_t end) {
    if (begin_ > 0 && end > begin_) log_.pieces.push_back({begin_, end - begin_, end - begin_, {}, true, false});
    begin_ = 0;
    window_.read_ahead(near);
  }

  void take_chunk(const Record& record) {
    const ChunkHeader header = take_chunk_header(window_, record);
    const std::uint64_t begin = position();
    const std::uint64_t size = std::min<std::uint64_t>(header.packed, size_ - begin);
    log_.pieces.push_back(
        {begin, size, header.unpacked, packing_of(header.compression), false, size < header.packed, header.crc});
    if (log_.pieces.back().packing == ros::Packing::none) log_.pieces.back().unpacked = size;
    skip(window_, header.packed);
  }

  /// Messages of one channel in the chunk before: time and place of each.
  void take_index(const Record& record) {
    constexpr std::uint64_t fixed = 6, entry = 16;  // channel, length of the entries
    if (record.size < fixed + entry || (record.size - fixed) % entry != 0 || log_.pieces.empty())
      return skip(window_, record.size);
    const std::uint32_t channel = file::number_at<std::uint16_t>(take(window_, fixed));
    const std::uint64_t entries = (record.size - fixed) / entry;
    ros::Count count{entries - (entries == 1 ? 1 : 2)};
    count.add(time_at(take(window_, entry)));
    if (entries > 1) {
      skip(window_, (entries - 2) * entry);
      count.add(time_at(take(window_, entry)));
    }
    log_.counts[channel].add(count);
    log_.pieces.back().counted = true;
  }

  ros::Log& log_;
  std::uint64_t size_;
  std::uint64_t at_ = 0;
  std::uint64_t begin_ = 0;  ///< of messages outside of chunks; 0: there are none here
  bool footer_ = false;
  Window window_;
};

}  // namespace

ros::Log open(const std::string& path) {
  ros::Log log;
  log.path = path;
  log.file = std::make_shared<const file::InputFile>(path);
  log.visit = visit;
  char bytes[magic.size()];
  if (std::string_view(bytes, log.file->read_at(0, bytes, sizeof bytes)) != magic)
    throw Error{Error::Kind::bad_file, say("'{}' is not an MCAP file: it does not begin with its eight bytes", path)};
  Walk(log).whole();
  return log;
}

namespace {

topics::Log open_topics(const std::string& path, const ReadOptions& options, bool checksum) {
  return ros::topics_log(open(path), options, checksum);
}

}  // namespace

extern const Format mcap{
    .name = "mcap",
    .summary = "MCAP log of ROS 1 or ROS 2: IMU, magnetic field, temperature and pressure messages",
    .extensions = {".mcap"},
    .recognises = recognises,
    .read = topics::read_file<open_topics>,
    .memory = topics::memory_of_file<open_topics>,
    .stream = topics::stream_file<open_topics>};

}  // namespace tumble::mcap
