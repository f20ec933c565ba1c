#include "tumble/formats/ros/samples.hpp"

#include <algorithm>
#include <functional>
#include <mutex>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

#include "tumble/math/parallel.hpp"
#include "tumble/units/error.hpp"

namespace tumble::ros {
namespace {

using topics::Samples;

constexpr std::uint64_t large = std::uint64_t{64} << 20;  ///< [bytes] of a piece that is handed out in parts
constexpr std::size_t part_samples = 65536;

/// Which stream a connection belongs to.
class Directory {
 public:
  explicit Directory(const std::vector<Stream>& streams) {
    for (std::size_t i = 0; i < streams.size(); ++i)
      for (const std::uint32_t id : streams[i].topic.connections) streams_[id] = static_cast<int>(i);
  }
  /// -1: none.
  int stream_of(std::uint32_t connection) const {
    const auto found = streams_.find(connection);
    return found == streams_.end() ? -1 : found->second;
  }

 private:
  std::map<std::uint32_t, int> streams_;
};

/// Windows that no thread uses now: the one that was used last is still in the cache of its processor.
class IdleWindows {
 public:
  Window take() {
    const std::lock_guard lock(guard_);
    if (idle_.empty()) return {};
    Window window = std::move(idle_.back());
    idle_.pop_back();
    return window;
  }
  void give(Window window) {
    const std::lock_guard lock(guard_);
    idle_.push_back(std::move(window));
  }

 private:
  std::mutex guard_;
  std::vector<Window> idle_;
};

/// Fills the samples of one stream, message after message.
class Filler {
 public:
  void add(const Stream& stream, const Message& message, Samples& to) {
    Body body;
    const std::string_view bytes = is_packed(message.bytes) ? unpacked(message.bytes, room_) : message.bytes;
    if (!decode(bytes, stream.topic.encoding, stream.type->numbers, body)) {
      ++to.unreadable;
      return;
    }
    if (to.count == to.stamps.size()) make_longer(stream, to);
    if (body.frame != frame_id_) [[unlikely]]
      take_frame(body.frame, to);
    to.stamps[to.count] = body.stamp;
    to.received[to.count] = message.time;
    for (const Lane& lane : lanes_) lane.values[to.count] = body.number(lane.number);
    ++to.count;
    if (!all_measured_) note_measured(stream, body, to.measured);
  }

 private:
  /// Where the numbers of a column go, and which they are of a message.
  struct Lane {
    double* values;
    std::size_t number;
  };

  void take_frame(std::string_view name, Samples& to) {
    if (frame_id_.empty())
      to.frame = printable(frame_id_ = name);
    else if (to.other_frame.empty())
      to.other_frame = printable(name);
  }

  void note_measured(const Stream& stream, const Body& body, std::vector<char>& measured) {
    all_measured_ = true;
    for (std::size_t i = 0; i < measured.size(); ++i) {
      const int covariance = stream.numbers[i].covariance;
      measured[i] |= covariance < 0 || body.number(static_cast<std::size_t>(covariance)) != -1.0;
      all_measured_ = all_measured_ && measured[i] != 0;
    }
  }

  void make_longer(const Stream& stream, Samples& to) {
    const std::size_t size = std::max<std::size_t>(1024, 2 * to.count);
    to.stamps.resize(size);
    to.received.resize(size);
    lanes_.clear();
    for (std::size_t i = 0; i < stream.numbers.size(); ++i) {
      to.values[i].resize(size);
      lanes_.push_back({to.values[i].data(), stream.numbers[i].index});
    }
  }

  std::vector<char> room_;  ///< for a message that is packed by itself
  std::string frame_id_;    ///< the bytes of the frame of the first message
  std::vector<Lane> lanes_;
  bool all_measured_ = false;
};

/// What one piece gives.
struct Slot {
  topics::Stretch stretch;
  std::vector<Filler> fillers;  ///< by stream
  std::map<std::uint32_t, Count> counts;
  std::optional<std::string> damage;

