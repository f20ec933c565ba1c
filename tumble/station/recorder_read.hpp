#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tumble/core/progress.hpp"
#include "tumble/core/recording.hpp"
#include "tumble/station/disk.hpp"
#include "tumble/station/recorder.hpp"

namespace tumble {

/// An item of a live store.
struct StoreItem {
  enum class Kind { raw, sample, event, journal };
  Kind kind = Kind::raw;
  std::uint64_t sequence = 0;
  double time = 0.0;       ///< [s] of the station's clock
  std::size_t source = 0;  ///< index of the link or stream
  StoreDirection direction = StoreDirection::received;
  std::string_view bytes;  ///< raw
  StoreSample sample;      ///< sample
  const StoreEvent* event = nullptr;
  const JournalRow* journal = nullptr;
};

/// Description of a live store: its links, streams and facts.
struct StoreContent {
  std::vector<StoreLink> links;
  std::vector<StoreStream> streams;
  std::map<std::string, std::string> facts;  ///< that Recorder::set wrote
  std::uint64_t items = 0;                   ///< items handed out
  std::uint64_t damaged = 0;                 ///< chunks whose checksum does not hold: not handed out
};

/// Hands out all items of a store in their order. `run`: its folder, or the file of the store.
/// Throws Error::bad_file: no store, a store that a process is still writing, not a store.
StoreContent visit_store(const std::string& run, const std::function<void(const StoreItem&)>& visit);

/// Hands out the events of a store alone, in their order: quick however long the run was. Throws as visit_store().
StoreContent visit_events(const std::string& run,
                          const std::function<void(std::uint64_t sequence, const StoreEvent&)>& visit);

/// The recording of one unit.
struct StoreRecording {
  std::string slot;  ///< empty: there is only one unit
  Recording recording;
};

/// The recordings of a live store: one for each slot; a slot has the streams without a slot too. Samples are even on
/// the clock of the device where its counter shows every lost sample, and these are missing (NaN); else each has the
/// stamp of its arrival. Marks are the last finished attempts. Findings say what was lost, repeated and damaged, with
/// counts from the bytes themselves.
///
/// Throws    Error::bad_file as visit_store(); Error::bad_data for a store without samples
std::vector<StoreRecording> read_store(const std::string& run, const Progress& progress = {});

/// Writes the bytes that were received, as they came, into a file: they can be decoded again by another declaration.
/// Throws Error::bad_file as visit_store() or where it cannot be written; Error::bad_data for a store of several links.
/// Returns their number.
std::uint64_t write_raw(const std::string& run, const std::string& file);

struct SealedRecording {
  std::string slot, path, sha256;
  Findings findings;  ///< of the recording
};

/// Writes the recordings of a run into HDF5: to NAME.part, synchronised, renamed, the folder synchronised, read back,
/// and only then noted as sealed in the store. Sealing again gives the same bytes.
///
/// Given     run     its folder
///           target  file to write, where there is only one unit; empty: as the store says, else RUN/recording.h5.
///                   Where there are several units, each gets a file, NAME-SLOT.h5
///
/// Throws    as read_store(); Error::bad_file where it cannot be written, or what was written reads otherwise
std::vector<SealedRecording> seal(const std::string& run, Disk& disk, const std::string& target = {},
                                  const Progress& progress = {});

}  // namespace tumble
