#pragma once

#include <functional>
#include <string>

#include "tumble/recorder/recorder_read.hpp"
#include "tumble/recorder/recorder_stream.hpp"
#include "tumble/station/link.hpp"

namespace tumble {

/// A stream of one instrument that is to become a file.
struct RecordRequest {
  std::string instrument;  ///< NAME[:VARIANTS] of a shipped declaration, or of a file that ends in .toml
  LinkAddress link;        ///< what a serial line leaves open is as the declaration says
  std::string output;      ///< recording to write; while it is recorded, its store lies in a folder beside it
  double duration = 0.0;   ///< [s]; 0: until somebody ends it
  double silence = 10.0;   ///< [s] without a byte after which the link counts as lost
  bool start = true;       ///< send the commands of the declaration that start the stream, and those that stop it
  bool keep = false;       ///< the store, once it is sealed
};

/// How far a recording is.
struct RecordView {
  double elapsed = 0.0;  ///< [s]
  double on_disk = 0.0;  ///< [s] up to which everything is acknowledged
  const InstrumentRecorder* instrument = nullptr;
  StoreLoad load;
};

/// Functions that a recording gets from its caller: clocks, display, end.
struct RecordWorld {
  std::function<double()> clock;                     ///< [s] monotonic
  std::function<std::string()> wall;                 ///< UTC, "2026-03-01T12:00:00Z"
  std::function<bool()> ended;                       ///< somebody wants it to end
  std::function<void(const RecordView&)> show = {};  ///< about ten times a second
  std::function<void()> sealing = {};                ///< the stream has ended, its file is being made
  Disk* disk = nullptr;                              ///< that it records on; null: one of its own
};

struct RecordOutcome {
  Sentence ending;    ///< "complete", or why it ended before
  bool whole = true;  ///< it ended because its time was over, or somebody wanted it to
  SealedRecording sealed;
  std::string store;  ///< the folder of the store, where it is kept; empty: removed
};

/// The folder in which the store of a recording lies until it is sealed: fog.h5 has fog.run.
std::string store_folder_of(const std::string& output);

/// Records a stream: opens the link, starts the instrument, keeps what arrives, and seals it. What was recorded is
/// sealed too where the link is lost or the disk is full; where that cannot be done, the store remains.
///
/// Throws    Error::bad_input: a declaration or link that cannot be; Error::bad_file: a link that does not open, an
///           output or a store that is there already, a disk that refuses; Error::bad_data: an instrument that does not
///           answer as declared, a stream without a frame
RecordOutcome record(const RecordRequest& request, const RecordWorld& world);

}  // namespace tumble
