#include "tumble/recorder/live_store/store_file.hpp"

#include <sqlite3.h>

#include <algorithm>

namespace tumble::live_store {

namespace {

constexpr const char* tables =
    "PRAGMA application_id = 1953853794; PRAGMA user_version = 2;"  // "tumb"
    "CREATE TABLE IF NOT EXISTS fact(name TEXT PRIMARY KEY, value TEXT);"
    "CREATE TABLE IF NOT EXISTS link(id INTEGER PRIMARY KEY, json TEXT);"
    "CREATE TABLE IF NOT EXISTS stream(id INTEGER PRIMARY KEY, json TEXT);"
    "CREATE TABLE IF NOT EXISTS chunk(first INTEGER PRIMARY KEY, last INTEGER, batch INTEGER, kind INTEGER,"
    " source INTEGER, count INTEGER, begin REAL, end REAL, crc INTEGER, body BLOB);";
constexpr std::uint64_t overhead = 256;  ///< bytes a row, about

/// The tables are there before anything is prepared; of a store that exists, that it is one.
Database opened(const std::string& path, const char* vfs, Database::Mode mode) {
  Database database(path, vfs, mode);
  Statement count(database, "SELECT COUNT(*) FROM sqlite_master");
  count.next();
  if (count.integer(0) == 0) {  // a new one, or one whose making was cut off
    count.next();
    database.run(std::string("BEGIN IMMEDIATE; ") + tables + " COMMIT");
    return database;
  }
  Statement version(database, "SELECT application_id, user_version FROM pragma_application_id, pragma_user_version");
  if (!version.next() || version.integer(0) != 1953853794 || (version.integer(1) != 1 && version.integer(1) != 2))
    throw Refusal{SQLITE_NOTADB, "it is an SQLite database, but not a live store of this version"};
  return database;
}

std::size_t next_number(const Database& database, const std::string& table) {
  Statement statement(database, "SELECT COUNT(*) FROM " + table);
  statement.next();
  return static_cast<std::size_t>(statement.integer(0));
}

}  // namespace

StoreFile::StoreFile(const std::string& path, const char* vfs, Database::Mode mode)
    : database_(opened(path, vfs, mode)),
      state_(read_state()),
      chunk_(database_, "INSERT INTO chunk VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"),
      link_(database_, "INSERT INTO link VALUES (?, ?)"),
      stream_(database_, "INSERT INTO stream VALUES (?, ?)"),
      fact_(database_, "INSERT OR REPLACE INTO fact VALUES (?, ?)") {}

void StoreFile::bring_up_to_date() {
  Statement version(database_, "SELECT user_version FROM pragma_user_version");
  if (!version.next() || version.integer(0) == 2) return;
  version.next();
  database_.run("PRAGMA user_version = 2");
}

/// Items of a batch come after all of the batches before, so the last batch has the last item.
StoreFile::State StoreFile::read_state() const {
  State state;
  Statement rows(database_, "SELECT batch, last, end FROM chunk ORDER BY first DESC");
  while (rows.next()) {
    const auto batch = static_cast<std::uint64_t>(rows.integer(0));
    if (state.batch != 0 && batch != state.batch) break;
    state.batch = batch;
    state.last = std::max(state.last, static_cast<std::uint64_t>(rows.integer(1)));
    state.time = std::max(state.time, rows.number(2));
  }
  state.links = next_number(database_, "link");
  state.streams = next_number(database_, "stream");
  return state;
}

void StoreFile::write(const Batch& batch) {
  database_.run("BEGIN IMMEDIATE");
  try {
    insert(batch);
    database_.run("COMMIT");
  } catch (const Refusal&) {
    if (!sqlite3_get_autocommit(database_.get())) sqlite3_exec(database_.get(), "ROLLBACK", nullptr, nullptr, nullptr);
    throw;
  }
  ++state_.batch;
  state_.last = batch.last;
  state_.time = batch.time;
}

void StoreFile::insert(const Batch& batch) {
  for (const auto& [number, json] : batch.links)
    link_.bind(1, static_cast<std::int64_t>(number)).bind_text(2, json).next();
  for (const auto& [number, json] : batch.streams)
    stream_.bind(1, static_cast<std::int64_t>(number)).bind_text(2, json).next();
  for (const auto& [name, value] : batch.facts) fact_.bind_text(1, name).bind_text(2, value).next();
  for (const Chunk& chunk : batch.chunks) {
    chunk_.bind(1, static_cast<std::int64_t>(chunk.first)).bind(2, static_cast<std::int64_t>(chunk.last));
    chunk_.bind(3, static_cast<std::int64_t>(state_.batch + 1)).bind(4, static_cast<std::int64_t>(chunk.kind));
    chunk_.bind(5, static_cast<std::int64_t>(chunk.source)).bind(6, static_cast<std::int64_t>(chunk.count));
    chunk_.bind(7, chunk.begin).bind(8, chunk.end);
    chunk_.bind(9, static_cast<std::int64_t>(checksum_of(chunk.body))).bind_bytes(10, chunk.body).next();
    since_checkpoint_ += chunk.body.size() + overhead;
  }
}

void StoreFile::checkpoint() {
  database_.checkpoint();
  since_checkpoint_ = 0;
}

}  // namespace tumble::live_store
