#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/unit_facts.hpp"
#include "tumble/recorder/disk.hpp"
#include "tumble/recorder/run_row.hpp"
#include "tumble/wire/frames.hpp"

namespace tumble {

/// Names in a run folder.
inline constexpr std::string_view live_store_name = "live.sqlite", reserve_name = "reserve";

/// Fact of a run about one slot: "sealed.a" is the checksum of its recording, as "unit a" is the serial number of its unit.
inline constexpr std::string_view sealed_fact = "sealed";

/// A link whose bytes are kept.
struct StoreLink {
  std::string name;  ///< "tcp:10.0.0.7:9000"
  std::string slot;  ///< of the unit that it serves; empty: of the only unit, or of the rig
  /// Declaration of the frames of an instrument and the variants, so that the bytes can be decoded again; empty for a
  /// link of another kind.
  std::string declaration, declaration_name;
  std::vector<std::string> variants;
};

/// Channels that are sampled together. After a link was lost and came back, its samples are another stream.
struct StoreStream {
  std::string name;  ///< of the instrument
  std::string slot;  ///< of the unit; empty: of the only unit, or of the rig
  std::vector<FrameChannel> channels;
  double rate = 0.0;                     ///< [Hz] declared, of the sequence; 0: not
  std::optional<std::size_t> link = {};  ///< whose bytes were decoded; streams of one link count in one sequence
};

enum class StoreDirection : std::uint8_t { received = 0, sent = 1 };

/// One sample of a stream.
struct StoreSample {
  double time = 0.0;               ///< [s] of the station's clock, at arrival
  std::optional<double> device;    ///< [s] of the clock of the device
  std::uint64_t sequence = 0;      ///< of the stream, lost ones counted; plus 2^40 for each restart of its counter
  std::span<const double> values;  ///< [SI] by channel of the stream; increments as they came
};

/// Something that happened.
struct StoreEvent {
  double time = 0.0;  ///< [s]
  EventKind kind = EventKind::notice;
  std::string who;  ///< a person, a device, a link; empty: the station
  Sentence text;
  std::string json;                    ///< any more, one JSON value; empty: no more
  std::optional<RunPhase> phase = {};  ///< that is entered
};

/// Up to where everything is on the disk: it survives the end of the process and a power cut.
struct Acknowledged {
  std::uint64_t sequence = 0;  ///< all items with lower or equal sequence numbers; 0: none yet
  double time = 0.0;           ///< [s] the latest time among these items
};

/// Why a recorder has stopped recording. What was acknowledged before is kept.
struct StoreFailure {
  enum class Kind { full, disk, overflow };
  Kind kind = Kind::disk;
  Sentence text;  ///< what happened, what is kept
};

/// How hard the recorder has to work.
struct StoreLoad {
  std::uint64_t items = 0, bytes = 0;  ///< appended in all
  std::uint64_t commits = 0;
  std::size_t most_pending = 0;  ///< [byte] that waited at once
  double longest_commit = 0.0;   ///< [s] measured on the clock given; 0 without one
};

struct RecorderOptions {
  double commit_after = 0.2;                             ///< [s] that an item waits at most before its commit begins
  std::size_t chunk_bytes = std::size_t{1} << 16;        ///< of a stream or link
  std::size_t commit_bytes = std::size_t{1} << 16;       ///< that wait, with a full chunk among them: committed at once
  std::size_t queue_bytes = std::size_t{1} << 26;        ///< that may wait; more stops the recording
  std::uint64_t reserve_bytes = std::uint64_t{1} << 26;  ///< kept free for the end record; 0: no reserve
  std::uint64_t floor_bytes = 0;  ///< of room below which the recording stops as if the disk were full
  std::size_t checkpoint_bytes = std::size_t{1} << 24;       ///< of the write-ahead log, before it is copied back
  bool resume = false;                                       ///< a store that is there is continued, else refused
  bool view = false;                                         ///< people may look at the samples while it records
  bool background = true;                                    ///< a thread writes; else the caller does, in flush()
  std::function<double()> clock = {};                        ///< [s] for StoreLoad alone
  std::function<void(const Acknowledged&)> on_commit = {};   ///< on the writing thread
  std::function<void(const StoreFailure&)> on_failure = {};  ///< once, on the writing thread
};

/// The live store of a run: raw bytes, samples, events and journal in one order, in an SQLite database. An item is
/// acknowledged after the commit that holds it was synchronised (docs/station_recorder.md). Safe to use from several
/// threads; the order is that of the calls.
///
/// Times are given by the caller: the recorder reads no clock.
class Recorder {
 public:
  /// Opens the store in the folder, which must exist. Throws Error::bad_file: a store that is there already, one that
  /// another process writes, no room, no permission.
  Recorder(const std::string& folder, Disk& disk, const RecorderOptions& options = {});
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;
  ~Recorder();  ///< writes what waits, without an end record

  std::size_t add_link(const StoreLink& link);
  std::size_t add_stream(const StoreStream& stream);
  /// A fact about the run, by name: written with the next commit. The last value of a name holds.
  void set(const std::string& name, const std::string& value);

  /// While one lives, nothing is committed: what its thread appends meanwhile is found whole after a power cut, or not at
  /// all. Bytes and the samples that they give are such a whole. Nobody flushes or closes while holding one.
  class Whole {
   public:
    explicit Whole(Recorder& recorder);
    Whole(const Whole&) = delete;
    Whole& operator=(const Whole&) = delete;
    ~Whole();

   private:
    Recorder& recorder_;
  };

  // The functions below return the sequence number of the item; 0: not recorded, because the recording has stopped, and
  // failure() says why.

  /// Bytes of a link as they were read or sent at `time` [s].
  std::uint64_t raw(std::size_t link, StoreDirection direction, double time, std::string_view bytes);
  std::uint64_t sample(std::size_t stream, const StoreSample& sample);
  std::uint64_t event(const StoreEvent& event);
  /// A row of the journal, written at `time` [s] of the clock of the store. Of the attempts at a segment in a power-up
  /// the last complete one counts; its data lie between `records` and `pauses`.
  std::uint64_t journal(double time, const RunRow& row);

  /// Waits until everything appended so far is acknowledged. False: the recording has stopped, or the disk has not
  /// answered `within` this time [s of the wall].
  bool flush(double within = std::numeric_limits<double>::infinity());
  Acknowledged acknowledged() const;
  std::optional<StoreFailure> failure() const;
  StoreLoad load() const;

  /// The end record at `time` [s], and everything before it, written; nothing may be appended after it. False: the
  /// recording has stopped before.
  bool close(double time, const Sentence& ending);

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

}  // namespace tumble
