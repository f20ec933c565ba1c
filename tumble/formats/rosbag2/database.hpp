#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace tumble::rosbag2 {

/// An SQLite database, open for reading only. All functions throw Error::bad_file, the bare reason.
class Database {
 public:
  explicit Database(const std::string& path);
  sqlite3* get() const { return handle_.get(); }

 private:
  struct Close {
    void operator()(sqlite3* handle) const;
  };
  std::unique_ptr<sqlite3, Close> handle_;
};

/// A statement and its rows.
class Query {
 public:
  Query(const Database& database, const std::string& sql);
  void bind(int parameter, std::int64_t value);  ///< from 1 on
  bool next();                                   ///< false after the last row
  std::int64_t integer(int column) const;        ///< from 0 on
  std::string_view bytes(int column) const;      ///< until next()
  bool is_null(int column) const;

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  const Database& database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

/// Throws where the tables of a ROS 2 bag are not there; the reason names those that are.
void require_tables(const Database& database);

}  // namespace tumble::rosbag2
