#pragma once

#include <string>

#include "tumble/formats/sqlite.hpp"

namespace tumble::live_store {

using Refusal = SqliteRefusal;
using Statement = SqliteStatement;

/// The only connection to a live store: it alone writes, checkpoints and locks. All functions throw Refusal.
class Database {
 public:
  enum class Mode { create, existing };
  Database(const std::string& path, const char* vfs, Mode mode);
  void run(const std::string& sql);
  /// Copies the write-ahead log back into the database.
  void checkpoint();
  /// Closing it does not copy the log back: for a disk that has failed.
  void keep_log();
  sqlite3* get() const { return handle_.get(); }
  operator sqlite3*() const { return handle_.get(); }

 private:
  SqliteHandle handle_;
};

}  // namespace tumble::live_store