  explicit Slot(const std::vector<Stream>& streams) : stretch(streams.size()), fillers(streams.size()) {
    for (std::size_t i = 0; i < streams.size(); ++i) {
      stretch[i].values.resize(streams[i].numbers.size());
      stretch[i].measured.assign(streams[i].numbers.size(), 0);
    }
  }
  void clear() {
    for (Samples& samples : stretch) samples.count = samples.unreadable = 0;
  }
};

/// Reads one piece into a slot. `full` is called where a stream has `part_samples`, unless it is empty.
void read_piece(const Log& log, const Piece& piece, const std::vector<Stream>& streams, const Directory& directory,
                IdleWindows& windows, Slot& slot, const std::function<void()>& full) {
  slot.clear();
  slot.damage.reset();
  std::uint32_t last = 0;
  int stream = directory.stream_of(last);
  Count* count = nullptr;
  const auto turn_to = [&](std::uint32_t connection) {
    if (connection == last && count) return;
    last = connection;
    stream = directory.stream_of(connection);
    count = &slot.counts[connection];
  };
  Visitor visitor;
  visitor.wants = [&](std::uint32_t connection) {
    turn_to(connection);
    return stream >= 0;
  };
  visitor.message = [&](const Message& message) {
    turn_to(message.connection);
    count->add(message.time);
    if (stream < 0) return;
    const auto index = static_cast<std::size_t>(stream);
    slot.fillers[index].add(streams[index], message, slot.stretch[index]);
    if (slot.stretch[index].count < part_samples || !full) return;
    full();
    slot.clear();
  };
  Window window = windows.take();
  try {
    log.visit(log, piece, window, visitor);
  } catch (const Error& error) {
    slot.damage = error.what();
    // Where a CRC could have told sound bytes from others, and did not come to it, none is used.
    if (piece.crc != 0 && !piece.cut) slot.clear();
  } catch (const Untrusted& untrusted) {
    slot.damage = untrusted.reason;
    slot.clear();
  }
  windows.give(std::move(window));
}

bool is_large(const Piece& piece) { return std::max(piece.size, piece.unpacked) > large; }

/// As many slots as pieces are read together, at least one.
std::vector<Slot> slots_for(const std::vector<Stream>& streams, std::size_t pieces) {
  const std::size_t at_once = std::size_t{8} * std::max(1u, std::thread::hardware_concurrency());
  std::vector<Slot> slots;
  for (std::size_t i = 0; i < std::min(at_once, std::max<std::size_t>(1, pieces)); ++i) slots.emplace_back(streams);
  return slots;
}

}  // namespace

ScanReport scan(const Log& log, const std::vector<Stream>& streams, const topics::Take& take,
                const Progress& progress) {
  const Directory directory(streams);
  IdleWindows windows;
  std::vector<Slot> slots = slots_for(streams, log.pieces.size());
  ScanReport result;
  const auto note = [&](const Slot& slot, const Piece& piece) {
    if (!slot.damage || piece.cut) return;
    if (result.damaged++ > 0) return;
    result.first_place = piece.begin;
    result.first_reason = *slot.damage;
  };
  for (std::size_t next = 0; next < log.pieces.size();) {
    report(progress, static_cast<double>(next) / static_cast<double>(log.pieces.size()), "reading");
    if (is_large(log.pieces[next])) {
      const topics::Stretch* const stretch = &slots[0].stretch;
      read_piece(log, log.pieces[next], streams, directory, windows, slots[0], [&] { take({&stretch, 1}); });
      take({&stretch, 1});
      note(slots[0], log.pieces[next++]);
      continue;
    }
    std::size_t end = next;
    while (end < log.pieces.size() && end - next < slots.size() && !is_large(log.pieces[end])) ++end;
    parallel_for(end - next, [&](std::size_t i) {
      read_piece(log, log.pieces[next + i], streams, directory, windows, slots[i], {});
    });
    std::vector<const topics::Stretch*> stretches;
    for (std::size_t i = 0; i < end - next; ++i) {
      stretches.push_back(&slots[i].stretch);
      note(slots[i], log.pieces[next + i]);
    }
    take(stretches);
    next = end;
  }
  for (const Slot& slot : slots)
    for (const auto& [id, count] : slot.counts) result.counts[id].add(count);
  return result;
}

}  // namespace tumble::ros
