#include "tumble/recorder/live_store/database.hpp"

#include <sqlite3.h>

#include "tumble/formats/confinement.hpp"

namespace tumble::live_store {

/// Exclusive locking comes first: with it the write-ahead log needs no shared memory, and no second connection can
/// write or checkpoint. A full synchronisation follows every commit. Pages are as large as the rows, which are chunks.
Database::Database(const std::string& path, const char* vfs, Mode mode) {
  require_contained(path);
  require_own_journals(path);
  sqlite3* handle = nullptr;
  const int create = mode == Mode::create ? SQLITE_OPEN_CREATE : 0;
  const int code = sqlite3_open_v2(path.c_str(), &handle, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX | create, vfs);
  handle_.reset(handle);
  if (code != SQLITE_OK) refuse_sqlite(handle, code);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  run("PRAGMA page_size = 16384; PRAGMA locking_mode = EXCLUSIVE; PRAGMA journal_mode = WAL; "
      "PRAGMA synchronous = FULL; PRAGMA wal_autocheckpoint = 0; PRAGMA cache_size = -8192; PRAGMA mmap_size = 0");
}

void Database::run(const std::string& sql) {
  const int code = sqlite3_exec(handle_.get(), sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) refuse_sqlite(handle_.get(), code);
}

void Database::checkpoint() {
  const int code = sqlite3_wal_checkpoint_v2(handle_.get(), nullptr, SQLITE_CHECKPOINT_PASSIVE, nullptr, nullptr);
  if (code != SQLITE_OK) refuse_sqlite(handle_.get(), code);
}

void Database::keep_log() { sqlite3_db_config(handle_.get(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr); }

}  // namespace tumble::live_store
