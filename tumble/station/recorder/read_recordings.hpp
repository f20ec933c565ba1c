#pragma once

#include <string>
#include <vector>

#include "tumble/formats/format.hpp"
#include "tumble/station/recorder/run_reader.hpp"
#include "tumble/station/recorder/slot_reader.hpp"
#include "tumble/station/recorder/store_file.hpp"
#include "tumble/station/recorder_read.hpp"

namespace tumble::recorder {

/// The recordings of a store that was looked through once, except for their samples.
class StoreReading {
 public:
  /// The store must live as long. Throws Refusal; Error::bad_data for a store without samples. `path`: for messages.
  StoreReading(const StoreFile& store, const std::string& path, const Progress& progress);

  /// The slots that have samples.
  const std::vector<std::string>& slots() const { return names_; }
  const StoreContent& content() const { return content_; }
  /// Hands out the recording of a slot, by its number, in blocks of about `samples` of a channel; the first has marks,
  /// facts and findings too. A recording without even clocks is one block. Throws Refusal.
  void stream(std::size_t slot, std::size_t samples, const BlockSink& sink);
  /// All recordings in memory; can be asked once. Throws Refusal.
  std::vector<StoreRecording> recordings(const Progress& progress);

 private:
  Recording next_of(std::size_t slot);

  const StoreFile& store_;
  StoreContent content_;
  RunReader run_;
  std::vector<std::string> names_;
  std::vector<SlotReader> slots_;
};

}  // namespace tumble::recorder
