#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tumble/station/recorder/chunk.hpp"
#include "tumble/station/recorder/database.hpp"

namespace tumble::recorder {

/// Contents of one commit.
struct Batch {
  std::vector<Chunk> chunks;
  std::vector<std::pair<std::size_t, std::string>> links, streams;  ///< number, JSON
  std::map<std::string, std::string> facts;
  std::uint64_t last = 0;  ///< sequence number of its last item, or of the one before where it has none
  double time = 0.0;       ///< [s] the latest time, or that of the batch before
  bool empty() const { return chunks.empty() && links.empty() && streams.empty() && facts.empty(); }
};

/// The database of a store: its tables, and one transaction a batch. All functions throw Refusal.
class StoreFile {
 public:
  StoreFile(const std::string& path, const char* vfs, Database::Mode mode);

  /// Commits a batch; returned, it is synchronised. Thrown, nothing of it is there.
  void write(const Batch& batch);
  /// [byte] written since the last checkpoint, about.
  std::uint64_t since_checkpoint() const { return since_checkpoint_; }
  void checkpoint();

  struct State {
    std::uint64_t last = 0, batch = 0;
    double time = 0.0;
    std::size_t links = 0, streams = 0;
  };
  const State& state() const { return state_; }
  const Database& database() const { return database_; }

 private:
  void insert(const Batch& batch);
  State read_state() const;

  Database database_;
  State state_;
  Statement chunk_, link_, stream_, fact_;
  std::uint64_t since_checkpoint_ = 0;
};

}  // namespace tumble::recorder
