#pragma once

#include <map>
#include <utility>

#include "tumble/station/recorder/store_file.hpp"

namespace tumble::recorder {

/// Items that were appended and wait for their commit. Not safe for several threads.
class Front {
 public:
  Front(const StoreFile::State& state, const RecorderOptions& options)
      : last_(state.last),
        time_(state.time),
        links_(state.links),
        streams_(state.streams),
        chunk_bytes_(options.chunk_bytes),
        commit_bytes_(options.commit_bytes) {}

  std::size_t add_link(const StoreLink& link);
  std::size_t add_stream(const StoreStream& stream);
  void set(const std::string& name, const std::string& value) { batch_.facts[name] = value; }
  /// Items as Recorder takes them; time [s].
  std::uint64_t raw(std::size_t link, StoreDirection direction, double time, std::string_view bytes);
  std::uint64_t sample(std::size_t stream, const StoreSample& sample);
  std::uint64_t event(const StoreEvent& event);
  std::uint64_t journal(const JournalRow& row);

  bool empty() const { return batch_.empty() && open_.empty(); }
  bool urgent() const { return urgent_; }                 ///< much waits, or something happened
  std::size_t bytes() const { return bytes_; }            ///< that wait
  double time() const { return time_; }                   ///< [s] the latest
  std::uint64_t items() const { return items_; }          ///< in all
  std::uint64_t all_bytes() const { return all_bytes_; }  ///< in all
  /// Everything, and nothing waits any longer.
  Batch take();
  /// Puts a batch back that could not be written, before what was appended since.
  void put_back(Batch batch);

 private:
  template <class Put>
  std::uint64_t append(StoreItem::Kind kind, std::size_t source, double time, bool whole, Put put);

  Batch batch_;
  std::map<std::pair<StoreItem::Kind, std::size_t>, Chunk> open_;
  std::uint64_t last_, items_ = 0, all_bytes_ = 0;
  double time_;
  std::size_t links_, streams_;
  std::size_t chunk_bytes_, commit_bytes_, bytes_ = 0;
  bool urgent_ = false;
};

}  // namespace tumble::recorder
