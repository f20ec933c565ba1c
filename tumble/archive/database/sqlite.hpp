#pragma once

#include <string>
#include <unordered_map>

#include "tumble/archive/database/value.hpp"
#include "tumble/formats/sqlite.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::database {

/// An archive in a file. All functions throw Refusal.
class Sqlite {
 public:
  /// `create`: an empty one, where there is no file.
  Sqlite(const std::string& path, bool create);
  void rows(const std::string& sql, const Row& values, const RowSink& sink);
  void script(const std::string& sql);
  std::int64_t changed() const;  ///< rows that the last INSERT wrote
  /// Problems of the file itself; empty: it is sound.
  Problems damage();

 private:
  SqliteHandle handle_;
  std::unordered_map<std::string, SqliteStatement> statements_;
};

}  // namespace tumble::database
